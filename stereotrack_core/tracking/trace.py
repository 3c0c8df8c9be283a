"""What one step of a tracker did, as numbers."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.filtering.correction import normalised
from stereotrack_core.geometry.rotation import angle_between, vector_from_rotation
from stereotrack_core.tracking.estimate import Correspondences, Estimate, limb_directions
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.thesis_collisions import Jump

HIDDEN, INSIDE, SURPLUS, TOO_FAR, ON_PARTNER = range(5)
# Why a point was not used; indices are those above.
REASONS: tuple[str, ...] = (
    "hidden from every camera",
    "inside another cone",
    "not needed, enough points were sampled",
    "too far from the model",
    "coincides with its measured point",
)


@dataclass(frozen=True, eq=False)
class SigmaPoints:
    """Poses that stand for a belief, (2.12) to (2.14); else an illustration of it."""

    deviations: FloatArray  # (2n + 1, n). From the mean; the first is zero.
    poses: Pose  # stacked (2n + 1)


@dataclass(frozen=True, eq=False)
class Unused:
    """Points that were there and not used; k of them."""

    place: FloatArray  # (k, 3), world, metres
    part: IntArray  # (k,). -1 for measured points, which belong to no part
    why: IntArray  # (k,). Index into :data:`REASONS`.


@dataclass(frozen=True, eq=False)
class Rows:
    """Further rows of a correction, of one kind."""

    kind: str  # one of "elbow", "rest", "torso", "arms", "outline" or "detection"
    part: IntArray  # (m,)
    residual: FloatArray  # (m,). z - z_hat in the unit
    sigma: FloatArray  # (m,). In the same unit.
    unit: str  # one of "m", "rad" or "px"
    dx: FloatArray  # (n,). What they contributed to the correction.


@dataclass(frozen=True, eq=False)
class Correction:
    """One iteration."""

    stage: str  # one of "follow" and "again" (from a wider prior)
    iteration: int  # from 1 on, within the stage
    prior: Belief  # what is corrected
    before: Belief  # where it is linearised; the thesis: at the prior
    sigma_points: SigmaPoints  # of `before`
    points: Correspondences
    unused: Unused
    rows: tuple[Rows, ...]  # limits, collisions, arms apart, outlines, detections
    P_xz: FloatArray  # (n, m). Cross-covariance of states and points, (2.18), (2.11).
    P_zz: FloatArray  # (m,), square metres. Variances of the predicted measurement.
    gain: FloatArray  # (n, m). Columns of the Kalman gain that belong to the points.
    dx: FloatArray  # (n,). The correction, metres and radians.
    from_prior: FloatArray  # (n,). The part of it that draws back to the prior's pose.
    after: Belief

    @property
    def gain_norm(self) -> float:
        """Frobenius norm of the gain's columns that belong to the points."""
        return float(np.linalg.norm(self.gain))

    @property
    def normalised_residual(self) -> float:
        """RMS of residuals over predicted sigmas; at first the innovation."""
        return normalised(self.points.residual, self.P_zz + self.points.sigma**2)


@dataclass(frozen=True, eq=False)
class Proposals:
    """Places for one arm that were scored; K of them."""

    side: int  # 0 for the left arm, 1 for the right one
    upper: FloatArray
    fore: FloatArray  # `upper` and `fore`: (K, 3). Directions in the torso's frame.
    terms: Mapping[str, FloatArray]  # costs by name: data, sight, anatomy, change
    kept: BoolArray  # (K,). Whether pairs were made with them.

    @property
    def cost(self) -> FloatArray:
        """Sum (K,) of the terms."""
        return np.asarray(np.sum(list(self.terms.values()), axis=0))


@dataclass(frozen=True, eq=False)
class Pair:
    """Places for both arms at once that the tracker has tried."""

    proposed: Pose
    pose: Pose  # `proposed` and `pose`: before and after they were refined
    terms: Mapping[str, float]  # By name. What speaks against the refined pose, by name.
    cost: float  # its sum
    chosen: bool


@dataclass(frozen=True, eq=False)
class TrueArms:
    """Cost of the true arms in the search, on the body that following has found."""

    given: Pair  # as a reference or clicks have them
    refined: Pair  # after the correction that every pair of the search gets
    upper: FloatArray
    fore: FloatArray  # `upper` and `fore`: (2, 3). Directions as given, in the torso's frame.
    off: FloatArray  # (4,), radians. Of the chosen arms from the true ones, as LIMBS[2:]
    points: IntArray  # (4,). Points that were measured on each true limb, of `measured`.
    measured: int  # points within reach of the shoulders


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the arms."""

    followed: Pair  # what following alone has found; chosen if nothing else was clearly better
    pairs: tuple[Pair, ...]  # in the order in which they were tried
    proposals: tuple[Proposals, ...]  # left and right
    gain: float  # by which another pair must cost less
    seconds: float
    truth: TrueArms | None = None  # known to the record alone, never to the tracker


@dataclass(frozen=True, eq=False)
class StepTrace:
    """Everything that a tracker did in one frame."""

    frame: int
    method: str  # one of "thesis", "manifold", or the estimator's name for a baseline
    body: BodyModel
    state_names: tuple[str, ...]  # of the n numbers of covariances and corrections
    before: Belief
    predicted: Belief
    after: Belief  # of the frame before, predicted for this one, and found
    corrections: tuple[Correction, ...]  # without refinements of arm proposals
    estimate: Estimate  # what the tracker said about the frame
    measured: tuple[Correspondences, ...] = ()  # of trackers without corrections
    search: Search | None = None
    jump: Jump | None = None
    notes: tuple[str, ...] = ()  # sentences about what is unusual
    seconds: Mapping[str, float] = field(default_factory=dict)  # by step


@dataclass(frozen=True, eq=False)
class Movement:
    """From one pose to another."""

    shift: float  # Metres. Of the torso.
    turn: float  # Radians. Of the torso.
    limbs: FloatArray  # (6,), radians. Of the limbs' directions, in the order of ``LIMBS``.


def movement(body: BodyModel, origin: Pose, to: Pose) -> Movement:
    """How far a pose is from another one."""
    turned = vector_from_rotation(to.torso @ origin.torso.T)
    a, b = limb_directions(body.frames(origin)), limb_directions(body.frames(to))
    shift = float(np.linalg.norm(to.position - origin.position))
    return Movement(shift, float(np.linalg.norm(turned)), angle_between(a, b))
