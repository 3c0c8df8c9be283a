"""Runs beside each other in numbers: the same that ``stereotrack evaluate --against`` prints."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation import compare as comparing
from stereotrack_core.evaluation.summary import within
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...session.judgement import Judgement, with_quality
from ...session.runs import RunEntry
from ...session.session import Snapshot
from ...widgets.style.colours import LIMB_COLOURS
from ...widgets.tables.table import Cell, CellRow

_LIMB_OF = {**{limb: limb for limb in LIMBS}, "torso_long": "torso"}
_UNITS = {"deg": "°"}


@dataclass(frozen=True)
class ComparedRuns:
    """Numbers of several runs; the first is what the others are compared with."""

    words: str
    how: str  # how intervals are made; empty for one run
    runs: tuple[str, ...]
    rows: tuple[CellRow, ...]
    """A measure, a value of each run, and of two runs the difference and a conclusion."""


def shown_beside_each_other(now: Snapshot) -> tuple[RunEntry, ...]:
    """The active run first, then all others that are shown; empty where there is no run."""
    if now.judgement is None or now.active is None:
        return ()
    others = (one for one in now.runs if one is not now.active and one.visible)
    return (now.active, *(one for one in others if one in now.judgements))


def compared(shown: Sequence[RunEntry], truth: Judgement, selection: range | None) -> ComparedRuns:
    """Compare the first run with each of the others.

    At least one run is shown; `truth` is the judgement of the first, and says what errors are
    measured against. A selection limits the comparison to its frames.
    """
    candidates = [_candidate(entry) for entry in shown]
    names = tuple(entry.name for entry in shown)
    reference = truth.truth.trajectory if truth.truth is not None else None
    where = " in the selection" if selection is not None else ""
    if len(candidates) == 1:
        rows = _rows_of_one(candidates[0], reference, truth, selection)
        words = f"Mean values of the run{where}{_against(truth)}."
        none = "No measures are available for this run."
        return ComparedRuns(words if rows else none, "", names, rows)
    try:
        found = comparing.compare(candidates, reference, selection)
    except InputError as error:
        return ComparedRuns(f"{error.what[0].upper()}{error.what[1:]}.", "", names, ())
    interval = "95 % confidence interval of the " if len(candidates) == 2 else ""
    frames = f"{counted(len(found.frames), 'frame')} that all runs share{where}"
    told = f"in brackets the {interval}difference from the first run"
    words = f"Mean values over {frames}{_against(truth)}; {told}."
    return ComparedRuns(words, comparing.how_it_is_made(found), names, _rows(found, truth))


_OF_STRETCHES = ("upper_arms", "forearms", "lost", "unexplained")  # measures told of each of them


def compared_stretches(
    shown: Sequence[RunEntry], truth: Judgement, segments: Sequence[Segment]
) -> ComparedRuns:
    """The same for each named stretch, by a few measures."""
    candidates, names = [_candidate(entry) for entry in shown], tuple(one.name for one in shown)
    reference = truth.truth.trajectory if truth.truth is not None else None
    rows: list[CellRow] = []
    for name in dict.fromkeys(one.name for one in segments):
        own = [one for one in segments if one.name == name]
        if len(candidates) == 1:
            frame = candidates[0].trajectory.frame
            part = frame[within(own, frame)]
            rows += _rows_of_one(candidates[0], reference, truth, part, f"{name}: ")
            continue
        ((_, found),) = comparing.compare_segments(candidates, reference, own)
        if found is not None:
            rows += _rows(found, truth, f"{name}: ")
    words = f"Mean values over each named stretch{_against(truth)}."
    if not rows:
        words = "The named stretches have no frame that all runs share."
    return ComparedRuns(words, "", names, tuple(rows))


def _against(truth: Judgement) -> str:
    return f", against {truth.truth.words}" if truth.truth is not None else ""


def _candidate(entry: RunEntry) -> comparing.Candidate:
    unexplained = [frame.estimate.unexplained_fraction for frame in entry.ordered()]
    return comparing.Candidate(entry.name, entry.trajectory(), np.array(unexplained, np.float64))


def _rows_of_one(
    candidate: comparing.Candidate,
    reference: LandmarkTrajectory | None,
    truth: Judgement,
    frames: range | IntArray | None,
    stretch: str = "",
) -> tuple[CellRow, ...]:
    series = comparing.measured(candidate, reference, frames)
    quality = truth.quality_over(comparing.shared_frames((candidate,), None, frames))
    return tuple(
        (_name(one.measure, quality, stretch), Cell(_number(one.mean(one.weight > 0))))
        for one in series
        if not stretch or one.measure.name in _OF_STRETCHES
    )


def _rows(found: comparing.Comparison, truth: Judgement, stretch: str = "") -> tuple[CellRow, ...]:
    """Two runs leave room for words; of more the intervals and verdicts are in the tips."""
    quality, two = truth.quality_over(found.frames), len(found.pairs) == 1
    rows: list[CellRow] = []
    for place, first in enumerate(found.pairs[0].measures):
        if stretch and first.measure.name not in _OF_STRETCHES:
            continue
        row = [_name(first.measure, quality, stretch), Cell(_number(first.first_mean))]
        for pair in found.pairs:
            got = pair.measures[place]
            row += _compared(got, comparing.verdict(got, pair.first, pair.second), two=two)
        rows.append(row)
    if not found.against_reference and not stretch:
        rows += _rows_apart(found.pairs, two=two)
    return tuple(rows)


def _rows_apart(pairs: Sequence[comparing.Pair], *, two: bool) -> list[CellRow]:
    """How far each run is from the first one, where nobody knows which is right."""
    rows: list[CellRow] = []
    for place, first in enumerate(pairs[0].apart.measures):
        named = comparing.Measured(first.name, first.label, first.unit)
        row = [_name(named, {}, "difference: "), Cell()]
        for pair in pairs:
            figures = pair.apart.measures[place].statistics
            said = (
                f"{first.label}, {pair.first} to {pair.second}: median difference "
                f"{figures.median:.1f} {first.unit}, 95th percentile {figures.p95:.1f}"
            )
            row += _compared(comparing.Paired(named, second_mean=figures.mean), said, two=two)
        rows.append(row)
    return rows


def _name(measure: comparing.Measured, quality: Mapping[str, float], before: str = "") -> Cell:
    name = f"{before}{measure.label} [{_UNITS.get(measure.unit, measure.unit)}]"
    swatch = LIMB_COLOURS.get(_LIMB_OF.get(measure.name, ""), "")
    return Cell(with_quality(name, quality.get(measure.name)), swatch=swatch)


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1f}"


def _compared(got: comparing.Paired, said: str, *, two: bool) -> list[Cell]:
    """Value, difference and conclusion, or the value with the difference in brackets."""
    sentence = f"{said[0].upper()}{said[1:]}." if said else ""
    # only what the frames can show is coloured
    colour = "" if not got.differs else "good" if got.difference < 0 else "warning"
    value, change = _number(got.second_mean) or ("unknown" if said else ""), ""
    apart = not math.isnan(got.difference) and not got.low == got.high == 0.0
    if apart and not math.isnan(got.second_mean):
        change = f"{got.difference:+z.1f}"
    if not two:
        return [Cell(f"{value} ({change})" if change else value, sentence, colour)]
    known = not math.isnan(got.low)
    between = f"{got.low:+z.1f} to {got.high:+z.1f}" if known else "too few frames"
    interval = f"{change} ({between})" if change else ""
    shown = ((value, sentence), (interval, sentence), (said, said))
    return [Cell(text, tip, colour) for text, tip in shown]
