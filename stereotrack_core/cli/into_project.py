"""Commands that write projects: ``project create``, ``import labels``, ``import predictions``."""

from argparse import Namespace
from dataclasses import replace
from typing import Any

from stereotrack_core.annotation.landmark_set import read_landmark_set
from stereotrack_core.cli import options, sources
from stereotrack_core.cli.output import OK, put_facts, say
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import Labels, LabelSource, stated_names
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.project.detectors import plan_import
from stereotrack_core.project.entries import choose, save_landmark_set, save_reference
from stereotrack_core.project.merging import Decision, clicks_of_project, incoming
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import LANDMARK_SET
from stereotrack_core.project.whereabouts import SUFFIX, project_path_for
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.keypoint_names import layout_named
from stereotrack_core.recording.reader import frame_count


@options.command(
    options.RECORDING,
    options.path(
        "-o --output PROJECT",
        f"file to write ({SUFFIX}); by default beside the recording folder, with its name and, "
        "where there is one already, a number",
    ),
    options.option("--annotator NAME", "whose clicks and edits they are"),
    options.path(
        "--landmarks FILE", "set of landmarks (.toml) that is clicked; by default the nine"
    ),
)
def create(args: Namespace) -> int:
    """Make a project of a recording: the file that keeps clicks, references and runs. Labels
    come in with `stereotrack import labels`, and `stereotrack open` shows it.
    """
    recording = open_recording(args.recording)
    path = args.output or project_path_for(recording.folder)
    options.check_suffix(path, SUFFIX)
    options.check_output(path, recording.folder)
    if path.exists():
        remedy = "Open it with `stereotrack open`, or choose another name with -o."
        raise InputError("there is such a file already", path, remedy)
    landmarks = None if args.landmarks is None else read_landmark_set(args.landmarks)
    with Project.create(path, recording.folder, who=args.annotator or "") as project:
        if landmarks is not None:
            project.apply(save_landmark_set(landmarks))
            project.apply(choose(LANDMARK_SET, landmarks.name))
        names = project.landmark_set().names
    facts = {"recording": recording.folder, "landmarks": list(names)}
    put_facts(facts, f"{path} was made", as_json=args.json, project=path)
    return OK


_SHOWN = 20


@options.command(
    options.path(
        "file FILE",
        "clicks (.csv), DeepLabCut labels (.csv), COCO keypoints (.json), SLEAP labels (.slp), "
        "another project of the recording (.stereotrack); or a trajectory (.csv with x, y and "
        "z, .trc, .c3d, .npz), which becomes a reference of the project",
    ),
    options.path("--into PROJECT", "project (.stereotrack)", required=True),
    options.option("--camera NAME", "camera or view of the labels (DeepLabCut, COCO)"),
    options.NAMES,
    options.AXES,
    options.option(
        "--conflicts",
        "which clicks to keep where the file contradicts the project: mine (the project's) or "
        "theirs (the file's); without this option, nothing is imported if there are conflicts",
        choices=("mine", "theirs"),
    ),
    options.flag("--skip-problems", "skip lines that cannot be read and import the rest"),
)
def import_labels(args: Namespace) -> int:
    """Import labels made with another tool. Landmarks are matched by name; those without a
    match are reported and skipped. Conflicts with the project, including clicks deleted
    there, are never resolved without a decision. One undo reverts the whole import.
    """
    stated = sources.stated_in(args)
    if not args.file.is_file():
        raise InputError("there is no such file", args.file, "Check the path.")
    trajectory = is_trajectory(args.file)
    with sources.open_project(args.into, read_only=False) as project:
        facts = (_reference if trajectory else _clicks)(args, project, stated)
    put_facts(facts, f"{args.file} into {args.into}", as_json=args.json)
    return OK


def _clicks(args: Namespace, project: Project, stated: Stated) -> dict[str, Any]:
    mine = project.clicks.all(with_deleted=True)
    problems, left_out = 0, "none"
    _refuse(args, "clicks are pixels, which have no axes in the world", "axes")
    if args.file.suffix.lower() == SUFFIX:
        _refuse(args, "a project states cameras and landmarks itself", "camera", "names")
        theirs, notes = clicks_of_project(args.file, project)
        sources.say_notes(notes)
        found = incoming(mine, theirs, args.file.name)
    else:
        recording, landmarks = sources.recording_of(project), project.landmark_set().names
        source = LabelSource(args.file, recording, landmarks, args.camera, stated.names)
        labels = read_labels(source, frame_count(recording))
        _say_problems(labels, skip=args.skip_problems)
        problems, left_out = len(labels.problems), ", ".join(labels.left_out) or "none"
        found = incoming(mine, labels.clicks, args.file.name, unstated=labels.unstated)
    decided: Decision | None = args.conflicts
    taken = found.taken(decided)
    if taken:
        project.apply(found.edit(decided))
    counts = {"taken": len(taken), "new": len(found.new), "the_same": len(found.same)}
    counts["different"] = len(found.conflicts)
    return {**counts, "problems": problems, "landmarks_left_out": left_out}


def _reference(args: Namespace, project: Project, stated: Stated) -> dict[str, Any]:
    _refuse(args, "a trajectory belongs to no camera", "camera")
    recording = sources.recording_of(project)
    stated = replace(stated, up=sources.up_of_recording(recording))
    reference = sources.named_reference(args.file, recording, stated=stated)
    if args.file.suffix.lower() in (".csv", ".npz") and stated.world_from_file is None:
        say(f"note: {args.file}: axes of the recording's world.")
    name = args.file.stem
    replacing = args.conflicts == "theirs"
    if name in project.references.names() and not replacing:
        remedy = "Rename the file, or replace the reference with --conflicts theirs."
        raise InputError(f"the project already has a reference {name!r}", args.file, remedy)
    project.apply(save_reference(name, reference, replacing=replacing))
    return {"reference": name, "frames": len(reference.frame)}


def _refuse(args: Namespace, why: str, *options: str) -> None:
    """Refuse what is said about a file where it is of another kind."""
    for name in options:
        if getattr(args, name):
            where = f"--{name.removesuffix('s') if name == 'names' else name}"
            raise InputError(why, where, "Omit this option.")


def _say_problems(labels: Labels, *, skip: bool) -> None:
    for problem in labels.problems[:_SHOWN]:
        say(str(problem))
    more = len(labels.problems) - _SHOWN
    if more > 0:
        say(f"and {more} more")
    if labels.problems and not skip:
        first = labels.problems[0]
        what = f"{len(labels.problems)} of its lines cannot be read; nothing was imported"
        remedy = "Correct them, or import the rest with --skip-problems."
        raise InputError(what, first.where, remedy)


@options.command(
    options.path(
        "file FILE",
        "a folder of OpenPose (of JSON files, or of one folder for each camera), COCO results "
        "or annotations (.json), MMPose or RTMPose (.json), FreeMoCap and MediaPipe (.npy, "
        ".csv, .json), DeepLabCut (.csv, .h5), SLEAP predictions (.slp, analysis .h5), or a "
        "table (.csv) of frame, view, keypoint, x, y, confidence",
    ),
    options.path("--into PROJECT", "project (.stereotrack)", required=True),
    options.option(
        "--camera NAME", "camera or view of the keypoints, if the file does not state it"
    ),
    options.LAYOUT,
    options.PERSON,
    options.several(
        "--name THEIRS=OURS", "keypoint here for a keypoint name in the file", dest="names"
    ),
    options.option(
        "--detector NAME",
        "name of the detector (default: name of the file); files of single cameras need the same",
    ),
    options.flag(
        "--propose",
        "also propose them as clicks: in the workspace Annotate they are shown as predictions, "
        "which can be accepted",
    ),
    options.flag("--all-people", "keep all people instead of one"),
)
def import_predictions(args: Namespace) -> int:
    """Import keypoints that a 2-D detector has predicted. They are kept in a table of their
    own and never become clicks; importing a detector again replaces its keypoints of the
    same cameras. What is left out is counted and reported.
    """
    names = stated_names(args.names, "--name")
    layout = None if args.layout is None else layout_named(args.layout)
    if args.all_people and args.person is not None:
        raise InputError("all people are kept, or one", "--person", "Omit it or --all-people.")
    with sources.open_project(args.into, read_only=False) as project:
        recording = sources.recording_of(project)
        source = KeypointSource(args.file, recording, (), args.camera, names)
        source = replace(source, layout=layout, detector=args.detector or "")
        found = plan_import(
            project, (source,), frame_count(recording),
            all_people=args.all_people, person=args.person, propose=args.propose,
        )  # fmt: skip
        project.keypoints.put(found.after)
    for note in found.notes:
        say(f"{args.file}: {note}.")
    facts = {"proposed": found.proposed} if args.propose else {}
    more = found.facts()
    facts |= {key: more[key] for key in more if key not in ("left_out", "notes")}
    told = facts if args.json else {**facts, "left_out": found.left_out_words()}
    put_facts(told, f"{args.file} into {args.into}", as_json=args.json, **more)
    return OK
