"""``stereotrack export``: a run or a project in the format of another tool."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.cli.arguments import (
    AXES,
    FPS,
    JSON,
    LIMIT_OF_SIGMA,
    NAMES,
    OF_RUN,
    VIEWS,
    check_output,
    check_suffix,
    flag,
    option,
)
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.sources import (
    angles_in,
    limit_of_sigma,
    open_project,
    read_measured,
    recording_of,
    recording_of_run,
    say_if_unfinished,
    say_notes,
    stated_in,
)
from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import is_reference, read_reference
from stereotrack_core.interop.run_file import holds_run, read_run, read_trajectory
from stereotrack_core.project.exporting.formats import (
    FORMATS,
    ExportFormat,
    check_kind,
    format_named,
    format_of_file,
)
from stereotrack_core.project.exporting.labels import export_clicks, export_keypoints
from stereotrack_core.project.exporting.runs import (
    ANGLE_FORMATS,
    Exported,
    export_angles,
    export_reference,
    export_run,
    export_trajectory,
)
from stereotrack_core.project.exporting.scene import SCENE, export_scene
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import load_reference
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.selection import asked_frames, views_of
from stereotrack_core.tables import Table
from stereotrack_core.tracking.frame import Run

DESCRIPTION = (
    "Write clicks (csv, coco, slp, dlc, dltdv, argus, xmalab), keypoints (csv, coco), a trajectory "
    "(csv, trc, c3d, bvh, nc), joint angles (angles, mot), or all of a run "
    "with its images and clouds (rrd). Each format stores what it can; only a project file keeps "
    "who clicked what and when. Units and axes: csv, nc, rrd m, x east, y north, z up (the "
    "recording's world); trc m, x north, y up, z east; c3d mm, x east, y north, z up; bvh cm, x "
    "west, y up, z north; angles, mot degrees; clicks are pixels of "
    "the raw image, the centre of the first one (0, 0), in dltdv (1, 1), in argus (0, height) with "
    "y up. Frames count from 0."
)

OPTIONS = (
    option(
        "source RUN|PROJECT",
        "run (.npz), landmarks (.csv, .trc, .c3d, .nc), or project (.stereotrack)",
        type=Path,
    ),
    option(
        "--format",
        "clicks of a project: csv, coco, slp, dlc (.csv or .h5, a file for each camera), dltdv, "
        "argus, xmalab (.csv); trajectories: csv, trc, c3d, bvh, nc (netCDF of the package "
        "movement), angles (joint angles of every frame, .csv), mot (the same for OpenSim), and "
        "npz, which keeps the uncertainty of a project's reference; complete runs: "
        "rrd (for the Rerun viewer). Without this option the file's name "
        "decides, and .csv is csv",
        choices=tuple(one.name for one in FORMATS),
    ),
    option("-o --output FILE", "file to write", type=Path, required=True),
    option(
        "--reference NAME",
        "for a project: export its reference instead of its clicks; without a name, the "
        "active reference",
        nargs="?",
        const="",
    ),
    option(
        "--predictions DETECTOR",
        "for a project: export the keypoints that a detector has predicted (csv, or coco for a "
        "results file) instead of its clicks; without a name, those of all",
        nargs="?",
        const="",
    ),
    LIMIT_OF_SIGMA,
    flag(
        "--pictures",
        "for clicks as coco, dlc and slp: also the pictures that they were made on, where the "
        "other tool looks for them (coco, dlc: beside the file; slp: inside)",
    ),
    FPS,
    NAMES,
    AXES,
    option("--frames A:B", "for rrd: only frames A up to but not including B"),
    VIEWS,
    flag("--no-clouds", "for rrd: leave the clouds out, which take most of the time"),
    OF_RUN,
    JSON,
)


def run(args: Namespace) -> int:
    """Read and write."""
    form = format_named(args.format) if args.format else format_of_file(args.output)
    check_suffix(args.output, *form.suffixes)
    check_output(args.output)
    written = (_project if args.source.suffix.lower() == SUFFIX else _trajectory)(args, form)
    for note in written.notes:
        say(note)
    rows = [(str(path), what) for path, what in written.files.items()]
    table = Table(f"Exported from {args.source}", ("file", "what"), rows)
    put_result({"files": written.files}, table, as_json=args.json)
    return OK


def _project(args: Namespace, form: ExportFormat) -> Exported:
    with open_project(args.source) as project:
        if args.predictions is not None:
            return _project_keypoints(args, project, form)
        if args.reference is not None or "clicks" not in form.kinds:
            return _project_reference(args, project, form)
        recording = recording_of(project)
        check_output(args.output, recording)
        labels = args.output, project.clicks.all(), recording, project.landmark_set(), form
        if not args.pictures:
            return export_clicks(*labels)
        outcome = "The labels and some pictures were written."
        with watched("Writing pictures", outcome) as (report, stopped):
            return export_clicks(
                *labels, pictures=True, report=lambda share: report(share, ""), stopped=stopped
            )


def _project_keypoints(args: Namespace, project: Project, form: ExportFormat) -> Exported:
    check_kind(form, "keypoints")
    recording = recording_of(project)
    check_output(args.output, recording)
    known = project.keypoints.sources()
    if not known or (args.predictions and args.predictions not in known):
        raise InputError(
            f"the project has no keypoints of {args.predictions or 'any detector'}",
            where=str(project.path),
            remedy=f"Its detectors: {', '.join(known) or 'none'}. Import keypoints with "
            "`stereotrack import predictions`.",
        )
    keypoints = project.keypoints.all(args.predictions or None)
    return export_keypoints(args.output, keypoints, recording, form)


def _project_reference(args: Namespace, project: Project, form: ExportFormat) -> Exported:
    check_kind(form, "reference")
    reference = _reference(project, args.reference or None)
    fps = None
    if form.name != "npz":
        fps = recording_of(project).fps if args.fps is None else args.fps
    return export_reference(args.output, reference, form, fps, limit_of_sigma(args))


def _reference(project: Project, name: str | None) -> Reference:
    """The reference of that name, or the chosen or only one."""
    names = project.references.names()
    if not names:
        raise InputError(
            "the project has no reference",
            where=str(project.path),
            remedy="Fit the clicks first, in the workbench or with `stereotrack fit`.",
        )
    chosen = name or project.chosen(project.references) or (names[0] if len(names) == 1 else None)
    if chosen is None:
        raise InputError(
            "the project has several references and none is active",
            where=str(project.path),
            remedy=f"Choose one with --reference: {', '.join(names)}.",
        )
    return load_reference(project.references, chosen)


def _trajectory(args: Namespace, form: ExportFormat) -> Exported:
    """Export a run, a reference or landmarks."""
    for option_name, given, what in (
        ("--reference", args.reference, "references"),
        ("--predictions", args.predictions, "predictions"),
        ("--pictures", args.pictures or None, "clicks"),
    ):
        if given is not None:
            raise InputError(
                f"only projects contain {what}",
                where=option_name,
                remedy="Omit this option.",
            )
    if is_reference(args.source):
        check_kind(form, "reference")
        reference = read_reference(args.source)
        rate = reference.fps if args.fps is None else args.fps
        return export_reference(args.output, reference, form, rate, limit_of_sigma(args))
    if form.name in ANGLE_FORMATS:
        found = read_measured(args.source, stated_in(args))
        angles, fps = angles_in(args.source, *found, args.fps)
        return export_angles(args.output, angles, form, fps)
    check_kind(form, "run")
    if holds_run(args.source):
        run = read_run(args.source)
        say_if_unfinished(args.source, run)
        if form.name == SCENE:
            return _scene(args, run)
        return export_run(args.output, run, form, args.fps)
    if "trajectory" not in form.kinds:
        raise InputError(
            f"{form.name} is made of a complete run",
            where=str(args.source),
            remedy="Use an .npz file written by `stereotrack track`, or export as bvh.",
        )
    trajectory = read_trajectory(args.source, stated_in(args))
    say_notes(trajectory.notes)
    rate = trajectory.fps if args.fps is None else args.fps
    return export_trajectory(args.output, trajectory, form, rate)


def _scene(args: Namespace, run: Run) -> Exported:
    """A run with images and clouds of its recording."""
    recording = recording_of_run(args.recording, run, "there are no images to write")
    if recording is None:
        raise InputError(
            "the run's recording was not found",
            where=str(args.source),
            remedy="Give its folder with --recording.",
        )
    check_output(args.output, recording)
    asked = asked_frames(args.frames)
    frames = [frame for frame in run.frame.tolist() if frame in asked]
    if not frames:
        raise InputError(
            "the run has none of these frames",
            where="--frames",
            remedy=f"It has the frames {run.frame.min()}:{run.frame.max() + 1}.",
        )
    with watched("Exporting", "Nothing was written.") as (report, stopped):
        return export_scene(
            args.output, run, recording, frames=frames, views=views_of(recording, args.views),
            clouds=not args.no_clouds, report=lambda share: report(share, ""), stopped=stopped,
        )  # fmt: skip
