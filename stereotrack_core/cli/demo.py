"""``stereotrack demo``: make the demo recording once, track it, print its errors."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.cli.arguments import add_json, add_settings, settings_of
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.error_tables import error_facts, error_table, segment_table
from stereotrack_core.cli.output import put_json, put_table, say
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.errors import InputError


@dataclass(frozen=True)
class DemoPlaces:
    """Where the demo keeps its recording and its run."""

    recording: Path
    run: Path


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "folder",
        type=Path,
        nargs="?",
        metavar="DIR",
        help="where recording and run are kept (default: the program's own data folder)",
    )
    parser.add_argument(
        "--headless", action="store_true", help="print the errors without opening the workbench"
    )
    parser.add_argument(
        "--screenshot",
        type=Path,
        metavar="PNG",
        help="save the workbench on the demo as a picture and leave; works without a screen",
    )
    add_settings(parser)
    add_json(parser)


def demo_places(folder: Path | None) -> DemoPlaces:
    """Recording and run in `folder`, or in the program's own data folder."""
    if folder is None:
        from platformdirs import user_data_path

        folder = user_data_path("stereotrack", appauthor=False) / "demo"
    if folder.exists() and not folder.is_dir():
        raise InputError("this is not a folder", where=str(folder), remedy="Name a folder.")
    return DemoPlaces(folder / "recording", folder / "run.npz")


def make_demo_recording(places: DemoPlaces) -> None:
    """Render the demo recording unless it is there already.

    Raises
    ------
    Cancelled
        When stopped with Ctrl-C; nothing is left behind.
    """
    if (places.recording / "recording.toml").is_file():
        return
    from stereotrack_core.simulation.make import DEMO_FRAMES, demo_recording

    say(f"Making the demo recording in {places.recording}, once.")
    try:
        places.recording.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})",
            where=str(places.recording.parent),
            remedy="Name a folder that you may write to: stereotrack demo DIR.",
        ) from error
    with progress("Rendering", DEMO_FRAMES) as show, stoppable() as stopped:
        demo_recording(places.recording, on_progress=lambda done, _: show(done), cancelled=stopped)


def run(args: Namespace) -> int:
    """Make the recording, track it, write the run and print the tables."""
    from stereotrack_core.cli.track_signs import say_signs
    from stereotrack_core.cli.tracking_job import track_recording
    from stereotrack_core.cli.unfinished import UnfinishedOutput
    from stereotrack_core.evaluation.errors import errors_against
    from stereotrack_core.evaluation.summary import summarise, summarise_segments
    from stereotrack_core.recording.folder import open_recording
    from stereotrack_core.recording.reader import FrameReader

    settings = settings_of(args.preset, args.changes)
    places = demo_places(args.folder)
    make_demo_recording(places)
    recording = open_recording(places.recording)
    with FrameReader(recording, read_ahead=0) as reader:
        frames = range(reader.frame_count)
    say(f"Tracking {len(frames)} frames with preset {args.preset}.")
    output = UnfinishedOutput(places.recording, places.run)
    output.part.unlink(missing_ok=True)  # all of the demo is made again
    with output.telling():
        job = track_recording(recording, settings, frames, preset=args.preset, part=output.part)
        if not len(job.run.frame) or recording.reference is None:
            say("Stopped before the first frame.")
            return FAILED
        output.write(job)
    errors = errors_against(job.run.trajectory(), recording.reference)
    if job.stopped:
        errors = errors.between(0, int(job.run.frame[-1]) + 1)
    summary = summarise(errors)
    parts = summarise_segments(errors, recording.segments)
    facts = job.facts()
    if args.json:
        places_facts = {"run": places.run, "recording_folder": places.recording}
        errors_of_parts = {"segments": [error_facts(part) for part in parts]}
        put_json({**facts, **places_facts, **error_facts(summary), **errors_of_parts})
    else:
        title = f"Demo recording, preset {args.preset}, {len(job.run.frame)} frames"
        put_table(error_table(summary, title, facts["frames_per_second"]))
        put_table(segment_table(parts))
    say(f"The recording is in {places.recording}, the run in {places.run}.")
    say_signs(job)
    return FAILED if job.stopped or job.nothing else OK


COMMAND = Command(
    name="demo",
    summary="make a demo recording (once), track it, print its errors, open the workbench",
    description=(
        "Render the demo recording where it is not there yet, track it, print the errors of "
        "every limb, and open the workbench on it. With --headless nothing is opened."
    ),
    add_arguments=add_arguments,
    run=run,
)
