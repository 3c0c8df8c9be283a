"""``stereotrack bench``: the benchmarks of the README, as ratios."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.arguments import add_json
from stereotrack_core.cli.command import OK, Command
from stereotrack_core.cli.demo import made_demo
from stereotrack_core.cli.output import Table, number, put_json, put_table, say
from stereotrack_core.cli.progress import progress
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.experiments.benchmark.chain_speed import ChainSpeed
    from stereotrack_core.experiments.benchmark.correction_speed import CorrectionSpeed
    from stereotrack_core.window import Window

PARTS = ("chain", "correction", "window")
_WINDOW_SECONDS = 600.0
_BUSY = 0.7


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "recording",
        type=Path,
        nargs="?",
        metavar="RECORDING",
        help="recording with stereo views (default: the demo recording, which is created if "
        "missing)",
    )
    parser.add_argument(
        "--only",
        action="append",
        choices=PARTS,
        help="run only this benchmark; may be given several times",
    )
    parser.add_argument(
        "--frames",
        type=int,
        default=40,
        metavar="N",
        help="frame sets per round of the whole chain (default: 40)",
    )
    parser.add_argument(
        "--rounds",
        type=int,
        default=5,
        metavar="N",
        help="rounds of the whole chain; medians are reported (default: 5)",
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Run the benchmarks and print them."""
    for name in ("frames", "rounds"):
        if getattr(args, name) < 1:
            raise InputError(
                "the value must be at least 1", where=f"--{name}", remedy="Give 1 or more."
            )
    if args.recording is not None:
        _check_recording(args.recording)
    parts = args.only or PARTS
    load = _load_per_core()
    if load > _BUSY:
        say(f"The machine is busy (load {load:.1f} per core). The results will be inaccurate.")
    folder = _recording(args.recording) if set(parts) & {"chain", "window"} else None
    facts: dict[str, Any] = {"cores": os.cpu_count(), "load_per_core": load, "recording": folder}
    tables: list[Table] = []
    if folder is not None and "chain" in parts:
        speeds = _chain(folder, args.frames, args.rounds)
        facts["chain"] = [{"ratio": speed.ratio, **vars(speed)} for speed in speeds]
        tables.append(_chain_table(speeds))
    if "correction" in parts:
        from stereotrack_core.experiments.benchmark.correction_speed import growth

        corrections = _correction()
        facts["correction"] = {"growth_exponent": growth(corrections), "sizes": corrections}
        tables.append(_correction_table(corrections, growth(corrections)))
    if folder is not None and "window" in parts:
        facts["window"] = _window(folder, args.window)
        if facts["window"] is not None:
            tables.append(_window_table(facts["window"]))
    if args.json:
        put_json(facts)
    else:
        for table in tables:
            put_table(table)
    return OK


def _load_per_core() -> float:
    """Processes per core that want to work, over the last minute; 0 where it is not known."""
    if not hasattr(os, "getloadavg"):
        return 0.0
    return os.getloadavg()[0] / (os.cpu_count() or 1)


def _check_recording(folder: Path) -> None:
    """Refuse at once what is no recording."""
    from stereotrack_core.recording.folder import open_recording

    open_recording(folder)


def _recording(given: Path | None) -> Path:
    return made_demo().recording if given is None else given


def _chain(folder: Path, frames: int, rounds: int) -> tuple[ChainSpeed, ...]:
    from stereotrack_core.experiments.benchmark.chain_speed import chain_speed
    from stereotrack_core.recording.folder import open_recording
    from stereotrack_core.tracking.presets import preset

    presets = {name: preset(name) for name in ("fast", "accurate", "thesis")}
    say("Timing the whole chain against plain block matching.")
    with progress("Chain", rounds * len(presets)) as show:
        return chain_speed(
            open_recording(folder), presets, frames=frames, rounds=rounds, on_progress=show
        )


def _chain_table(speeds: tuple[ChainSpeed, ...]) -> Table:
    rows = [
        (
            speed.preset,
            number(1000.0 * speed.seconds),
            number(1000.0 * speed.matching_seconds),
            number(speed.ratio, 2),
            number(1.0 / speed.seconds),
            number(speed.preparation_seconds),
            f"{speed.tracked} of {speed.frames}",
        )
        for speed in speeds
    ]
    return Table(
        "From encoded images to the pose, compared with StereoBM (64 disparities, window 15) alone",
        ("preset", ">chain ms", ">StereoBM ms", ">ratio", ">frame sets/s", ">once s", ">tracked"),
        rows,
    )


def _correction() -> tuple[CorrectionSpeed, ...]:
    from stereotrack_core.experiments.benchmark.correction_speed import (
        MEASUREMENTS,
        correction_speed,
    )

    say("Timing the correction step against a dense implementation and filterpy.")
    with progress("Correction", len(MEASUREMENTS)) as show:
        speeds = correction_speed(on_progress=show)
    if any(speed.filterpy_seconds is None for speed in speeds):
        say("filterpy is not installed, so its column stays empty (pip install filterpy).")
    return speeds


def _correction_table(speeds: tuple[CorrectionSpeed, ...], exponent: float) -> Table:
    rows = []
    for speed in speeds:
        theirs = float("nan") if speed.filterpy_seconds is None else speed.filterpy_seconds
        rows.append(
            (
                str(speed.m),
                number(1000.0 * speed.seconds, 3),
                number(1000.0 * speed.dense_seconds, 2),
                number(speed.dense_seconds / speed.seconds),
                number(1000.0 * theirs, 2),
                number(theirs / speed.seconds),
                f"{speed.difference:.0e}",
            )
        )
    return Table(
        f"Correction step with m measurements; time grows as m^{exponent:.2f}",
        (">m", ">ms", ">dense ms", ">times", ">filterpy ms", ">times", ">difference"),
        rows,
    )


def _window(folder: Path, window: Window | None) -> dict[str, Any] | None:
    """Figures of the window, which measures itself in its own process."""
    if window is None:
        say("The window was not timed because the workbench is not installed.")
        return None
    say("Timing frame steps in the window.")
    environment = dict(os.environ)
    if not environment.get("DISPLAY") and not environment.get("WAYLAND_DISPLAY"):
        environment.setdefault("QT_QPA_PLATFORM", "offscreen")
    try:
        done = subprocess.run(  # noqa: S603 - our own program
            [sys.executable, "-m", f"{window.package}.bench", str(folder)],
            capture_output=True,
            text=True,
            env=environment,
            timeout=_WINDOW_SECONDS,
            check=True,
        )
        figures = json.loads(done.stdout)
    except (subprocess.SubprocessError, OSError, json.JSONDecodeError) as error:
        last = (getattr(error, "stderr", None) or str(error)).strip().splitlines()[-1:]
        say(f"The window could not be timed: {' '.join(last)}")
        return None
    return dict(figures) if isinstance(figures, dict) else {"figures": figures}


def _window_table(figures: dict[str, Any]) -> Table:
    rows = [
        (name.replace("_", " "), f"{value:.1f}" if isinstance(value, float) else str(value))
        for name, value in figures.items()
    ]
    return Table("The window", ("what", ">value"), rows)


COMMAND = Command(
    name="bench",
    summary="run the README's benchmarks, as ratios",
    description=(
        "Measure on this machine: the whole chain against plain block matching on the same "
        "images, the correction step against a dense implementation and filterpy, and frame steps "
        "in the window."
    ),
    add_arguments=add_arguments,
    run=run,
)
