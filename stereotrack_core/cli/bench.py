"""``stereotrack bench``: the benchmarks of the README, as ratios."""

from __future__ import annotations

import json
import os
import subprocess
from argparse import Namespace
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import JSON, check_least, option
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.progress import progress
from stereotrack_core.demo import copied_demo
from stereotrack_core.experiments.benchmark.speed import (
    MEASUREMENTS,
    ChainSpeed,
    CorrectionSpeed,
    chain_speed,
    correction_speed,
    growth,
)
from stereotrack_core.own_program import module_command
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.presets import preset
from stereotrack_core.window import Window

DESCRIPTION = (
    "Measure on this machine: the whole chain against plain block matching on the same "
    "images, the correction step against a dense implementation and filterpy, and frame steps "
    "in the window."
)

PARTS = ("chain", "correction", "window")

OPTIONS = (
    option(
        "recording RECORDING",
        "recording with stereo views (default: the demo recording, which is copied if missing)",
        type=Path,
        nargs="?",
    ),
    option(
        "--only",
        "run only this benchmark; may be given several times",
        action="append",
        choices=PARTS,
    ),
    option(
        "--frames N", "frame sets per round of the whole chain (default: 40)", type=int, default=40
    ),
    option(
        "--rounds N",
        "rounds of the whole chain; medians are reported (default: 5)",
        type=int,
        default=5,
    ),
    JSON,
)


_WINDOW_SECONDS = 600.0
_BUSY = 0.7


def run(args: Namespace) -> int:
    """Run the benchmarks and print them."""
    check_least(1, frames=args.frames, rounds=args.rounds)
    if args.recording is not None:
        open_recording(args.recording)  # refuses at once what is none
    parts = args.only or PARTS
    load = _load_per_core()
    if load > _BUSY:
        say(f"The machine is busy (load {load:.1f} per core). The results will be inaccurate.")
    folder: Path | None = None
    if set(parts) & {"chain", "window"}:
        folder = args.recording or copied_demo().recording
    facts: dict[str, Any] = {"cores": os.cpu_count(), "load_per_core": load, "recording": folder}
    tables: list[Table] = []
    if folder is not None and "chain" in parts:
        speeds = _chain(folder, args.frames, args.rounds)
        facts["chain"] = [{"ratio": speed.ratio, **vars(speed)} for speed in speeds]
        tables.append(_chain_table(speeds))
    if "correction" in parts:
        corrections = _correction()
        facts["correction"] = {"growth_exponent": growth(corrections), "sizes": corrections}
        tables.append(_correction_table(corrections, growth(corrections)))
    if folder is not None and "window" in parts:
        facts["window"] = _window(folder, args.window)
        if facts["window"] is not None:
            rows = [
                (name.replace("_", " "), number(value) if isinstance(value, float) else str(value))
                for name, value in facts["window"].items()
            ]
            tables.append(Table("The window", ("what", ">value"), rows))
    put_result(facts, *tables, as_json=args.json)
    return OK


def _load_per_core() -> float:
    """Processes per core that want to work, over the last minute; 0 where it is not known."""
    if not hasattr(os, "getloadavg"):
        return 0.0
    return os.getloadavg()[0] / (os.cpu_count() or 1)


def _chain(folder: Path, frames: int, rounds: int) -> tuple[ChainSpeed, ...]:
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
            module_command(f"{window.package}.bench", [str(folder)]),
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
