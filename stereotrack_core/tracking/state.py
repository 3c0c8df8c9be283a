"""What a tracker knows: body and parameters for good, pose and covariance for the moment."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.manifold import Columns, columns_of
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import CLAVICLES
from stereotrack_core.depth.points import Volume
from stereotrack_core.filtering.linearisation import inverse
from stereotrack_core.filtering.sigma_points import SigmaWeights, scaled_weights
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.part_colours import PartColours

# Angle of a clavicle from its rest up to which it is held firmly (docs/accuracy.md); beyond, it is
# held less and less, unless it is lowered.
GIRDLE_REST = np.radians(2.5)
_ARM = np.radians(40.0) ** 2
# Variances of joints, and of position and rotation, of a first pose.
_START = np.array([0.1, 0.1, 0.1, *np.radians([20.0, 20.0, 20.0])]) ** 2

_UT_BETA, _UT_KAPPA = 2.0, 0.0  # for a normal distribution, and as the thesis leaves it
_SIGMA_GIRDLE = 3.0  # degrees a shoulder is expected to turn in a frame set at 10 Hz
_STATED_AT = 10.0  # frame sets per second for which the parameters state the standard deviations


@dataclass(frozen=True, eq=False)
class Belief:
    """A pose and how certain it is."""

    pose: Pose
    P: FloatArray  # (n, n), of the states or of the pose's error state; metres, radians

    @cached_property
    def information(self) -> FloatArray:
        """Inverse (n, n) of the covariance, which all iterations of a correction share."""
        return inverse(self.P)

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations (n,), metres and radians."""
        return np.sqrt(np.maximum(np.diagonal(self.P), 0.0))

    @property
    def correlation(self) -> FloatArray:
        """Correlations (n, n), -1 to 1; 0 with a state that has no variance."""
        sigma = self.sigma
        product = np.outer(sigma, sigma)
        known = product > 0.0
        return np.where(known, self.P / np.where(known, product, 1.0), 0.0)


@dataclass(frozen=True, eq=False)
class Particles:
    """Poses of a particle filter after a frame."""

    displacements: FloatArray  # (K, n). From `centre`.
    centre: Pose  # prediction of the frame
    pose: Pose  # estimate of the frame


@dataclass(frozen=True, eq=False)
class State(Belief):
    """A filter between two frames."""

    time: float | None = None  # of the pose; None: the frame before the next cloud's
    is_first: bool = False  # whether no earlier frame predicts the next one
    # (6, 2), of keypoints; see :mod:`tracking.failure.features`.
    disagreement: FloatArray = field(default_factory=lambda: np.zeros((len(LIMBS), 2)))
    colours: PartColours | None = None  # learned colours of the parts; None if the filter uses none
    particles: Particles | None = None  # of the baseline `annealed`


@dataclass(frozen=True, eq=False)
class Setup:
    """What a tracker is made for; it never changes while it tracks."""

    body: BodyModel
    parameters: TrackingParameters
    cameras: FloatArray  # (V, 3), world, metres. Optical centres of the views.
    fps: float  # frame sets per second; the process noise is stated for 10 Hz
    seed: int  # of all that is random
    volume: Volume | None = None  # who is cut by its sides is not tracked; None: unknown
    upright: Upright = Z_UP  # which way is up, for searches; following needs it not

    @property
    def joints(self) -> tuple[int, ...]:
        """Parts whose two numbers follow three of position and three of rotation in the state."""
        thesis = self.parameters.matching == "model_to_data"
        return THESIS_JOINTS if thesis else self.body.joints

    @cached_property
    def columns(self) -> Columns:
        """Columns of the error state."""
        return columns_of(self.joints)

    @cached_property
    def weights(self) -> SigmaWeights:
        """Spread and weights of the error state's sigma points."""
        return scaled_weights(self.columns.n, self.parameters.ut_alpha, _UT_BETA, _UT_KAPPA)

    @cached_property
    def Q(self) -> FloatArray:  # noqa: N802
        """Process noise (n, n) of one frame's time, of a symmetric random walk."""
        p = self.parameters
        turns = [_SIGMA_GIRDLE if j in CLAVICLES else p.sigma_joint for j in self.joints]
        rotations = np.radians([p.sigma_rotation] * 3 + np.repeat(turns, 2).tolist())
        sigma = np.concatenate([np.full(3, p.sigma_position), rotations])
        return np.diag(sigma**2 * _STATED_AT / self.fps)

    def first_state(self, pose: Pose, time: float | None = None) -> State:
        """State of a pose that is roughly right."""
        girdle = GIRDLE_REST**2
        turns = [girdle if joint in CLAVICLES else _ARM for joint in self.joints]
        P = np.diag(np.concatenate([_START, np.repeat(turns, 2)]))
        return State(pose, P, time, is_first=True)

    def predicted(self, belief: Belief, since: float, time: float) -> Belief:
        """Predict that the body stays where it is, less certain with the time."""
        return Belief(belief.pose, belief.P + elapsed(since, time) * self.Q)


def prior_inflation(moved: FloatArray, P: FloatArray, above: float) -> FloatArray:
    """Factors (n,) on standard deviations of a prior (n, n) that allow for a movement (n,).

    Position, rotation and every joint are judged alone by the distance moved over its expected
    value, and widened where that is `above` so much: still limbs are held still, and nothing that
    moves fast is held back.
    """
    squared = moved**2 / np.diagonal(P)
    joints = squared[6:].reshape(-1, 2).mean(axis=1)
    groups = [squared[:3].mean(), squared[3:6].mean(), *joints]
    ratio = np.sqrt(np.repeat(groups, [3, 3] + [2] * len(joints)))
    return np.where(ratio > above, ratio, 1.0)


def elapsed(since: float | None, time: float) -> float:
    """Frames between two times, never negative; `since` None is the frame before `time`."""
    return 1.0 if since is None else abs(time - since)
