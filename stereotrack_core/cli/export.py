"""``stereotrack export``: a run or a project in the format of another tool."""

from argparse import Namespace

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.cli import options, sources
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import is_reference, read_reference
from stereotrack_core.interop.run_file import holds_run, read_run, read_trajectory
from stereotrack_core.project import exporting
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.tables import Table


@options.command(
    options.path(
        "source RUN|PROJECT", "run (.npz), landmarks (.csv, .trc, .c3d), or project (.stereotrack)"
    ),
    options.option(
        "--format",
        "clicks of a project: csv, coco, slp, dlc (.csv, a file for each camera); "
        "trajectories: csv, trc, c3d, bvh, angles (joint angles of every frame, .csv), and "
        "npz, which keeps the uncertainty of a project's reference. Without this option the "
        "file's name decides, and .csv is csv",
        choices=tuple(one.name for one in exporting.FORMATS),
    ),
    options.output("FILE", "file to write"),
    options.option(
        "--reference NAME",
        "for a project: export its reference instead of its clicks; without a name, the active "
        "reference",
        nargs="?",
        const="",
    ),
    options.option(
        "--predictions DETECTOR",
        "for a project: export the keypoints that a detector has predicted (csv, or coco for a "
        "results file) instead of its clicks; without a name, those of all",
        nargs="?",
        const="",
    ),
    options.MAX_SIGMA,
    options.FPS,
    options.NAMES,
    options.AXES,
)
def run(args: Namespace) -> int:
    """Write clicks (csv, coco, slp, dlc), keypoints (csv, coco), a trajectory (csv, trc,
    c3d, bvh) or joint angles (angles). Provenance of landmarks (source, annotator, visibility,
    sigma, number of views, residual) is kept in csv, npz and coco, and for the other formats
    in FILE.provenance.csv beside it. Units and axes: csv m, x east, y north, z up (the
    recording's world); trc m, x north, y up, z east; c3d mm, x east, y north, z up; bvh cm,
    x west, y up, z north; angles degrees; clicks are pixels of the raw image, the centre of
    the first one (0, 0). Frames count from 0.
    """
    named = exporting.format_named(args.format) if args.format else None
    form = named or exporting.format_of_file(args.output)
    options.check_suffix(args.output, *form.suffixes)
    written = (_project if args.source.suffix.lower() == SUFFIX else _trajectory)(args, form)
    for note in written.notes:
        say(note)
    rows = [(str(path), what) for path, what in written.files.items()]
    table = Table(f"Exported from {args.source}", ("file", "what"), rows)
    put_result({"files": written.files}, table, as_json=args.json)
    return OK


def _project(args: Namespace, form: exporting.ExportFormat) -> exporting.Exported:
    with sources.open_project(args.source) as project:
        if args.predictions is not None:
            return _project_keypoints(args, project, form)
        if args.reference is not None or "clicks" not in form.kinds:
            exporting.writer(form, "reference")
            reference = _reference(project, args.reference or None)
            fps = None
            if form.name != "npz":
                fps = sources.recording_of(project).fps if args.fps is None else args.fps
            limit = 0.001 * args.max_sigma
            return exporting.export_reference(args.output, reference, form, fps, limit)
        recording = sources.recording_of(project)
        options.check_output(args.output, recording.folder)
        clicked = exporting.ClickedRecording.of(project, recording)
        return exporting.export_clicks(args.output, clicked, form)


def _project_keypoints(
    args: Namespace, project: Project, form: exporting.ExportFormat
) -> exporting.Exported:
    write = exporting.writer(form, "keypoints")
    recording = sources.recording_of(project)
    options.check_output(args.output, recording.folder)
    known = project.keypoints.sources()
    if not known or (args.predictions and args.predictions not in known):
        raise InputError(
            f"the project has no keypoints of {args.predictions or 'any detector'}",
            project.path,
            f"Its detectors: {', '.join(known) or 'none'}. Import keypoints with "
            "`stereotrack import predictions`.",
        )
    keypoints = project.keypoints.all(args.predictions or None)
    return write(args.output, keypoints, recording)


def _reference(project: Project, name: str | None) -> Reference:
    """The reference of that name, or the chosen or only one."""
    names = project.references.names()
    if not names:
        remedy = "Fit the clicks first, in the workbench or with `stereotrack fit`."
        raise InputError("the project has no reference", project.path, remedy)
    chosen = name or project.chosen(project.references) or (names[0] if len(names) == 1 else None)
    if chosen is None:
        what = "the project has several references and none is active"
        raise InputError(what, project.path, f"Choose one with --reference: {', '.join(names)}.")
    return load_reference(project.references, chosen)


def _trajectory(args: Namespace, form: exporting.ExportFormat) -> exporting.Exported:
    for option_name, given, what in (
        ("--reference", args.reference, "references"),
        ("--predictions", args.predictions, "predictions"),
    ):
        if given is not None:
            raise InputError(f"only projects contain {what}", option_name, "Omit this option.")
    if is_reference(args.source):
        exporting.writer(form, "reference")
        reference = read_reference(args.source)
        rate = reference.fps if args.fps is None else args.fps
        limit = 0.001 * args.max_sigma
        return exporting.export_reference(args.output, reference, form, rate, limit)
    if form.name == "angles":
        found = sources.read_measured(args.source, sources.stated_in(args))
        angles, fps = sources.angles_in(args.source, *found, args.fps)
        return exporting.export_angles(args.output, angles, fps)
    write = exporting.writer(form, "run")
    if holds_run(args.source):
        run = read_run(args.source)
        sources.say_if_unfinished(args.source, run)
        return write(args.output, run, args.fps)
    write = exporting.writer(form, "trajectory")
    trajectory = read_trajectory(args.source, sources.stated_in(args))
    sources.say_notes(trajectory.notes)
    rate = trajectory.fps if args.fps is None else args.fps
    return write(args.output, trajectory, rate)
