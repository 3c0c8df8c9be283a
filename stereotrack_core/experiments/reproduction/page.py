"""The page on which the thesis's results and ours stand beside each other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.experiments.reproduction.plan import THESIS
from stereotrack_core.experiments.reproduction.tables import OF_THESIS, ComparedTable
from stereotrack_core.experiments.reproduction.thesis import (
    FILTER_MS,
    REFERENCE_GOOD_TO_DEG,
    SEGMENTATION_MS,
    SOURCE,
    STEREO_MS_PER_VIEW,
    ThesisMotion,
)
from stereotrack_core.experiments.reproduction.timing import Timing
from stereotrack_core.experiments.reproduction.words import page_table
from stereotrack_core.report.pages import Table, code, embedded, number
from stereotrack_core.report.pages import page as drawn_page
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset


@dataclass(frozen=True)
class RecordingFacts:
    """What a recording is, in words."""

    name: str
    stature: float
    frames: int
    fps: float
    clothes: str
    motions: str


@dataclass(frozen=True)
class MotionPictures:
    """Pictures of one motion.

    Attributes
    ----------
    motion : ThesisMotion
    curves : bytes
        SVG.
    strips : mapping from a way of tracking, in words, to a JPEG
    frames : tuple of int
        That the strips show.
    """

    motion: ThesisMotion
    curves: bytes
    strips: Mapping[str, bytes]
    frames: tuple[int, ...]


@dataclass(frozen=True)
class Circumstances:
    """How the numbers came about.

    Attributes
    ----------
    command : str
        That makes them again.
    versions : mapping from program to version
    tracked_by : tuple of str
        Versions of this program that made the runs.
    machine : str
    seeds : int
    presets : tuple of str
    runs, wanted : int
        Runs that are finished, and all that belong to the tables.
    short : bool
    """

    command: str
    versions: Mapping[str, str]
    tracked_by: tuple[str, ...]
    machine: str
    seeds: int
    presets: tuple[str, ...]
    runs: int
    wanted: int
    short: bool


@dataclass(frozen=True)
class Results:
    """Everything that the page shows."""

    recordings: tuple[RecordingFacts, ...]
    tables: tuple[ComparedTable, ...]
    timings: tuple[Timing, ...]
    timing_picture: bytes | None
    motions: tuple[MotionPictures, ...]
    circumstances: Circumstances


_TITLE = "Reproduction of the thesis's evaluation"
_ORDER = ("4.1", "4.2", "4.3", "4.4", "fast", "motions")


def page(results: Results) -> str:
    """The whole page as HTML."""
    by_key = {compared.key: compared for compared in results.tables}
    made = results.circumstances
    timed = bool(results.timings) and results.timing_picture is not None
    return drawn_page(
        "reproduction.html",
        _TITLE,
        lead=_lead(by_key["4.1"]),
        made=made,
        of_thesis=OF_THESIS,
        source=SOURCE,
        good_to=REFERENCE_GOOD_TO_DEG,
        recordings=_recordings(results.recordings),
        compared_tables=[
            {"key": key, "title": one.title, "table": page_table(one), "remark": one.remark}
            for key in _ORDER
            if (one := by_key.get(key)) is not None
        ],
        timings=_timings(results.timings),
        timing_picture=embedded(results.timing_picture or b"", "svg+xml") if timed else "",
        motions=results.motions,
        embedded=embedded,
        circumstances=_circumstances(made),
        presets=[_parameters(name) for name in made.presets],
    )


def _lead(compared: ComparedTable) -> str:
    """The main result in words."""
    said = []
    for measure, label in (("upper_arms", "upper arms"), ("forearms", "forearms")):
        values = {
            line.source: line.figures[-1].mean for line in compared.lines if line.measure == measure
        }
        others = [
            f"{source} {number(value)}"
            for source, value in values.items()
            if source != OF_THESIS and math.isfinite(value)
        ]
        if others:
            said.append(f"{label}: {', '.join(others)}, in the thesis {values[OF_THESIS]:.1f}")
    if not said:
        return "No tracking results yet."
    return (
        f"Mean errors in degrees at the thesis's pace. {'; '.join(said).capitalize()}. The "
        "thesis's numbers come from real recordings, ours from simulated recordings with exact "
        "ground truth. Only the relations between numbers can be compared."
    )


def _recordings(recordings: Sequence[RecordingFacts]) -> Table:
    rows = [
        (r.name, f"{r.stature:.2f}", str(r.frames), f"{r.frames / r.fps:.0f}", r.clothes, r.motions)
        for r in recordings
    ]
    return Table(("", ">stature [m]", ">frames", ">seconds", "clothes", "motions"), rows)


def _timings(timings: Sequence[Timing]) -> Table:
    thesis = (number(FILTER_MS, 0), number(STEREO_MS_PER_VIEW, 0), number(SEGMENTATION_MS, 0))
    rows: list[tuple[str, ...]] = [(OF_THESIS, *thesis, "m³, as stated")]
    for timed in timings:
        values = (timed.filter_ms, timed.stereo_ms_per_view, timed.segmentation_ms)
        what = "m" if timed.preset == THESIS else "points"
        power = f"{what} to the power {number(timed.exponent(), 2)}"
        rows.append((timed.preset, *(number(value) for value in values), power))
    columns = (
        *("", ">tracking [ms]", ">stereo, each view [ms]", ">segmentation [ms]"),
        "growth of tracking time",
    )
    return Table(columns, rows)


def _circumstances(made: Circumstances) -> Table:
    rows = [
        ("command", code(made.command)),
        ("machine", made.machine),
        *made.versions.items(),
        ("runs tracked by version", ", ".join(made.tracked_by) or "–"),
        ("seeds", f"0 to {made.seeds - 1} for {THESIS}, 0 for others"),
        ("recordings", "simulated with seed 0; the reference is the exact ground truth"),
    ]
    return Table(("", ""), rows)


def _parameters(name: str) -> dict[str, str | Table]:
    """Parameters of a preset that differ from the defaults, and the others."""
    columns, values = ("parameter", ">value", "unit", ">default"), preset(name).values()
    lines = {
        row: (row.name, str(values[row.name]), row.unit, str(row.default))
        for row in Settings.rows()
    }
    changed = [line for row, line in lines.items() if values[row.name] != row.default]
    same = [line for row, line in lines.items() if values[row.name] == row.default]
    return {"name": name, "changed": Table(columns, changed), "same": Table(columns, same)}
