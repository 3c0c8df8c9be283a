"""What a tracker says about one frame."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.sampling import SurfacePoints

# Factors of torso, upper arms and forearms; see :func:`overconfidence`.
_OVERCONFIDENCE: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {"one": (4.0, 3.2, 3.2), "two": (2.4, 2.45, 2.25), "several": (2.8, 2.25, 2.0)}
)


def views_named(count: int) -> str:
    """``one``, ``two`` or ``several``: what is fitted for numbers of views is found by it."""
    return ("one", "two", "several")[min(max(count, 1), 3) - 1]


def overconfidence(views: int) -> FloatArray:
    """Factors (6,) from the limbs' standard deviations by the covariance to stated ones.

    Errors of shape and stereo are alike in successive frames and neighbouring data, which no filter
    of single frames knows of. Those of two and of several `views` were fitted on simulated
    recordings. One view keeps wider ones: simulated people in a single depth image would have 1.4
    to 2, real ones 2 to 3 (docs/failures.md).
    """
    torso, upper_arm, forearm = _OVERCONFIDENCE[views_named(views)]
    return np.array([torso, upper_arm, upper_arm, upper_arm, forearm, forearm])


@dataclass(frozen=True, eq=False)
class Correspondences:
    """Pairs of m measured and model points that a correction used, in the order of their parts."""

    part: IntArray  # (m,). Index into ``PARTS``, whose first six are ``LIMBS``.
    data: FloatArray  # (m, 3), world, metres. Measured points.
    model: FloatArray  # (m, 3), world, metres. Their partners on the model.
    direction: FloatArray  # (m, 3), world. Unit vectors along which the pairs are compared.
    residual: FloatArray  # (m,), metres. z - z_hat, of the measured points
    sigma: FloatArray  # (m,), metres. Standard deviation that the measurement is taken to have.
    weight: FloatArray  # (m,). 1 for full trust, 0 for none


@dataclass(frozen=True, eq=False)
class Projection:
    """Pairs of points, each projected on the line that joins them, (3.5) to (3.8)."""

    drawn: SurfacePoints
    sampled: SurfacePoints  # model points: all, and those apart from their partners
    predicted: FloatArray  # (m, 3), world. The model points at x_hat: p_zhat.
    measured: FloatArray  # (m, 3), world. Their nearest measured points: p_z.
    # (m, 3). Unit vectors from p_zhat to p_z, evaluated once at x_hat. With directions recomputed
    # for every sigma point the tracker is destroyed.
    e: FloatArray

    @property
    def z(self) -> FloatArray:
        """The measurement vector (m,): (3.6) and (3.8)."""
        return np.asarray(np.einsum("mi,mi->m", self.e, self.measured))

    def z_hat(self, frames: PartFrames) -> FloatArray:
        """Predicted measurements (S, m) of stacked poses: (3.5), (3.7) and (3.11)."""
        rotations = frames.rotations[:, self.sampled.part]
        points = np.einsum("smij,mj->smi", rotations, self.sampled.points)
        points += frames.origins[:, self.sampled.part]
        return np.asarray(np.einsum("mi,smi->sm", self.e, points))


@dataclass(frozen=True, eq=False)
class Prior:
    """What a frame's correction began from, seen from the frame before."""

    P: FloatArray  # (n, n). Covariance that was really used, as far as it was widened.
    carried: BoolArray  # (n,). False for numbers that were looked for anew, as by the search


@dataclass(frozen=True, eq=False)
class Estimate:
    """Pose of one frame and how far it can be trusted."""

    tracked: bool
    reason: str  # why the frame is not tracked; empty when it is
    pose: Pose  # where not tracked: what the tracker would start from
    x: FloatArray  # (n,). State as named by the tracker's ``state_names``.
    P: FloatArray  # (n, n)
    unexplained_fraction: float = float("nan")  # mean of d^2 / (d^2 + 50 mm^2); 0 is best
    residual: float = float("nan")  # metres, weighted root mean square of distances in the end
    # Normalised: root mean square of z - z_hat over sqrt(H P H' + R), over the points of the
    # frame's first correction. 1 is as expected, more a surprise.
    innovation: float = float("nan")
    # (6,), RMS angle of each limb's direction: by the covariance times :func:`overconfidence`.
    limb_sigma_deg: FloatArray = field(default_factory=lambda: np.full(len(LIMBS), np.nan))
    correspondences: Correspondences | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)  # by stage name
    doubts: Mapping[str, str] = field(default_factory=dict)  # by view, why it was left out
    prior: Prior | None = None  # None if the frame was not predicted from the one before
    # (6,). Probability that the limb is more than 45 deg off; NaN where not known.
    limb_lost: FloatArray = field(default_factory=lambda: np.full(len(LIMBS), np.nan))
    limb_features: FloatArray | None = None  # (6, S), in the order of ``FEATURES``


def limb_directions(frames: PartFrames) -> FloatArray:
    """Unit vectors (..., 6, 3), world, of the limbs' z axes."""
    return frames.rotations[..., : len(LIMBS), :, 2]


def limb_sigma_deg(frames: PartFrames, weights: FloatArray) -> FloatArray:
    """RMS angle (6,), degrees, of the limbs' directions in sigma points with weights (2n + 1,)."""
    directions = limb_directions(frames)
    deviations = directions[1:] - directions[:1]
    variance = np.einsum("s,slk,slk->l", weights[1:], deviations, deviations)
    return np.asarray(np.degrees(np.sqrt(np.maximum(variance, 0.0))))
