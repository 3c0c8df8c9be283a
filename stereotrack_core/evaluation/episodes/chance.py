"""From a run's signs to the probability that a limb is lost, over time."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.evaluation.episodes import coefficients
from stereotrack_core.evaluation.episodes.signs import episode_signs
from stereotrack_core.tracking.run import Run


def lost_chances(run: Run, fps: float) -> FloatArray:
    """Probability (F, 6) that each limb is in an episode by its error, by a run's own signs.

    A logistic regression over :func:`episode_signs`, one for the upper arms and one for the
    forearms, fitted on simulated recordings alone by ``tools/fit_episodes.py``. It differs from
    ``Run.limb_lost``, which knows single frames only, by looking at what is before and after, and
    by what it is the probability of: not of a limb that is off in this frame, but of one that is
    in a stretch in which it is. A
    run that does not say how likely limbs are lost is judged by the other signs alone. In
    frames that are not tracked all limbs are lost; NaN for torso and head elsewhere, which were
    lost too rarely to learn from.
    """
    signs = episode_signs(run, fps)
    result: FloatArray = np.full((len(run.frame), len(LIMBS)), np.nan)
    said = bool(np.isfinite(run.limb_lost[run.tracked]).any())
    for limbs, name in ((UPPER_ARMS, "UPPER_ARM"), (FOREARMS, "FOREARM")):
        fitted = getattr(coefficients, name if said else f"{name}_WITHOUT_LOST")
        constant, slopes = fitted[0], np.array(fitted[1:])
        result[:, list(limbs)] = expit(constant + signs[:, list(limbs)] @ slopes)
    for limb in (TORSO, *UPPER_ARMS, *FOREARMS):
        result[~run.tracked, limb] = 1.0
    return result
