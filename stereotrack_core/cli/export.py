"""``stereotrack export``: a run or a project in the format of another tool."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.cli.arguments import (
    AXES,
    FPS,
    JSON,
    NAMES,
    OF_RUN,
    VIEWS,
    check_output,
    check_suffix,
    flag,
    option,
)
from stereotrack_core.cli.export_clicks import export_clicks
from stereotrack_core.cli.export_scene import export_rerun
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.sources import (
    angle_source,
    open_project,
    recording_of,
    say_if_unfinished,
    stated_in,
    write_angles,
)
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.joint_angles.definitions import NAMES as NAMES_OF_ANGLES
from stereotrack_core.evaluation.joint_angles.series import JointAngles, angles_of_reference
from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS
from stereotrack_core.interop.keypoints.coco import write_results
from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.interop.motion.gltf import write_glb
from stereotrack_core.interop.motion.mot import write_mot
from stereotrack_core.interop.point_tables import POINT_TABLES
from stereotrack_core.interop.reference_npz import write_reference
from stereotrack_core.interop.run_file import (
    holds_run,
    read_run,
    read_timed_trajectory,
    write_trajectory,
)
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import load_reference
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.tables import Table
from stereotrack_core.tracking.stored import upright_run

DESCRIPTION = (
    "Write clicks (csv, coco, slp, dlc, dltdv, argus, xmalab), keypoints (csv, coco), a trajectory "
    "(csv, trc, c3d, bvh, nc), joint angles (angles, mot), the moving body (glb), or all of a run "
    "with its images and clouds (rrd). Each format stores what it can; only a project file keeps "
    "who clicked what and when. Units and axes: csv, nc, rrd m, x east, y north, z up (the "
    "recording's world); trc m, x north, y up, z east; c3d mm, x east, y north, z up; bvh cm, x "
    "west, y up, z north; glb m, x east, y up, z south; angles, mot degrees; clicks are pixels of "
    "the raw image, the centre of the first one (0, 0), in dltdv (1, 1), in argus (0, height) with "
    "y up. Frames count from 0."
)

KEYPOINT_FORMATS = ("csv", "coco")
CLICK_FORMATS = ("csv", "coco", "slp", "dlc", *POINT_TABLES)
TRAJECTORY_FORMATS = ("csv", "trc", "c3d", "bvh", "nc")
REFERENCE_FORMATS = (*TRAJECTORY_FORMATS, "npz")
ANGLE_FORMATS = ("angles", "mot")
MODEL, SCENE = "glb", "rrd"
RUN_FORMATS = (*TRAJECTORY_FORMATS, *ANGLE_FORMATS, MODEL, SCENE)
FORMATS = (*REFERENCE_FORMATS, *ANGLE_FORMATS, MODEL, SCENE, *CLICK_FORMATS[1:])
_SUFFIX = {"coco": ".json", **dict.fromkeys(("dlc", "angles", *POINT_TABLES), ".csv")}
_OF_SUFFIX = {".h5": "dlc"} | {_SUFFIX.get(form, f".{form}"): form for form in reversed(FORMATS)}
"""The format that is meant where only a file's name is given: for ``.csv`` this program's own."""

OPTIONS = (
    option(
        "source RUN|PROJECT",
        "run (.npz), landmarks (.csv, .trc, .c3d), or project (.stereotrack)",
        type=Path,
    ),
    option(
        "--format",
        "clicks of a project: csv, coco, slp, dlc (.csv or .h5, a file for each camera), dltdv, "
        "argus, xmalab (.csv); trajectories: csv, trc, c3d, bvh, nc (netCDF of the package "
        "movement), angles (joint angles of every frame, .csv), mot (the same for OpenSim), and "
        "npz, which keeps the uncertainty of a project's reference; complete runs: glb (the body "
        "as a glTF model) and rrd (for the Rerun viewer). Without this option the file's name "
        "decides, and .csv is csv",
        choices=FORMATS,
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
    args.format = args.format or _format_of(args.output)
    further = (".h5",) if args.format == "dlc" else ()
    check_suffix(args.output, _SUFFIX.get(args.format, f".{args.format}"), *further)
    check_output(args.output)

    project = args.source.suffix.lower() == SUFFIX
    facts = _project(args) if project else _trajectory(args)
    rows = [(str(path), what) for path, what in facts["files"].items()]
    table = Table(f"Exported from {args.source}", ("file", "what"), rows)
    put_result(facts, table, as_json=args.json)
    return OK


def _format_of(output: Path) -> str:
    """The format that a file's name means; InputError where it means none."""
    form = _OF_SUFFIX.get(output.suffix.lower())
    if form is None:
        raise InputError(
            f"the suffix {output.suffix!r} means no format",
            where=str(output),
            remedy=f"Give --format, or a name that ends in one of {', '.join(sorted(_OF_SUFFIX))}.",
        )
    return form


def _project(args: Namespace) -> dict[str, Any]:
    with open_project(args.source) as project:
        if args.predictions is not None:
            return _project_keypoints(args, project)
        if args.reference is not None or args.format not in CLICK_FORMATS:
            return _project_reference(args, project)
        return export_clicks(args, project)


def _project_keypoints(args: Namespace, project: Project) -> dict[str, Any]:
    if args.format not in KEYPOINT_FORMATS:
        raise _wrong_kind(args.format, KEYPOINT_FORMATS)
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
    others = 0
    if args.format == "csv":
        write_table(args.output, keypoints, recording)
    else:
        others = write_results(args.output, keypoints, recording)
    told = f", {others} that COCO does not have left out" if others else ""
    return {"files": {args.output: f"{counted(len(keypoints) - others, 'keypoint')}{told}"}}


def _project_reference(args: Namespace, project: Project) -> dict[str, Any]:
    if args.format not in (*REFERENCE_FORMATS, *ANGLE_FORMATS):
        raise _wrong_kind(args.format, (*REFERENCE_FORMATS, *ANGLE_FORMATS))
    reference = _reference(project, args.reference or None)
    if args.format == "npz":
        write_reference(args.output, reference)
    else:
        fps = recording_of(project).fps if args.fps is None else args.fps
        if args.format in ANGLE_FORMATS:
            return _angles(args, angles_of_reference(reference), fps)
        write_trajectory(args.output, reference.trajectory(), fps)
    return {"files": {args.output: f"{len(reference.frame)} frames"}}


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


def _trajectory(args: Namespace) -> dict[str, Any]:
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
    if args.format in ANGLE_FORMATS:
        source = angle_source(args.source, args.fps)
        return _angles(args, source.angles, source.fps)
    if args.format not in RUN_FORMATS:
        raise _wrong_kind(args.format, RUN_FORMATS)
    if args.format == SCENE:
        return {"files": {args.output: f"{export_rerun(args)} frames"}}
    if args.format == MODEL:
        return _model(args)
    trajectory, fps = read_timed_trajectory(args.source, stated_in(args))
    residual = None
    if holds_run(args.source):
        run = read_run(args.source)
        say_if_unfinished(args.source, run)
        residual = run.residual
        if args.format != "csv":
            trajectory = upright_run(run).trajectory()
    write_trajectory(args.output, trajectory, fps if args.fps is None else args.fps, residual)
    return {"files": {args.output: f"{len(trajectory.frame)} frames"}}


def _angles(args: Namespace, angles: JointAngles, fps: float) -> dict[str, Any]:
    if args.format == "mot":
        held = write_mot(args.output, angles.frame, NAMES_OF_ANGLES, angles.angle, fps)
        if held:
            say(
                f"{counted(held, 'value')} not known stay as they were last known, because OpenSim "
                f"stops reading at a gap. {args.output.name}.json lists them."
            )
    else:
        write_angles(args.output, angles, fps, None)
    return {"files": {args.output: f"joint angles of {len(angles.frame)} frames"}}


def _model(args: Namespace) -> dict[str, Any]:
    """The moving body of a complete run."""
    if not holds_run(args.source):
        raise InputError(
            "a model of the body is made of a complete run",
            where=str(args.source),
            remedy="Use an .npz file written by `stereotrack track`, or export as bvh.",
        )
    run = read_run(args.source)
    say_if_unfinished(args.source, run)
    write_glb(args.output, run, LIMB_COLOURS)
    return {"files": {args.output: f"{len(run.frame)} frames"}}


def _wrong_kind(given: str, possible: Sequence[str]) -> InputError:
    return InputError(
        f"this cannot be exported as {given}",
        where="--format",
        remedy=f"Use one of {', '.join(possible)}.",
    )
