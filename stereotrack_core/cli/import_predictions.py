"""``stereotrack import predictions``: keypoints of a 2-D detector, into a project."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.keypoint_proposals import landmark_predictions
from stereotrack_core.cli.arguments import JSON, flag, option
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.cli.sources import open_project, recording_of
from stereotrack_core.counting import counted
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import stated_names
from stereotrack_core.project.project import Project
from stereotrack_core.recording.keypoint_names import LANDMARK_OF, LAYOUTS
from stereotrack_core.recording.keypoints import Keypoints, of_one_person
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Import keypoints that a 2-D detector has predicted. They are kept in a table of their own and "
    "never become clicks; importing a detector again replaces its keypoints. What is left out is "
    "counted and reported."
)

OPTIONS = (
    option(
        "file FILE",
        "a folder of OpenPose (of JSON files, or of one folder for each camera), COCO results or "
        "annotations (.json), MMPose or RTMPose (.json), FreeMoCap and MediaPipe (.npy, .csv), "
        "DeepLabCut (.csv, .h5), SLEAP predictions (.slp), or a table (.csv) of frame, view, "
        "keypoint, x, y, confidence",
        type=Path,
    ),
    option("--into PROJECT", "project (.stereotrack)", type=Path, required=True),
    option("--camera NAME", "camera or view of the keypoints, if the file does not state it"),
    option(
        "--layout",
        "order of the points of a file without names (default: by their number)",
        choices=tuple(LAYOUTS),
    ),
    option(
        "--name THEIRS=OURS",
        "keypoint here for a keypoint name in the file; may be given several times",
        action="append",
        default=[],
        dest="names",
    ),
    option("--detector NAME", "name of the detector (default: name of the file)"),
    flag(
        "--propose",
        "also propose them as clicks: in the workspace Annotate they are shown as predictions, "
        "which can be accepted",
    ),
    flag("--all-people", "keep all people (default: the surest person of each picture)"),
    JSON,
)


def run(args: Namespace) -> int:
    """Read, choose the person, and keep."""
    names = stated_names(args.names, "--name")
    with open_project(args.into, read_only=False) as project:
        recording = recording_of(project)
        with FrameReader(recording, read_ahead=0) as reader:
            frames = reader.frame_count
        source = KeypointSource(
            args.file, recording, args.camera, args.layout, names, args.detector or ""
        )
        found = read_keypoints(source, frames)
        kept = found.keypoints if args.all_people else of_one_person(found.keypoints)
        project.keypoints.replace(kept)
        proposed = _propose(project, of_one_person(kept)) if args.propose else 0
    facts = _facts(kept, dict(found.left_out), len(found.keypoints) - len(kept))
    facts = {"proposed": proposed, **facts} if args.propose else facts
    rows = [(key.replace("_", " "), str(value)) for key, value in facts.items()]
    rows[-1] = ("left out", _words(facts["left_out"]))
    table = Table(f"{args.file} into {args.into}", ("", ">"), rows)
    put_result(facts, table, as_json=args.json)
    return OK


def _propose(project: Project, keypoints: Keypoints) -> int:
    """Let them be predictions of landmarks; how many."""
    predictions = landmark_predictions(keypoints, project.landmark_set().names)
    count = 0
    for source in sorted({one.source for one in predictions}):
        own = [one for one in predictions if one.source == source]
        count += project.predictions.replace(source, own)
    return count


def _facts(kept: Keypoints, left_out: dict[str, int], others: int) -> dict[str, Any]:
    tells = [name in LANDMARK_OF for name in kept.keypoint.tolist()]
    if others:
        left_out["of other people"] = others
    return {
        "keypoints": len(kept),
        "of_landmarks": sum(tells),
        "frames": len(set(kept.frame.tolist())),
        "cameras": ", ".join(kept.cameras),
        "detectors": ", ".join(sorted(set(kept.source.tolist()))),
        "left_out": left_out,
    }


def _words(left_out: dict[str, int]) -> str:
    told = [f"{counted(count, 'keypoint')} {why}" for why, count in left_out.items()]
    return "; ".join(told) or "nothing"
