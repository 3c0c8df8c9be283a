"""``stereotrack reproduce``: the thesis's tables and curves beside ours."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, check_least, flag, option
from stereotrack_core.cli.output import FAILED, OK, put_json, put_table, say
from stereotrack_core.cli.progress import pace, stoppable
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.experiments.reproduction.plan import (
    Group,
    Places,
    groups,
    missing_recordings,
    opened_recordings,
    places_in,
    render_recording,
)
from stereotrack_core.experiments.reproduction.results import Results, write_results
from stereotrack_core.experiments.reproduction.runs import frames_of, missing_runs, track_groups
from stereotrack_core.experiments.reproduction.tables import facts, readable
from stereotrack_core.locks import writing
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.worker_processes import Lost

DESCRIPTION = (
    "Create four recordings like those of the thesis, track them with the presets, and write "
    "the thesis's tables 4.1 to 4.4, its timing and its error curves next to its own numbers: "
    "as one page with images, as CSV and as Markdown. Finished results are kept; the same "
    "command continues after an interruption."
)

OPTIONS = (
    option(
        "folder DIR",
        "folder for recordings, runs and results (default: the program's data folder)",
        type=Path,
        nargs="?",
    ),
    flag(
        "--short",
        "use recordings of a few dozen frames: a test of all steps in a few minutes, without "
        "meaningful numbers",
    ),
    option(
        "--presets a,b",
        "comma-separated presets (default: thesis,accurate)",
        default="thesis,accurate",
    ),
    option(
        "--seeds N",
        "number of runs of preset thesis, which samples points at random (default: 5); other "
        "presets run once",
        type=int,
        default=5,
    ),
    option("--workers N", "number of tracking processes (default: 1)", type=int, default=1),
    JSON,
)


def run(args: Namespace) -> int:
    """Make the recordings, track them, and write the page."""
    presets = _presets(args.presets)
    check_least(1, seeds=args.seeds, workers=args.workers)
    places = places_in(args.folder, short=args.short)
    with writing(places.folder):
        return _reproduce(args, places, presets)


def _reproduce(args: Namespace, places: Places, presets: Sequence[str]) -> int:
    try:
        recordings = _recordings(places, short=args.short)
        planned = groups([recording.name for recording in recordings], presets, args.seeds)
        write = partial(write_results, places, recordings, planned, presets, short=args.short)
        _track(places, recordings, planned, args.workers, write)
    except (Cancelled, KeyboardInterrupt):
        say(
            f"Stopped. Finished results are in {places.folder}; run the same command again to "
            "continue."
        )
        return FAILED
    except Lost as lost:
        say(f"The same runs failed twice: {lost}. Fewer --workers need less memory. Run the same "
        "command again to continue.")  # fmt: skip
        return FAILED
    results = write(
        on_timing=lambda name: say(f"Timing {name}. Do not run anything else meanwhile.")
    )
    _print(results, places, as_json=args.json)
    return OK


def _recordings(places: Places, *, short: bool) -> Sequence[Recording]:
    """The four recordings; what is missing is rendered."""
    missing = missing_recordings(places, short=short)
    with pace("Rendering", sum(one.frames for one in missing)) as going, stoppable() as stopped:
        for one in missing:
            say(f"Rendering {one.name}, {one.frames} frames.")
            render_recording(places, one, going.advance, stopped)
            going.next(one.frames)
    return opened_recordings(places, short=short)


def _track(
    places: Places,
    recordings: Sequence[Recording],
    groups: Sequence[Group],
    workers: int,
    write: Callable[[], object],
) -> None:
    """Track every run that is not there yet, and write what there is whenever some are finished."""
    left = missing_runs(places, recordings, groups)
    by_name = {recording.name: recording for recording in recordings}
    cost = {group: len(group.runs) * frames_of(by_name[group.recording]) for group in left}
    total = sum(cost.values())
    if not left:
        return
    say(f"Tracking {counted(sum(len(g.runs) for g in left), 'run')}, {total} frames in all.")
    with pace("Tracking", total) as going, stoppable() as stopped:

        def note(group: Group) -> None:
            going.next(cost[group])
            runs = f"{counted(len(group.runs), 'run')} like {group.runs[0].name}"
            say(f"{group.recording}: {runs} done; {going.words()}.")
            write()

        track_groups(
            places,
            recordings,
            left,
            workers,
            on_frames=going.advance,
            on_group=note,
            on_lost=lambda group, why: say(
                f"{group.recording}: {why}; its runs are started again."
            ),
            cancelled=stopped,
        )


def _print(results: Results, places: Places, *, as_json: bool) -> None:
    """The tables to standard output."""
    if as_json:
        made = results.circumstances
        put_json({"page": places.page, "tables": facts(results.tables), "made": made,
                  "timings": results.timings})  # fmt: skip
    else:
        for compared in results.tables:
            put_table(readable(compared))
    say(f"Page written to {places.page}; the tables are next to it as .csv and .md.")


def _presets(text: str) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise InputError("no preset is given", where="--presets", remedy="Give thesis,accurate.")
    for name in names:
        preset(name)
    return names
