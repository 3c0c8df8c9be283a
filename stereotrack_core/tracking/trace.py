"""What one step of a tracker did, as numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.filtering.correction import normalised
from stereotrack_core.geometry.rotation import angle_between, vector_from_rotation
from stereotrack_core.tracking.estimate import Estimate, limb_directions
from stereotrack_core.tracking.state import Belief

HIDDEN, INSIDE, SURPLUS, TOO_FAR, ON_PARTNER = range(5)
REASONS: tuple[str, ...] = (
    "hidden from every camera",
    "inside another cone",
    "not needed, enough points were sampled",
    "too far from the model",
    "coincides with its measured point",
)
"""Why a point was not used; indices are those above."""


@dataclass(frozen=True, eq=False)
class SigmaPoints:
    """Poses that stand for a belief, (2.12) to (2.14).

    Attributes
    ----------
    deviations : (2n + 1, n) float64
        From the mean; the first is zero.
    poses : Pose
        Stacked (2n + 1).
    used : bool
        False where the tracker works with derivatives: the same points are then only an
        illustration of the belief.
    """

    deviations: FloatArray
    poses: Pose
    used: bool


@dataclass(frozen=True, eq=False)
class Points:
    """Pairs of points that a correction used, in the order of their parts; m of them.

    Attributes
    ----------
    part : (m,) int64
        Index into ``PARTS``.
    place : (m, 3) float64, world, metres
        Measured points.
    foot : (m, 3) float64, world, metres
        Their partners on the model.
    direction : (m, 3) float64, world
        Unit vectors along which the pairs are compared.
    residual : (m,) float64, metres
        z - z_hat: how far the measured point is ahead of its partner in that direction.
    sigma : (m,) float64, metres
        Standard deviation that the measurement is taken to have.
    weight : (m,) float64
        1 for full trust, 0 for none.
    """

    part: IntArray
    place: FloatArray
    foot: FloatArray
    direction: FloatArray
    residual: FloatArray
    sigma: FloatArray
    weight: FloatArray


@dataclass(frozen=True, eq=False)
class Unused:
    """Points that were there and not used; k of them.

    Attributes
    ----------
    place : (k, 3) float64, world, metres
    part : (k,) int64
        -1 for measured points, which belong to no part.
    why : (k,) int64
        Index into :data:`REASONS`.
    """

    place: FloatArray
    part: IntArray
    why: IntArray


@dataclass(frozen=True, eq=False)
class Rows:
    """Further rows of a correction, of one kind.

    Attributes
    ----------
    kind : str
        "elbow", "rest", "torso", "arms", "outline" or "detection".
    part : (m,) int64
    residual : (m,) float64
        z - z_hat in the unit.
    sigma : (m,) float64
        In the same unit.
    unit : str
        "m", "rad" or "px".
    dx : (n,) float64
        What they contributed to the correction.
    """

    kind: str
    part: IntArray
    residual: FloatArray
    sigma: FloatArray
    unit: str
    dx: FloatArray


@dataclass(frozen=True, eq=False)
class Correction:
    """One iteration.

    Attributes
    ----------
    stage : str
        "follow", "again" (from a wider prior) or "refine" (a pair of places for the arms).
    iteration : int
        From 1 on, within the stage.
    prior : Belief
        What is corrected.
    before : Belief
        Where the measurement is linearised: for the thesis's tracker the same as the prior.
    sigma_points : SigmaPoints
        Of `before`.
    rows : tuple of Rows
        Beside the points: limits, collisions, arms apart, outlines, detections.
    P_xz : (n, m) float64
        Cross-covariance of states and points, (2.18), (2.11).
    P_zz : (m,) float64, square metres
        Variances of the predicted measurement.
    gain : (n, m) float64
        Columns of the Kalman gain that belong to the points.
    dx : (n,) float64
        The correction, metres and radians.
    from_prior : (n,) float64
        The part of it that draws back to the prior's pose.
    """

    stage: str
    iteration: int
    prior: Belief
    before: Belief
    sigma_points: SigmaPoints
    points: Points
    unused: Unused
    rows: tuple[Rows, ...]
    P_xz: FloatArray
    P_zz: FloatArray
    gain: FloatArray
    dx: FloatArray
    from_prior: FloatArray
    after: Belief

    @property
    def gain_norm(self) -> float:
        """Frobenius norm of the gain's columns that belong to the points."""
        return float(np.linalg.norm(self.gain))

    @property
    def normalised_residual(self) -> float:
        """Root mean square of the points' residuals over their predicted standard deviations.

        That of the first correction is the frame's innovation.
        """
        return normalised(self.points.residual, self.P_zz + self.points.sigma**2)


@dataclass(frozen=True)
class ArmJump:
    """How one arm was moved to avoid collisions.

    Attributes
    ----------
    side : int
        0 for the left arm, 1 for the right one.
    elbow_missing, hand_missing : float, metres
        By which the least distance from the torso was not kept; 0 where it was.
    bend_missing : float, radians
        By which the elbow was folded too far; 0 where it was not.
    upper_turn, fore_turn : float, radians
        By which the limbs were turned in the end.
    """

    side: int
    elbow_missing: float
    hand_missing: float
    bend_missing: float
    upper_turn: float
    fore_turn: float


@dataclass(frozen=True, eq=False)
class Jump:
    """The thesis's collision avoidance after the last iteration (3.2.4).

    Attributes
    ----------
    arms : tuple of ArmJump
        Left and right.
    least_distance : float, metres
    least_angle : float, radians
    """

    before: Pose
    after: Pose
    arms: tuple[ArmJump, ...]
    least_distance: float
    least_angle: float


@dataclass(frozen=True, eq=False)
class Proposals:
    """Places for one arm that were scored; K of them.

    Attributes
    ----------
    side : int
        0 for the left arm, 1 for the right one.
    upper, fore : (K, 3) float64
        Directions in the torso's frame.
    terms : mapping from name to (K,) float64
        What speaks against them: data, sight, anatomy, change.
    kept : (K,) bool
        Whether pairs were made with them.
    """

    side: int
    upper: FloatArray
    fore: FloatArray
    terms: Mapping[str, FloatArray]
    kept: BoolArray

    @property
    def cost(self) -> FloatArray:
        """Sum (K,) of the terms."""
        result: FloatArray = np.sum(list(self.terms.values()), axis=0)
        return result


@dataclass(frozen=True, eq=False)
class Pair:
    """Places for both arms at once that the tracker has tried.

    Attributes
    ----------
    proposed, pose : Pose
        Before and after they were refined.
    terms : mapping from name to float
        What speaks against the refined pose, by name.
    cost : float
        Its sum.
    """

    proposed: Pose
    pose: Pose
    terms: Mapping[str, float]
    cost: float
    chosen: bool


@dataclass(frozen=True, eq=False)
class Search:
    """The search for the arms.

    Attributes
    ----------
    followed : Pair
        What following alone has found; chosen if nothing else was clearly better.
    pairs : tuple of Pair
        In the order in which they were tried.
    proposals : tuple of Proposals
        Left and right.
    gain : float
        By which another pair must cost less.
    """

    followed: Pair
    pairs: tuple[Pair, ...]
    proposals: tuple[Proposals, ...]
    gain: float
    seconds: float


@dataclass(frozen=True, eq=False)
class StepTrace:
    """Everything that a tracker did in one frame.

    Attributes
    ----------
    method : str
        "thesis", "manifold", or the estimator's name for a baseline.
    state_names : tuple of str
        Of the n numbers of covariances and corrections.
    before, predicted, after : Belief
        Of the frame before, predicted for this one, and found.
    corrections : tuple of Correction
        In their order, without those that refine pairs of places for the arms.
    refinements : tuple of tuple of Correction
        Those, pair by pair.
    measured : tuple of Points
        Pairs of points of trackers that do not correct by them; first and last.
    estimate : Estimate
        What the tracker said about the frame.
    notes : tuple of str
        Sentences about what is unusual.
    seconds : mapping from step to seconds
    """

    frame: int
    method: str
    body: BodyModel
    state_names: tuple[str, ...]
    before: Belief
    predicted: Belief
    after: Belief
    corrections: tuple[Correction, ...]
    estimate: Estimate
    refinements: tuple[tuple[Correction, ...], ...] = ()
    measured: tuple[Points, ...] = ()
    search: Search | None = None
    jump: Jump | None = None
    notes: tuple[str, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Movement:
    """From one pose to another.

    Attributes
    ----------
    shift : float, metres
        Of the torso.
    turn : float, radians
        Of the torso.
    limbs : (6,) float64, radians
        Of the limbs' directions, in the order of ``LIMBS``.
    """

    shift: float
    turn: float
    limbs: FloatArray


def movement(body: BodyModel, origin: Pose, to: Pose) -> Movement:
    """How far a pose is from another one."""
    turned = vector_from_rotation(to.torso @ origin.torso.T)
    a, b = limb_directions(body.frames(origin)), limb_directions(body.frames(to))
    shift = float(np.linalg.norm(to.position - origin.position))
    return Movement(shift, float(np.linalg.norm(turned)), angle_between(a, b))
