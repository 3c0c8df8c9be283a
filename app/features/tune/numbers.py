"""Trials beside the run, and beside each other, in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray

from ...session.comparison import LOST_DEG
from ...session.judgement import Judgement
from ...session.runs import RunEntry
from ...widgets.tables.panels import TRIAL_TIP, number_cell
from ...widgets.tables.table import Cell, CellRow

_UNKNOWN = "Not known here. Without depth there is no cloud to be explained."
_ERROR = ("arms °", "torso °", "lost %", "unexpl. %", "untracked")
_SIGMA = ("arms ± °", "torso ± °", "unexpl. %", "untracked")


@dataclass(frozen=True)
class Summary:
    """A stretch in numbers; less is better in all of them."""

    arms: float
    torso: float
    """`arms` and `torso`: degrees. Mean angle against the reference, or mean standard deviation."""
    lost: float
    """Share of the arms' segments that are lost, in percent; NaN without a reference."""
    unexplained: float
    """Mean share of the cloud, in percent."""
    missing: int
    """Frames that are not tracked."""


def summary_of(judgement: Judgement, frames: IntArray | None = None) -> Summary:
    """Numbers of a run over some frames, or over all that it has."""
    inside: BoolArray = np.ones(len(judgement.frame), dtype=np.bool_)
    if frames is not None:
        inside = np.isin(judgement.frame, frames)
    arms = np.array([v[inside] for limb, v in judgement.limbs.items() if "arm" in limb])
    known = arms[np.isfinite(arms)]
    against = judgement.measure == "error"
    return Summary(
        arms=_mean(known),
        torso=_mean(judgement.limbs["torso"][inside]),
        lost=100.0 * _mean((known > LOST_DEG).astype(np.float64)) if against else float("nan"),
        unexplained=100.0 * _mean(judgement.unexplained_fraction[inside]),
        missing=int(np.count_nonzero(~judgement.tracked[inside])),
    )


def trial_table(
    run: RunEntry | None,
    trials: Sequence[RunEntry],
    judgements: Mapping[RunEntry, Judgement],
    against: RunEntry | None,
) -> tuple[tuple[str, ...], list[CellRow]]:
    """Headings, and cells of the run and of each trial, with differences from one of them.

    Without trials there is nothing to show.

    Parameters
    ----------
    run : RunEntry or None
        Whose settings were changed.
    against : RunEntry or None
        What differences are from; the run where it is not given or has no frames.
    """
    entries = [entry for entry in (run, *trials) if entry is not None]
    chosen = against if against in entries and against in judgements else run
    other = judgements.get(chosen) if chosen is not None else None
    truth = all(j.measure == "error" for e in entries if (j := judgements.get(e)) is not None)
    tried = [_frames(judgements.get(entry)) for entry in trials]
    common = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *tried]))
    headings = _ERROR if truth else _SIGMA
    rows: list[CellRow] = []
    ones = (1,) * (len(headings) - 1)
    for entry in entries:
        judgement, is_run = judgements.get(entry), entry is run
        frames = common if is_run else _frames(judgement)
        both = np.intersect1d(frames, _frames(other))
        here, there = _values(judgement, both, truth), _values(other, both, truth)
        is_base = entry is chosen
        name = f"{'◆ ' if is_base else ''}{_two_lines(entry, is_run=is_run)}"
        values = _values(judgement, frames, truth)
        unknown = Cell("–", _UNKNOWN, "muted") if len(frames) else None
        numbers = [
            unknown
            if unknown is not None and np.isnan(value)
            else number_cell(value, np.nan if is_base else a - b, digits)
            for value, a, b, digits in zip(values, here, there, (*ones, 0), strict=True)
        ]
        rows.append((Cell(name, f"{entry.name}. {TRIAL_TIP}", bold=is_run), *numbers))
    return headings, rows if trials else []


def _two_lines(entry: RunEntry, *, is_run: bool) -> str:
    """What differs, or the run, and below it the frames."""
    if is_run:
        return f"{entry.name}\nin these frames"
    done, wanted = len(entry.frames), entry.wanted
    if done < len(wanted):
        return f"{entry.name}\n{done} of {len(wanted)} frames"
    first, _, others = entry.name.partition(", ")
    return f"{first}\n{others or f'frames {wanted.start} – {wanted.stop - 1}'}"


def _values(judgement: Judgement | None, frames: IntArray, truth: bool) -> tuple[float, ...]:
    """Numbers over some frames in the order of the headings; NaN where nothing is known."""
    if judgement is None or not len(frames):
        return (float("nan"),) * len(_ERROR if truth else _SIGMA)
    arms, torso, lost, *others = map(float, astuple(summary_of(judgement, frames)))
    return (arms, torso, *([lost] if truth else []), *others)


def _frames(judgement: Judgement | None) -> IntArray:
    return judgement.frame if judgement is not None else np.empty(0, dtype=np.int64)


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")
