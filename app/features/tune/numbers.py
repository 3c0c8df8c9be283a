"""Attempts beside the run, and beside each other, in numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray

from ...session.comparison import LOST_DEG
from ...session.judgement import Judgement
from ...session.runs import RunEntry
from ...widgets.tables.attempts_panel import AttemptRow, AttemptTable

_ERROR = ("arms °", "torso °", "lost %", "unexpl. %")
_SIGMA = ("arms ± °", "torso ± °", "unexpl. %")
_NOT_TRACKED = "untracked"


@dataclass(frozen=True)
class Summary:
    """A stretch in numbers; less is better in all of them.

    Attributes
    ----------
    arms, torso : float, degrees
        Mean angle against the reference, or mean standard deviation.
    lost : float
        Share of the arms' segments that are lost, in percent; NaN without a reference.
    unexplained : float
        Mean share of the cloud, in percent.
    missing : int
        Frames that are not tracked.
    """

    arms: float
    torso: float
    lost: float
    unexplained: float
    missing: int

    @property
    def order(self) -> tuple[float, float]:
        """Key by which the best comes first: who loses the person is never the best."""
        return float(self.missing), np.inf if np.isnan(self.arms) else self.arms

    def values(self, *, against_truth: bool) -> tuple[float, ...]:
        """In the order of the headings."""
        lost = (self.lost,) if against_truth else ()
        return (self.arms, self.torso, *lost, self.unexplained, float(self.missing))


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


def attempt_table(
    run: RunEntry | None,
    attempts: Sequence[RunEntry],
    judgements: Mapping[RunEntry, Judgement],
    against: RunEntry | None,
    changes: Callable[[RunEntry], str],
) -> AttemptTable:
    """A row for the run and for each attempt, with differences from one of them.

    Parameters
    ----------
    run : RunEntry or None
        Whose settings were changed.
    attempts : sequence of RunEntry
    judgements : mapping from RunEntry to Judgement
    against : RunEntry or None
        What differences are from; the run where it is not given or has no frames.
    changes : callable
        What an attempt changed, in words.
    """
    entries = [entry for entry in (run, *attempts) if entry is not None]
    chosen = against if against in entries and against in judgements else run
    other = judgements.get(chosen) if chosen is not None else None
    truth = all(j.measure == "error" for e in entries if (j := judgements.get(e)) is not None)
    tried = [_frames(judgements.get(entry)) for entry in attempts]
    common = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *tried]))
    rows = []
    for entry in entries:
        judgement = judgements.get(entry)
        frames = common if entry is run else _frames(judgement)
        if judgement is None or not len(frames):
            nothing = (float("nan"),) * (5 if truth else 4)
            rows.append(_row(entry, run, chosen, changes(entry), nothing, nothing))
            continue
        values = summary_of(judgement, frames).values(against_truth=truth)
        rows.append(
            _row(
                entry,
                run,
                chosen,
                changes(entry),
                values,
                _changes(judgement, other, frames, truth),
            )
        )
    return AttemptTable((*(_ERROR if truth else _SIGMA), _NOT_TRACKED), tuple(rows))


def _changes(
    judgement: Judgement, other: Judgement | None, frames: IntArray, truth: bool
) -> tuple[float, ...]:
    """Differences over the frames that both have."""
    both = np.intersect1d(frames, _frames(other))
    if other is None or not len(both):
        return (float("nan"),) * (5 if truth else 4)
    here = summary_of(judgement, both).values(against_truth=truth)
    there = summary_of(other, both).values(against_truth=truth)
    return tuple(a - b for a, b in zip(here, there, strict=True))


def _row(
    entry: RunEntry,
    run: RunEntry | None,
    chosen: RunEntry | None,
    changed: str,
    values: tuple[float, ...],
    changes: tuple[float, ...],
) -> AttemptRow:
    done, count = len(entry.frames), len(entry.wanted)
    more = f", {done} of {count} frames" if done < count and entry is not run else ""
    return AttemptRow(
        name=f"{entry.name}{more}",
        changed="in these frames" if entry is run else changed,
        values=values,
        changes=changes,
        is_run=entry is run,
        is_base=entry is chosen,
    )


def _frames(judgement: Judgement | None) -> IntArray:
    return judgement.frame if judgement is not None else np.empty(0, dtype=np.int64)


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")
