"""What a tracker says about one frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import PartFrames, Pose

_OVERCONFIDENCE: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {"one": (4.0, 3.2, 3.2), "two": (2.4, 2.45, 2.25), "several": (2.8, 2.25, 2.0)}
)
"""Factors of torso, upper arms and forearms; see :func:`overconfidence`."""


def views_named(count: int) -> str:
    """``one``, ``two`` or ``several``: what is fitted for numbers of views is found by it."""
    return ("one", "two", "several")[min(max(count, 1), 3) - 1]


def overconfidence(views: int) -> FloatArray:
    """Factors (6,) from the limbs' standard deviations by the covariance to stated ones.

    Errors of the body's shape and of the stereo are alike in successive frames and neighbouring
    data, which no filter of single frames knows of. Those of two and of several views were fitted
    on simulated recordings. One view keeps wider ones: simulated people in a single depth image
    would have 1.4 to 2, real ones 2 to 3 (docs/failures.md).

    Parameters
    ----------
    views : int
        Views that are tracked with.
    """
    torso, upper_arm, forearm = _OVERCONFIDENCE[views_named(views)]
    return np.array([torso, upper_arm, upper_arm, upper_arm, forearm, forearm])


@dataclass(frozen=True, eq=False)
class Correspondences:
    """Pairs of m measured and model points that a correction used, in the order of their parts."""

    part: IntArray
    """(m,). Index into ``PARTS``, whose first six are ``LIMBS``."""
    data: FloatArray
    """(m, 3), world, metres. Measured points."""
    model: FloatArray
    """(m, 3), world, metres. Their partners on the model."""
    direction: FloatArray
    """(m, 3), world. Unit vectors along which the pairs are compared."""
    residual: FloatArray
    """(m,), metres. z - z_hat: how far the measured point is ahead of its partner in that
    direction."""
    sigma: FloatArray
    """(m,), metres. Standard deviation that the measurement is taken to have."""
    weight: FloatArray
    """(m,). 1 for full trust, 0 for none."""


@dataclass(frozen=True, eq=False)
class Prior:
    """What a frame's correction began from, seen from the frame before."""

    P: FloatArray
    """(n, n). Covariance that was really used, as far as it was widened."""
    carried: BoolArray
    """(n,). False for numbers that were not predicted but looked for anew, as those of arms that
    the search has put elsewhere."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Pose of one frame and how far it can be trusted."""

    tracked: bool
    reason: str
    """Why the frame is not tracked; empty when it is."""
    pose: Pose
    """Where not tracked: what the tracker would start from."""
    x: FloatArray
    """(n,). State as named by the tracker's ``state_names``."""
    P: FloatArray
    """(n, n)."""
    unexplained_fraction: float = float("nan")
    """Mean of d^2 / (d^2 + 50 mm^2) over the data: 0 is best (docs/method.md 4.6)."""
    residual: float = float("nan")
    """Metres. Weighted root mean square distance after the last correction."""
    innovation: float = float("nan")
    """Normalised: root mean square of z - z_hat, over the points of the frame's first correction,
    each over its predicted standard deviation sqrt(H P H' + R). 1 is as expected, more a
    surprise."""
    limb_sigma_deg: FloatArray = field(default_factory=lambda: np.full(len(LIMBS), np.nan))
    """(6,). Root mean square angle of each limb's direction, in the order of ``LIMBS``; that of the
    covariance times :func:`overconfidence`."""
    correspondences: Correspondences | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)
    """By stage name."""
    doubts: Mapping[str, str] = field(default_factory=dict)
    """By view name. Why a view that measured was left out, as a sentence."""
    prior: Prior | None = None
    """None where the frame was not predicted from the one before."""
    limb_lost: FloatArray = field(default_factory=lambda: np.full(len(LIMBS), np.nan))
    """(6,). Probability that the limb is lost, more than 45 deg off; NaN where that is not
    known."""
    limb_features: FloatArray | None = None
    """(6, S). What that was said by, in the order of ``FEATURES``; see
    :mod:`tracking.failure.features`."""


def limb_directions(frames: PartFrames) -> FloatArray:
    """Unit vectors (..., 6, 3), world, of the limbs' z axes."""
    return frames.rotations[..., : len(LIMBS), :, 2]


def limb_sigma_deg(frames: PartFrames, weights: FloatArray) -> FloatArray:
    """Root mean square angle (6,) of the limbs' directions in degrees.

    Parameters
    ----------
    frames : PartFrames
        Of the sigma points of a posterior, the middle one first.
    weights : (2n + 1,) float64
        Covariance weights of the sigma points.
    """
    directions = limb_directions(frames)
    deviations = directions[1:] - directions[:1]
    variance = np.einsum("s,slk,slk->l", weights[1:], deviations, deviations)
    result: FloatArray = np.degrees(np.sqrt(np.maximum(variance, 0.0)))
    return result
