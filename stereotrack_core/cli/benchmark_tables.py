"""The table of the benchmark: on the terminal, as Markdown and as CSV."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.output import Table, number

if TYPE_CHECKING:
    from stereotrack_core.experiments.benchmark.accuracy import Row
    from stereotrack_core.experiments.benchmark.growth import Cost
    from stereotrack_core.experiments.benchmark.speed import Speed

Speeds = Mapping[tuple[str, str], "Speed"]
"""By recording and contestant; empty where nothing was timed."""

_HEADINGS = (
    *("recording", "preset", ">torso mm", ">long axis", ">cross axis"),
    *(">upper arms (95 %)", ">forearms (95 %)", ">lost %"),
)
_SPEED_HEADINGS = (">frames/s", ">times StereoBM")


def readable(rows: Sequence[Row], speeds: Speeds, seeds: Sequence[int], what: str) -> Table:
    """Means, with their standard deviations over the seeds, one line per recording and preset."""
    spread = f" ± standard deviation over seeds {', '.join(map(str, seeds))}"
    title = f"{what}; degrees where no unit is said, means{spread if len(seeds) > 1 else ''}"
    headings = (*_HEADINGS, *(_SPEED_HEADINGS if speeds else ()))
    return Table(title, headings, [_line(row, speeds) for row in rows])


def _line(row: Row, speeds: Speeds) -> tuple[str, ...]:
    cells = (
        row.recording,
        row.contestant,
        _value(row, "torso_position", 0),
        _value(row, "torso_long"),
        _value(row, "torso_cross"),
        f"{_value(row, 'upper_arms')} ({_value(row, 'upper_arms_p95')})",
        f"{_value(row, 'forearms')} ({_value(row, 'forearms_p95')})",
        _value(row, "lost"),
    )
    if not speeds:
        return cells
    speed = speeds[row.recording, row.contestant]
    return (*cells, number(speed.frames_per_second), number(speed.ratio))


def _value(row: Row, name: str, digits: int = 1) -> str:
    spread = row.spread[name]
    mean = number(row.mean[name], digits)
    return f"{mean} ± {number(spread, digits)}" if math.isfinite(spread) else mean


def in_full(rows: Sequence[Row], speeds: Speeds) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows with every number in full."""
    names = list(rows[0].mean) if rows else []
    columns = ["recording", "preset", "seeds", "frames"]
    columns += [f"{name}{end}" for name in names for end in ("", "_sd")]
    columns += ["frames_per_second", "ratio_to_stereobm"] if speeds else []
    lines: list[list[str | float | int]] = []
    for row in rows:
        line: list[str | float | int] = [row.recording, row.contestant, row.seeds, row.frames]
        for name in names:
            line += [row.mean[name], row.spread[name]]
        if speeds:
            speed = speeds[row.recording, row.contestant]
            line += [speed.frames_per_second, speed.ratio]
        lines.append(line)
    return columns, lines


def facts(rows: Sequence[Row], speeds: Speeds) -> list[dict[str, Any]]:
    """The same for JSON."""
    return [
        {
            "recording": row.recording,
            "preset": row.contestant,
            "seeds": row.seeds,
            "frames": row.frames,
            "mean": row.mean,
            "standard_deviation": row.spread,
            "speed": speeds.get((row.recording, row.contestant)),
        }
        for row in rows
    ]


def growth_table(title: str, what: str, costs: Sequence[Cost], exponent: float) -> Table:
    """Costs of a frame by size."""
    rows = [
        (str(cost.size), number(cost.milliseconds), number(cost.milliseconds / cost.size, 3))
        for cost in costs
    ]
    grows = f"{title} grows as {what}^{number(exponent, 2)} (processor time)"
    return Table(grows, (f">{what}", ">ms", ">ms for each"), rows)
