"""Runs beside each other in numbers: the same that ``stereotrack evaluate --against`` prints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.compare import (
    Candidate,
    Comparison,
    Pair,
    compare,
    how_it_is_made,
    measured,
    verdict,
)
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ..widgets.tables.runs_panel import ComparedCell, ComparedRow
from .judgement import Judgement, with_quality
from .runs import RunEntry

_LIMB_OF = {**{limb: limb for limb in LIMBS}, "torso_long": "torso"}
_UNITS = {"deg": "°"}
_NAN = math.nan

LOST_DEG = 45.0
"""An arm segment farther off than this is lost."""


@dataclass(frozen=True)
class ComparedRuns:
    """Numbers of several runs; the first is what the others are compared with."""

    words: str
    """What is compared, over which frames."""
    how: str
    """How intervals are made; empty for one run."""
    runs: tuple[str, ...]
    rows: tuple[ComparedRow, ...]


def shown_beside_each_other(
    entries: Sequence[RunEntry], active: RunEntry | None, judgements: Mapping[RunEntry, Judgement]
) -> tuple[RunEntry, ...]:
    """The active run first, then all others that are shown; empty where there is no run."""
    others = [entry for entry in entries if entry is not active and entry.visible]
    shown = [one for one in (active, *others) if one is not None and one in judgements]
    return tuple(shown) if shown and shown[0] is active else ()


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
        words = (
            f"Mean values of the run{where}{_against(truth)}."
            if rows
            else "No measures are available for this run."
        )
        return ComparedRuns(words, "", names, rows)
    try:
        found = compare(candidates, reference, selection)
    except InputError as error:
        return ComparedRuns(f"{error.what[0].upper()}{error.what[1:]}.", "", names, ())
    count = len(found.frames)
    frames = f"{count} frame{'' if count == 1 else 's'} that all runs share{where}"
    told = (
        "in brackets the 95 % confidence interval of the difference from the first run"
        if len(candidates) == 2
        else "in brackets the difference from the first run"
    )
    words = f"Mean values over {frames}{_against(truth)}; {told}."
    return ComparedRuns(words, how_it_is_made(found), names, _rows(found, truth))


def _against(truth: Judgement) -> str:
    return f", against {truth.truth.words}" if truth.truth is not None else ""


def _candidate(entry: RunEntry) -> Candidate:
    frames = list(entry.ordered())
    unexplained_fraction = np.array(
        [frame.estimate.unexplained_fraction for frame in frames], dtype=np.float64
    )
    return Candidate(entry.name, entry.trajectory(), unexplained_fraction)


def _rows_of_one(
    candidate: Candidate,
    reference: LandmarkTrajectory | None,
    truth: Judgement,
    selection: range | None,
) -> tuple[ComparedRow, ...]:
    series = measured(candidate, reference, selection)
    chosen = candidate.trajectory.frame
    if selection is not None:
        chosen = chosen[(chosen >= selection.start) & (chosen < selection.stop)]
    quality = truth.quality_over(chosen)
    return tuple(
        ComparedRow(
            _LIMB_OF.get(one.measure.name, ""),
            _label(one.measure.label, one.measure.unit, one.measure.name, quality),
            (ComparedCell(one.mean(one.weight > 0)),),
        )
        for one in series
    )


def _rows(found: Comparison, truth: Judgement) -> tuple[ComparedRow, ...]:
    quality = truth.quality_over(found.frames)
    rows = []
    for place, first in enumerate(found.pairs[0].measures):
        cells, measure = [ComparedCell(first.first_mean)], first.measure
        for pair in found.pairs:
            got = pair.measures[place]
            said = verdict(got, pair.first, pair.second)
            cells.append(
                ComparedCell(got.second_mean, got.difference, got.low, got.high, got.differs, said)
            )
        label = _label(measure.label, measure.unit, measure.name, quality)
        rows.append(ComparedRow(_LIMB_OF.get(measure.name, ""), label, tuple(cells)))
    if not found.against_reference:
        rows += _rows_apart(found.pairs)
    return tuple(rows)


def _rows_apart(pairs: Sequence[Pair]) -> list[ComparedRow]:
    """How far each run is from the first one, where nobody knows which is right."""
    rows = []
    for place, first in enumerate(pairs[0].apart.measures):
        cells = [ComparedCell(_NAN)]
        for pair in pairs:
            figures = pair.apart.measures[place].statistics
            said = (
                f"{first.label}, {pair.first} to {pair.second}: median difference "
                f"{figures.median:.1f} {first.unit}, 95th percentile {figures.p95:.1f}"
            )
            cells.append(ComparedCell(figures.mean, verdict=said))
        label = f"difference: {_label(first.label, first.unit, first.name, {})}"
        rows.append(ComparedRow(_LIMB_OF.get(first.name, ""), label, tuple(cells)))
    return rows


def _label(label: str, unit: str, name: str, quality: Mapping[str, float]) -> str:
    return with_quality(f"{label} [{_UNITS.get(unit, unit)}]", quality.get(name))
