"""``stereotrack report``: a run as one page that stands alone, and as a PDF."""

from __future__ import annotations

import shlex
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.arguments import add_frames, add_json, check_output
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import Table, put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.cli.sources import say_if_unfinished
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.selection import frame_bounds

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.report.reported import Reported, Source
    from stereotrack_core.tracking.frame import Run


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "source",
        type=Path,
        metavar="RUN|PROJECT",
        help="complete run (.npz), or project (.stereotrack) with stored runs",
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="HTML", help="output page"
    )
    parser.add_argument(
        "--run",
        metavar="NAME",
        dest="run_name",
        help="run of the project; may be omitted if there is only one",
    )
    parser.add_argument(
        "--recording",
        type=Path,
        metavar="DIR",
        help="the run's recording; by default the one named in the run",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        metavar="FILE",
        help="reference landmarks (.csv, .trc, .c3d), or with their uncertainty (.npz); by "
        "default the reference of the project or the recording",
    )
    add_frames(parser)
    parser.add_argument("--pdf", type=Path, metavar="PDF", help="also write the report as a PDF")
    add_json(parser)


def run(args: Namespace) -> int:
    """Gather, write the page, and the PDF where it is asked for."""
    from stereotrack_core.report.files import write_page, write_pdf
    from stereotrack_core.report.reported import gathered

    _check(args)
    source = _source(args)
    with progress("Reporting", 100) as show, stoppable() as stopped:
        try:
            reported = gathered(
                source,
                on_progress=lambda share, _: show(round(100 * share)),
                cancelled=stopped,
            )
        except Cancelled:
            say("Stopped. Nothing was written.")
            return FAILED
    write_page(args.output, reported)
    if args.pdf is not None:
        write_pdf(args.pdf, reported, None if args.window is None else args.window.package)
    _tell(args, reported)
    return OK


def _check(args: Namespace) -> None:
    """Refuse at once what could only fail after the work."""
    for path, suffixes in ((args.output, (".html", ".htm")), (args.pdf, (".pdf",))):
        if path is None:
            continue
        if path.suffix.lower() not in suffixes:
            raise InputError(
                f"the name must end in {suffixes[0]}",
                where=str(path),
                remedy=f"Use the name {path.with_suffix(suffixes[0]).name}.",
            )
        check_output(path)


def _source(args: Namespace) -> Source:
    from stereotrack_core.project.whereabouts import SUFFIX

    if args.source.suffix.lower() == SUFFIX:
        return _of_project(args)
    from stereotrack_core.cli.sources import recording_of_run
    from stereotrack_core.interop.run_file import read_run

    if args.run_name is not None:
        raise InputError(
            "only projects contain several runs", where="--run", remedy="Omit this option."
        )
    stored = read_run(args.source)
    say_if_unfinished(args.source, stored)
    recording = recording_of_run(args.recording, stored, "images are left out")
    return _with_truth(args, stored, args.source.name, recording, str(args.source))


def _of_project(args: Namespace) -> Source:
    from dataclasses import replace

    from stereotrack_core.cli.sources import open_project, recording_of, recording_of_run
    from stereotrack_core.project.runs import kept_runs, load_run
    from stereotrack_core.project.setups import load_reference

    with open_project(args.source) as project:
        kept = {one.name: one for one in kept_runs(project.runs)}
        name = (
            args.run_name
            or project.chosen(project.runs)
            or (next(iter(kept)) if len(kept) == 1 else "")
        )
        if name not in kept:
            raise InputError(
                f"the project has no run {name!r}" if name else "the project has several runs"
                if kept else "the project contains no run",
                where=str(args.source),
                remedy=f"Choose one with --run: {', '.join(kept)}." if kept else
                "Track and store one in the workbench, or give a run file.",
            )  # fmt: skip
        stored = load_run(project.runs, name)
        recording = (
            recording_of_run(args.recording, stored, "")
            if args.recording
            else recording_of(project)
        )
        source = _with_truth(args, stored, name, recording, name)
        chosen = project.chosen(project.references)
        if args.reference is None and chosen is not None:
            states = load_reference(project.references, chosen)
            source = replace(
                source,
                reference=states.trajectory(),
                states=states,
                reference_name=f"the project's reference {chosen}",
            )
        return replace(source, note=kept[name].facts.note, repeat="")


def _with_truth(
    args: Namespace, stored: Run, name: str, recording: Recording | None, like: str
) -> Source:
    """What is reported, with the reference that was named or the recording's own."""
    from stereotrack_core.cli.sources import truth_of
    from stereotrack_core.report.files import repeat_command
    from stereotrack_core.report.reported import Source

    reference, states, said = None, None, ""
    if args.reference is not None:
        truth = truth_of(args.reference, stored.meta)
        reference, states = truth.reference, truth.states
        said = f"the reference {args.reference.name}"
    elif recording is not None and recording.reference is not None:
        reference, said = recording.reference, "the recording's reference"
    folder = str(recording.folder.name) if recording is not None else "RECORDING"
    return Source(
        name=name,
        run=stored,
        recording=recording,
        reference=reference,
        reference_name=said,
        states=states,
        frames=(None, None) if args.frames is None else frame_bounds(args.frames),
        command=_own_command(args),
        repeat=repeat_command(folder, like),
    )


def _own_command(args: Namespace) -> str:
    words = ["stereotrack", "report", str(args.source), "-o", str(args.output)]
    for option in ("run", "recording", "reference", "frames", "pdf"):
        value = getattr(args, "run_name" if option == "run" else option)
        if value is not None:
            words += [f"--{option}", str(value)]
    return shlex.join(words)


def _tell(args: Namespace, reported: Reported) -> None:
    accuracy = reported.accuracy
    facts = {
        "report": args.output,
        "pdf": args.pdf,
        "frames": len(reported.source.run.frame),
        "episodes": len(reported.episodes),
        "lost_percent": None if accuracy is None else 100.0 * accuracy.summary.lost,
    }
    if args.json:
        put_json(facts)
    else:
        rows = [(key.replace("_", " "), str(value)) for key, value in facts.items()
                if value is not None]  # fmt: skip
        put_table(Table(f"Report on {reported.source.name}", ("what", "value"), rows))


COMMAND = Command(
    name="report",
    summary="write a report on a run: one page with errors, curves, failures and images",
    description=(
        "Write a self-contained HTML page, and optionally a PDF, about a run: subject, recording, "
        "calibration, errors, curves, failures with images, range of motion, uncertainty, "
        "parameters, versions, and how to reproduce it."
    ),
    add_arguments=add_arguments,
    run=run,
)
