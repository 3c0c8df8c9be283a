"""Whether the limbs that a run itself takes for lost are lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.evaluation.summary import LOST_ANGLE

CALLED = 0.5
"""Probability above which a limb is called lost."""


@dataclass(frozen=True)
class Doubts:
    """Counts of arm segments of tracked frames.

    Attributes
    ----------
    judged : int
        Arm segments of which both the error and the run's own judgement are known.
    lost, called, both : int
        Really lost, called lost by the run, and both.
    """

    judged: int
    lost: int
    called: int
    both: int

    @property
    def precision(self) -> float:
        """Share of those called lost that are lost; NaN where none is called lost."""
        return self.both / self.called if self.called else float("nan")

    @property
    def recall(self) -> float:
        """Share of those lost that are called lost; NaN where none is lost."""
        return self.both / self.lost if self.lost else float("nan")


def doubts_against(frame: IntArray, limb_lost: FloatArray, errors: LimbErrors) -> Doubts:
    """Compare a run's own judgement with its errors.

    Parameters
    ----------
    frame : (F,) int64
        Of the run.
    limb_lost : (F, 6) float64
        Probabilities in the order of ``LIMBS``; NaN where not known.
    errors : LimbErrors
        Of the same run.
    """
    _, own, other = np.intersect1d(frame, errors.frame, return_indices=True)
    chance = limb_lost[own][:, [*UPPER_ARMS, *FOREARMS]]
    angle = errors.arm_segments[other]
    known = np.isfinite(chance) & np.isfinite(angle)
    lost, called = (angle > LOST_ANGLE) & known, (chance > CALLED) & known
    counts = (np.count_nonzero(rows) for rows in (known, lost, called, lost & called))
    return Doubts(*(int(count) for count in counts))
