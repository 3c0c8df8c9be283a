"""From signs to the probability that a limb is lost."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.tracking.lost.coefficients import FOREARM, UPPER_ARM
from stereotrack_core.tracking.lost.signs import NEIGHBOUR

LOST_DEG = 45.0
"""Error of a limb's direction beyond which it is called lost."""


def with_neighbours(signs: FloatArray) -> FloatArray:
    """Signs (..., 6, 2 S) of each limb beside those of the other half of its arm."""
    return np.concatenate([signs, signs[..., list(NEIGHBOUR), :]], axis=-1)


def lost_probability(signs: FloatArray | None) -> FloatArray:
    """Probability (6,) that each limb is lost, more than 45 deg off; NaN where not known.

    A logistic regression, one for the upper arms and one for the forearms; its coefficients were
    fitted on simulated recordings alone, by ``tools/fit_lost_limbs.py``. Torso and head have
    none: they were lost too rarely to learn from.

    Parameters
    ----------
    signs : (6, S) float64 or None
        See :func:`limb_signs`.
    """
    result: FloatArray = np.full(len(LIMBS), np.nan)
    if signs is None:
        return result
    all_signs = with_neighbours(signs)
    for limbs, (constant, *slopes) in ((UPPER_ARMS, UPPER_ARM), (FOREARMS, FOREARM)):
        result[list(limbs)] = expit(constant + all_signs[list(limbs)] @ np.array(slopes))
    return result
