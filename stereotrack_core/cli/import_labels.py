"""``stereotrack import labels``: clicks or trajectories from another tool, into a project."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import AXES, JSON, NAMES, flag, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.sources import (
    named_reference,
    open_project,
    recording_of,
    say_notes,
    stated_in,
    up_of_recording,
)
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import Labels, LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.project.merging import Decision, clicks_of_project, incoming
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import save_reference
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Import labels made with another tool. Landmarks are matched by name; those without a "
    "match are reported and skipped. Conflicts with the project, including clicks deleted "
    "there, are never resolved without a decision. One undo reverts the whole import."
)

OPTIONS = (
    option(
        "file FILE",
        "clicks (.csv), DeepLabCut labels (.csv), COCO keypoints (.json), SLEAP labels "
        "(.slp), another project of the recording (.stereotrack); or a trajectory (.csv with x, y "
        "and z, .trc, .c3d, .nc, .npz), which becomes a reference of the project",
        type=Path,
    ),
    option("--into PROJECT", "project (.stereotrack)", type=Path, required=True),
    option("--camera NAME", "camera or view of the labels (DeepLabCut, COCO)"),
    NAMES,
    AXES,
    option(
        "--conflicts",
        "which clicks to keep where the file contradicts the project: mine (the project's) "
        "or theirs (the file's); without this option, nothing is imported if there are conflicts",
        choices=("mine", "theirs"),
    ),
    flag("--skip-problems", "skip lines that cannot be read and import the rest"),
    JSON,
)


_SHOWN = 20


def run(args: Namespace) -> int:
    """Read, compare and take in."""
    stated = stated_in(args)
    if not args.file.is_file():
        raise InputError("there is no such file", where=str(args.file), remedy="Check the path.")
    trajectory = is_trajectory(args.file)
    with open_project(args.into, read_only=False) as project:
        facts = (_reference if trajectory else _clicks)(args, project, stated)
    rows = [(key.replace("_", " "), str(value)) for key, value in facts.items()]
    table = Table(f"{args.file} into {args.into}", ("", ">"), rows)
    put_result(facts, table, as_json=args.json)
    return OK


def _clicks(args: Namespace, project: Project, stated: Stated) -> dict[str, Any]:
    """Take in clicks by one edit."""
    mine = project.clicks.all(with_deleted=True)
    problems, left_out = 0, "none"
    _refuse(args, "clicks are pixels, which have no axes in the world", "axes")
    if args.file.suffix.lower() == SUFFIX:
        _refuse(args, "a project states cameras and landmarks itself", "camera", "names")
        theirs, notes = clicks_of_project(args.file, project)
        say_notes(notes)
        found = incoming(mine, theirs, args.file.name)
    else:
        labels = _labels(args, project, stated.names)
        problems, left_out = len(labels.problems), ", ".join(labels.left_out) or "none"
        found = incoming(mine, labels.clicks, args.file.name, unstated=labels.unstated)
    decided: Decision | None = args.conflicts
    if found.conflicts and decided is None:
        count = len(found.conflicts)
        raise InputError(
            f"{count} of its clicks contradict{'s' if count == 1 else ''} the project; nothing "
            "was imported",
            where=str(args.file),
            remedy="Choose which to keep with --conflicts mine or --conflicts theirs, or use "
            "their means in the workbench.",
        )
    edit = found.edit(decided)
    if edit.clicks:
        project.apply(edit)
    return {
        "taken": len(edit.clicks),
        "new": len(found.new),
        "the_same": len(found.same),
        "different": len(found.conflicts),
        "problems": problems,
        "landmarks_left_out": left_out,
    }


def _labels(args: Namespace, project: Project, names: Mapping[str, str]) -> Labels:
    """What a file of another tool holds; InputError where it has problems that are not allowed."""
    recording = recording_of(project)
    with FrameReader(recording, read_ahead=0) as reader:
        frames = reader.frame_count
    landmarks = project.landmark_set().names
    source = LabelSource(args.file, recording, landmarks, args.camera, names)
    labels = read_labels(source, frames)
    _say_problems(labels, skip=args.skip_problems)
    return labels


def _reference(args: Namespace, project: Project, stated: Stated) -> dict[str, Any]:
    """Keep a trajectory as a reference of the project."""
    _refuse(args, "a trajectory belongs to no camera", "camera")
    recording = recording_of(project)
    stated = replace(stated, up=up_of_recording(recording))
    reference = named_reference(args.file, recording, stated=stated)
    if args.file.suffix.lower() in (".csv", ".npz") and stated.world_from_file is None:
        say(f"note: {args.file}: axes of the recording's world.")
    name = args.file.stem
    replacing = args.conflicts == "theirs"
    if name in project.references.names() and not replacing:
        raise InputError(
            f"the project already has a reference {name!r}",
            where=str(args.file),
            remedy="Rename the file, or replace the reference with --conflicts theirs.",
        )
    project.apply(save_reference(name, reference, replacing=replacing))
    return {"reference": name, "frames": len(reference.frame)}


def _refuse(args: Namespace, why: str, *options: str) -> None:
    """Refuse what is said about a file where it is of another kind."""
    for name in options:
        if getattr(args, name):
            where = f"--{name.removesuffix('s') if name == 'names' else name}"
            raise InputError(why, where=where, remedy="Omit this option.")


def _say_problems(labels: Labels, *, skip: bool) -> None:
    """Tell what is wrong; refuse the file unless that was allowed for."""
    for problem in labels.problems[:_SHOWN]:
        say(str(problem))
    more = len(labels.problems) - _SHOWN
    if more > 0:
        say(f"and {more} more")
    if labels.problems and not skip:
        first = labels.problems[0]
        raise InputError(
            f"{len(labels.problems)} of its lines cannot be read; nothing was imported",
            where=first.where,
            remedy="Correct them, or import the rest with --skip-problems.",
        )
