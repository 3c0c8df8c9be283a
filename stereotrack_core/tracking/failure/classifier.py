"""From signs to the probability that a limb is lost."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from scipy.special import expit

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import (
    OVERCONFIDENCE,
    Correspondences,
    Estimate,
    Prior,
    limb_sigma_deg,
)
from stereotrack_core.tracking.failure.coefficients import FOREARM, UPPER_ARM
from stereotrack_core.tracking.failure.features import NEIGHBOUR, Judged, limb_features, unexpected
from stereotrack_core.tracking.residuals.surface import unexplained_fraction_of
from stereotrack_core.tracking.state import Setup

LOST_DEG = 45.0
"""Error of a limb's direction beyond which it is called lost."""


def with_neighbours(signs: FloatArray) -> FloatArray:
    """Signs (..., 6, 2 S) of each limb beside those of the other half of its arm."""
    return np.concatenate([signs, signs[..., list(NEIGHBOUR), :]], axis=-1)


def failure_probability(signs: FloatArray | None) -> FloatArray:
    """Probability (6,) that each limb is lost, more than 45 deg off; NaN where not known.

    A logistic regression, one for the upper arms and one for the forearms; its coefficients were
    fitted on simulated recordings alone, by ``tools/fit_lost_limbs.py``. Torso and head have
    none: they were lost too rarely to learn from.

    Parameters
    ----------
    signs : (6, S) float64 or None
        See :func:`limb_features`.
    """
    result: FloatArray = np.full(len(LIMBS), np.nan)
    if signs is None:
        return result
    all_signs = with_neighbours(signs)
    for limbs, (constant, *slopes) in ((UPPER_ARMS, UPPER_ARM), (FOREARMS, FOREARM)):
        result[list(limbs)] = expit(constant + all_signs[list(limbs)] @ np.array(slopes))
    return result


@dataclass(frozen=True, eq=False)
class Unjudged:
    """What a tracker has found in a frame; see :class:`Estimate`.

    Attributes
    ----------
    sigma_points : Pose
        Stacked (2n + 1), of the posterior.
    movement : (n,) float64
        Of the error state since the frame before.
    """

    pose: Pose
    x: FloatArray
    P: FloatArray
    sigma_points: Pose
    residual: float
    innovation: float
    correspondences: Correspondences
    movement: FloatArray
    prior: Prior | None


def judged(cloud: Cloud, setup: Setup, found: Unjudged, seconds: float) -> Estimate:
    """State a pose with the signs by which it can be judged; it took so many seconds."""
    begun, body = perf_counter(), setup.body
    frames = body.frames(found.pose)
    sigma = limb_sigma_deg(body.frames(found.sigma_points), setup.weights.covariance)
    share = unexplained_fraction_of(cloud.points, body, frames)
    jump = unexpected(found.movement, found.prior, setup.joints)
    signs = limb_features(
        cloud, body, Judged(found.pose, frames, sigma, share, found.correspondences, jump)
    )
    return Estimate(
        tracked=True,
        reason="",
        pose=found.pose,
        x=found.x,
        P=found.P,
        unexplained_fraction=share,
        residual=found.residual,
        innovation=found.innovation,
        limb_sigma_deg=OVERCONFIDENCE * sigma,
        limb_lost=failure_probability(signs),
        limb_features=signs,
        correspondences=found.correspondences,
        seconds={"track": seconds, "judge": perf_counter() - begun},
        prior=found.prior,
    )
