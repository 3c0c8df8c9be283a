"""``stereotrack report``: a run as one page that stands alone."""

from argparse import Namespace
from dataclasses import replace

from stereotrack_core.cli import options, sources
from stereotrack_core.cli.output import OK, put_facts, watched
from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.runs import kept_runs, load_run
from stereotrack_core.project.scenarios import segments_of
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.frame_times import stated_fps
from stereotrack_core.recording.selection import asked_frames
from stereotrack_core.report.pages import repeat_command, write_page
from stereotrack_core.report.reported import Reported, Source, gathered
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import up_of_meta


@options.command(
    options.path(
        "source RUN|PROJECT", "complete run (.npz), or project (.stereotrack) with stored runs"
    ),
    options.output("HTML", "output page", ".html", ".htm"),
    options.option(
        "--run NAME", "run of the project; may be omitted if there is only one", dest="run_name"
    ),
    options.OF_RUN,
    options.path(
        "--reference FILE",
        "reference landmarks (.csv, .trc, .c3d), or with their uncertainty (.npz); by default "
        "the reference of the project or the recording",
    ),
    *options.STATED,
    options.FRAMES,
)
def run(args: Namespace) -> int:
    """Write a self-contained HTML page about a run: subject, recording, errors, curves,
    failures with images, parameters, versions, and how to reproduce it.
    """
    source = _source(args)
    with watched("Reporting", "Nothing was written.") as work:
        reported = gathered(source, work)
    write_page(args.output, reported)
    _tell(args, reported)
    return OK


def _source(args: Namespace) -> Source:
    if args.source.suffix.lower() == SUFFIX:
        return _of_project(args)

    if args.run_name is not None:
        raise InputError("only projects contain several runs", "--run", "Omit this name.")
    stored = read_run(args.source)
    sources.say_if_unfinished(args.source, stored)
    recording = sources.recording_of_run(args.recording, stored, "images are left out")
    return _with_truth(args, stored, args.source.name, recording, str(args.source))


def _of_project(args: Namespace) -> Source:
    with sources.open_project(args.source) as project:
        kept = {one.name: one for one in kept_runs(project.runs)}
        only = next(iter(kept)) if len(kept) == 1 else ""
        name = args.run_name or project.chosen(project.runs) or only
        if name not in kept:
            what = "the project has several runs" if kept else "the project contains no run"
            what = f"the project has no run {name!r}" if name else what
            remedy = "Track and store one in the workbench, or give a run file."
            remedy = f"Choose one with --run: {', '.join(kept)}." if kept else remedy
            raise InputError(what, args.source, remedy)
        stored = load_run(project.runs, name)
        recording = (
            sources.recording_of_run(args.recording, stored, "")
            if args.recording
            else sources.recording_of(project)
        )
        if recording is not None:
            recording = replace(recording, segments=segments_of(project, recording))
        source = _with_truth(args, stored, name, recording, name)
        chosen = project.chosen(project.references)
        if args.reference is None and chosen is not None:
            states = load_reference(project.references, chosen)
            known, said = states.trajectory(), f"the project's reference {chosen}"
            source = replace(source, reference=known, states=states, reference_name=said)
        return replace(source, repeat="")


def _with_truth(
    args: Namespace, stored: Run, name: str, recording: Recording | None, like: str
) -> Source:
    """What is reported, with the reference that was named or the recording's own."""
    reference, states, said = None, None, ""
    if args.reference is not None:
        stated = sources.stated_for(args, args.reference).get(args.reference, Stated())
        stated = replace(stated, up=up_of_meta(stored.meta))
        fps, path = stated_fps(stored.meta), args.reference
        states = sources.named_reference(path, recording, fps, stored.frame, stated)
        sources.say_left_out(path, states)
        reference = states.trajectory()
        said = f"the reference {args.reference.name}"
    elif recording is not None and recording.reference is not None:
        reference, said = recording.reference, "the recording's reference"
    folder = str(recording.folder.name) if recording is not None else "RECORDING"
    frames, repeat = asked_frames(args.frames), repeat_command(folder, like)
    return Source(name, stored, recording, reference, said, states, frames, repeat)


def _tell(args: Namespace, reported: Reported) -> None:
    accuracy = reported.accuracy
    facts = {
        "report": args.output,
        "frames": len(reported.source.run.frame),
        "episodes": len(reported.failures),
        "lost_percent": None if accuracy is None else 100.0 * accuracy.summary.lost,
    }
    known = facts if args.json else {k: value for k, value in facts.items() if value is not None}
    put_facts(known, f"Report on {reported.source.name}", as_json=args.json)
