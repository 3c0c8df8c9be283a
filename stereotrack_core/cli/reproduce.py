"""``stereotrack reproduce``: the thesis's tables and curves beside ours."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import add_json
from stereotrack_core.cli.command import FAILED, OK, Command
from stereotrack_core.cli.output import say
from stereotrack_core.errors import Cancelled, InputError


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "folder",
        type=Path,
        nargs="?",
        metavar="DIR",
        help="where recordings, runs and results are kept (default: the program's own data folder)",
    )
    parser.add_argument(
        "--short",
        action="store_true",
        help="recordings of some tens of frames: every step in some minutes, numbers that say "
        "nothing",
    )
    parser.add_argument(
        "--presets",
        default="thesis,accurate",
        metavar="a,b",
        help="presets, joined by commas (default: thesis,accurate)",
    )
    parser.add_argument(
        "--seeds",
        type=int,
        default=5,
        metavar="N",
        help="runs of preset thesis, which draws points at random (default: 5); others run once",
    )
    parser.add_argument(
        "--workers", type=int, default=1, metavar="N", help="processes that track (default: 1)"
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Make the recordings, track them, and write the page."""
    from stereotrack_core.cli.reproduction.places import default_folder, made_folder
    from stereotrack_core.cli.reproduction.recordings import make_recordings
    from stereotrack_core.cli.reproduction.work import track_all
    from stereotrack_core.cli.reproduction.writing import print_results, write_results
    from stereotrack_core.experiments.reproduction.plan import groups
    from stereotrack_core.worker_processes import Lost

    presets = _presets(args.presets)
    for name in ("seeds", "workers"):
        if getattr(args, name) < 1:
            raise InputError("at least 1 is needed", where=f"--{name}", remedy="Give 1 or more.")
    places = made_folder(args.folder or default_folder(short=args.short))
    try:
        recordings = make_recordings(places, short=args.short)
        planned = groups([recording.name for recording in recordings], presets, args.seeds)

        def write() -> None:
            write_results(places, recordings, planned, presets, short=args.short)

        track_all(places, recordings, planned, args.workers, write)
    except (Cancelled, KeyboardInterrupt):
        say(f"Stopped. What is finished is in {places.folder}; the same command goes on from it.")
        return FAILED
    except Lost as lost:
        say(f"Stopped twice at the same runs: {lost}. Fewer --workers need less memory; the same "
            "command goes on.")  # fmt: skip
        return FAILED
    results = write_results(places, recordings, planned, presets, short=args.short, last=True)
    print_results(results, places, as_json=args.json)
    return OK


def _presets(text: str) -> tuple[str, ...]:
    from stereotrack_core.tracking.presets import preset

    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise InputError("no preset is named", where="--presets", remedy="Give thesis,accurate.")
    for name in names:
        preset(name)
    return names


COMMAND = Command(
    name="reproduce",
    summary="the thesis's tables and curves beside ours",
    description=(
        "Make four recordings like those of the thesis, track them with the presets, and write "
        "the thesis's tables 4.1 to 4.4, its timing and its error curves beside its own numbers, "
        "as one page with pictures, as CSV and as Markdown. Everything that is finished is kept: "
        "the same command goes on where it was stopped."
    ),
    add_arguments=add_arguments,
    run=run,
)
