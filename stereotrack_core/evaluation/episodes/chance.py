"""From a run's signs to the probability that a limb fails, over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from scipy.special import expit

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.evaluation.episodes import coefficients
from stereotrack_core.evaluation.episodes.signs import episode_signs
from stereotrack_core.tracking.frame import Run

ARM_HALVES: MappingProxyType[str, tuple[int, ...]] = MappingProxyType(
    {"UPPER_ARM": UPPER_ARMS, "FOREARM": FOREARMS}
)
"""Limbs that are judged alike, by the name of their coefficients."""

UNSAID = "_WITHOUT_LOST"
"""Ending of that name for runs that do not say how likely limbs are lost."""

Coefficients: TypeAlias = Mapping[str, Sequence[float]]
"""A constant and a slope per sign, by their name."""

_FITTED: Coefficients = MappingProxyType(
    {name: getattr(coefficients, name) for half in ARM_HALVES for name in (half, f"{half}{UNSAID}")}
)


def lost_chances(run: Run, fps: float, fitted: Coefficients = _FITTED) -> FloatArray:
    """Probability (F, 6) that each limb is in an episode by its error, by a run's own signs.

    A logistic regression over :func:`episode_signs`, one for the upper arms and one for the
    forearms, fitted on simulated recordings alone by ``tools/fit_episodes.py``. It differs from
    ``Run.limb_lost``, which knows single frames only, by looking at what is before and after, and
    by what it is the probability of: not of a limb that is off in this frame, but of one that is
    in a stretch in which it is. A run that does not say how likely limbs are lost is judged by
    the other signs alone. In frames that are not tracked all limbs fail; NaN for torso and head
    elsewhere, which failed too rarely to learn from.

    Parameters
    ----------
    run : Run
    fps : float
    fitted : mapping of str to sequence of float
    """
    said = bool(np.isfinite(run.limb_lost[run.tracked]).any())
    signs = episode_signs(run, fps, said=said)
    result: FloatArray = np.full((len(run.frame), len(LIMBS)), np.nan)
    for half, limbs in ARM_HALVES.items():
        constant, *slopes = fitted[half if said else f"{half}{UNSAID}"]
        result[:, list(limbs)] = expit(constant + signs[:, list(limbs)] @ np.array(slopes))
    for limb in (TORSO, *UPPER_ARMS, *FOREARMS):
        result[~run.tracked, limb] = 1.0
    return result
