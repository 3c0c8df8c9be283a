"""``stereotrack import predictions``: keypoints of a 2-D detector, into a project."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, LAYOUT, PERSON, flag, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.sources import open_project, recording_of
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import stated_names
from stereotrack_core.project.detectors import plan_import, removal
from stereotrack_core.recording.keypoint_names import layout_named
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Import keypoints that a 2-D detector has predicted. They are kept in a table of their own and "
    "never become clicks; importing a detector again replaces its keypoints of the same cameras. "
    "What is left out is counted and reported."
)

OPTIONS = (
    option(
        "file FILE",
        "a folder of OpenPose (of JSON files, or of one folder for each camera), COCO results or "
        "annotations (.json), MMPose or RTMPose (.json), FreeMoCap and MediaPipe (.npy, .csv, "
        ".json), DeepLabCut (.csv, .h5), SLEAP predictions (.slp, analysis .h5), or a table "
        "(.csv) of frame, view, keypoint, x, y, confidence",
        type=Path,
        nargs="?",
    ),
    option("--into PROJECT", "project (.stereotrack)", type=Path, required=True),
    option("--camera NAME", "camera or view of the keypoints, if the file does not state it"),
    LAYOUT,
    PERSON,
    option(
        "--name THEIRS=OURS",
        "keypoint here for a keypoint name in the file; may be given several times",
        action="append",
        default=[],
        dest="names",
    ),
    option(
        "--detector NAME",
        "name of the detector (default: name of the file); files of single cameras need the same",
    ),
    flag(
        "--propose",
        "also propose them as clicks: in the workspace Annotate they are shown as predictions, "
        "which can be accepted",
    ),
    flag("--all-people", "keep all people instead of one"),
    option(
        "--remove DETECTOR",
        "instead of an import: remove the keypoints and proposals of a detector",
    ),
    JSON,
)


def run(args: Namespace) -> int:
    """Read, choose the person, and keep; or remove."""
    if (args.file is None) == (args.remove is None):
        raise InputError(
            "give either a file to import or --remove",
            where="import predictions",
            remedy="See `stereotrack import predictions --help`.",
        )
    if args.remove is not None:
        return _remove(args)
    names = stated_names(args.names, "--name")
    layout = None if args.layout is None else layout_named(args.layout)
    if args.all_people and args.person is not None:
        raise InputError(
            "all people are kept, or one", where="--person", remedy="Omit it or --all-people."
        )
    with open_project(args.into, read_only=False) as project:
        recording = recording_of(project)
        with FrameReader(recording, read_ahead=0) as reader:
            frames = reader.frame_count
        source = KeypointSource(
            args.file, recording, args.camera, layout, names, args.detector or ""
        )
        found = plan_import(
            project, (source,), frames,
            all_people=args.all_people, person=args.person, propose=args.propose,
        )  # fmt: skip
        project.keypoints.put(found.after)
    facts = found.facts()
    facts = {"proposed": found.proposed, **facts} if args.propose else facts
    rows = [(key.replace("_", " "), str(value)) for key, value in facts.items()]
    rows = [row for row in rows if row[0] not in ("left out", "notes")]
    rows.append(("left out", found.left_out_words()))
    for note in found.notes:
        say(f"{args.file}: {note}.")
    table = Table(f"{args.file} into {args.into}", ("", ">"), rows)
    put_result(facts, table, as_json=args.json)
    return OK


def _remove(args: Namespace) -> int:
    """Take what a detector has predicted out of a project."""
    with open_project(args.into, read_only=False) as project:
        known = project.keypoints.sources()
        if args.remove not in known:
            raise InputError(
                f"the project has no keypoints of {args.remove!r}",
                where="--remove",
                remedy=f"Its detectors: {', '.join(known) or 'none'}.",
            )
        project.keypoints.put(removal(project, args.remove)[1])
    facts = {"removed": known[args.remove]}
    table = Table(f"Removed from {args.into}", ("", ">"), [("keypoints", str(facts["removed"]))])
    put_result(facts, table, as_json=args.json)
    return OK
