"""The state of the fit: a pose, and the freedom that a real person's landmarks have around it.

The numbers of :mod:`body.manifold` come first, then three for each landmark: it shifts its joint,
with all parts beyond, or itself on its part. Six for each limb come last: shift and rotation of the
measured surface against it, for errors that neighbouring data share.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.manifold import (
    Columns,
    columns_of,
    difference,
    displaced,
    point_jacobian,
)
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, orthonormal
from stereotrack_core.body.skeleton import HEAD, LEFT_UPPER_ARM, PARENTS, PARTS, TORSO
from stereotrack_core.filtering.smoothing import Walk
from stereotrack_core.geometry.rotation import rotation_from_vector


@dataclass(frozen=True)
class FitSettings:
    """Settings of a fit of the body to clicks."""

    use_depth: bool = True  # use the measured points where the recording has depth
    outlier_share: float = 0.03  # expected share of outliers among the clicks
    sigma_joint_shift: float = 0.006  # metres per axis from a joint's place in the body model


_ARMS_AND_HEAD = (*THESIS_JOINTS, HEAD)  # joints that landmarks can tell; legs are there for depth


@dataclass(frozen=True, eq=False)
class FitState:
    """A pose, shifts of landmarks (L, 3) in metres, biases of surfaces (6, 6) in m, radians."""

    pose: Pose
    offsets: FloatArray
    biases: FloatArray


@dataclass(frozen=True, eq=False)
class Freedom:
    """Layout of the error state; with depth, legs and surface biases are in it."""

    landmark_set: LandmarkSet
    body: BodyModel
    with_depth: bool

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Parts whose joints are in the state."""
        return self.body.joints if self.with_depth else _ARMS_AND_HEAD

    @cached_property
    def of_pose(self) -> int:
        """Numbers of the pose, which come first."""
        return 6 + 2 * len(self.joints)

    @cached_property
    def of_offsets(self) -> slice:
        """Columns of the landmarks' shifts."""
        return slice(self.of_pose, self.of_pose + 3 * len(self.landmark_set.landmarks))

    @cached_property
    def of_biases(self) -> slice:
        """Columns of the surface biases."""
        first = self.of_offsets.stop
        return slice(first, first + (6 * len(LIMBS) if self.with_depth else 0))

    @cached_property
    def columns(self) -> Columns:
        """Columns as residuals of the tracker know them, with room for the rest."""
        return Columns(self.of_biases.stop, columns_of(self.joints).first)

    @cached_property
    def parts(self) -> IntArray:
        """Part (L,) that each landmark is on."""
        return np.array([PARTS.index(one.part) for one in self.landmark_set.landmarks])

    @cached_property
    def shifts_joint(self) -> BoolArray:
        """Whether each landmark (L,) is a joint; of several at one joint the first alone is."""
        joints = {part for part in PARTS if part not in (PARTS[TORSO], PARTS[HEAD])}
        marks = self.landmark_set.landmarks
        shown = (o.part in joints and not any((o.along, o.across, *o.offset)) for o in marks)
        found: BoolArray = np.array(list(shown))
        for i in np.flatnonzero(found):
            found[i] = not np.any(found[:i] & (self.parts[:i] == self.parts[i]))
        return found

    @cached_property
    def local(self) -> FloatArray:
        """Where the landmarks (L, 3) are in their parts, without shifts."""
        return self.landmark_set.in_parts(self.body)

    @cached_property
    def moved_by(self) -> BoolArray:
        """Parts (L, P) that a landmark's shift takes along: those beyond a joint."""
        found: BoolArray = np.zeros((len(self.parts), len(PARTS)), dtype=np.bool_)
        for i in np.flatnonzero(self.shifts_joint):
            for part in range(self.parts[i], len(PARTS)):
                found[i, part] = part == self.parts[i] or found[i, PARENTS[part]]
        return found

    def still(self, pose: Pose) -> FitState:
        """A state at this pose without shifts."""
        biases = len(LIMBS) if self.with_depth else 0
        return FitState(pose, np.zeros((len(self.parts), 3)), np.zeros((biases, 6)))

    def displaced(self, state: FitState, delta: FloatArray) -> FitState:
        """Displace a state by an error state (n,)."""
        pose = orthonormal(displaced(state.pose, delta[: self.of_pose], self.joints))
        offsets = state.offsets + delta[self.of_offsets].reshape(-1, 3)
        biases = state.biases + delta[self.of_biases].reshape(-1, 6)
        return FitState(pose, offsets, biases)

    def pose_difference(self, to: Pose, origin: Pose) -> FloatArray:
        """Error state of the pose alone that displaces `origin` to `to`."""
        return difference(to, origin, self.joints)

    def body_at(self, offsets: FloatArray) -> BodyModel:
        """The body with shifted joints."""
        joints = self.body.skeleton.joints.copy()
        for i in np.flatnonzero(self.shifts_joint):
            joints[self.parts[i]] += offsets[i]
        shifted = dataclasses.replace(self.body.skeleton, joints=joints)
        return dataclasses.replace(self.body, skeleton=shifted)

    def own_place(self, offsets: FloatArray) -> FloatArray:
        """Where the landmarks (L, 3) are in their parts."""
        return self.local + np.where(self.shifts_joint[:, None], 0.0, offsets)

    def places(self, state: FitState) -> FloatArray:
        """Where the landmarks (L, 3) are, world, metres."""
        frames = self.body_at(state.offsets).frames(state.pose)
        return frames.apply(self.parts, self.own_place(state.offsets))

    def jacobian(
        self, points: FloatArray, directions: FloatArray, part: IntArray, frames: PartFrames
    ) -> FloatArray:
        """Derivatives (m, n) of n . p for points that move with their parts and their joints."""
        J = point_jacobian(points, directions, part, frames, self.columns)
        first = self.of_offsets.start
        for i in np.flatnonzero(self.shifts_joint):
            taken = np.flatnonzero(self.moved_by[i, part])
            world_from_parent = frames.rotations[PARENTS[self.parts[i]]]
            J[taken, first + 3 * i : first + 3 * i + 3] = directions[taken] @ world_from_parent
        return J

    def landmark_jacobian(
        self, landmark: IntArray, directions: FloatArray, places: FloatArray, frames: PartFrames
    ) -> FloatArray:
        """Derivatives (m, n) of n . p for landmarks (m,) that are at `places` (L, 3), world."""
        part = self.parts[landmark]
        J = self.jacobian(places[landmark], directions, part, frames)
        own = ~self.shifts_joint[landmark]
        in_part = np.einsum("mi,mij->mj", directions, frames.rotations[part])
        first = self.of_offsets.start + 3 * landmark
        for row in np.flatnonzero(own):
            J[row, first[row] : first[row] + 3] = in_part[row]
        return J

    def place_jacobian(self, state: FitState) -> FloatArray:
        """Derivatives (L, 3, n) of the landmarks, world."""
        frames = self.body_at(state.offsets).frames(state.pose)
        places = frames.apply(self.parts, self.own_place(state.offsets))
        count = len(self.parts)
        landmark = np.repeat(np.arange(count), 3)
        J = self.landmark_jacobian(landmark, np.tile(np.eye(3), (count, 1)), places, frames)
        return J.reshape(count, 3, -1)


def biased(frames: PartFrames, biases: FloatArray) -> PartFrames:
    """Frames of the parts as the measured surface shows them."""
    rotations, origins = frames.rotations.copy(), frames.origins.copy()
    limbs = len(biases)
    origins[:limbs] += np.einsum("lij,lj->li", rotations[:limbs], biases[:, :3])
    rotations[:limbs] = rotations[:limbs] @ rotation_from_vector(biases[:, 3:])
    return PartFrames(rotations, origins)


_SPEEDS = (0.25, 120.0, 100.0)  # usual ones: m/s; degrees a second of torso, of a joint
_SHIFTS_LAST, _SPEEDS_LAST = 2.0, 0.3  # seconds over which landmarks' shifts, and speeds, correlate
_SURFACE_LASTS, _TRUNK_LASTS = 3.0, 20.0  # seconds over which surface biases correlate
_TAIL = 1.5  # degrees of freedom of the movement's t-distribution: few, for stillness and jerks
_UNEVEN = 0.3  # part of the usual speed by which a step differs from what the speed says
_SLOWEST = 0.02  # least factor on the movement's variances


class Movement:
    """The state with its speeds from frame to frame.

    The numbers are those of the error state, then the speeds of the pose's numbers per frame:
    x_k+1 = x_k + v_k, v_k+1 = rho v_k, and shifts and biases fade towards nothing.
    """

    def __init__(self, freedom: Freedom, settings: FitSettings, fps: float) -> None:
        self.freedom = freedom
        n, of_pose = freedom.columns.n, freedom.of_pose
        self.size = n + of_pose
        kept = np.ones(self.size)
        kept[freedom.of_offsets] = _kept(fps, _SHIFTS_LAST)
        kept[freedom.of_biases] = _kept(fps, _SURFACE_LASTS)
        kept[freedom.of_biases][:6] = _kept(fps, _TRUNK_LASTS)
        kept[n:] = _kept(fps, _SPEEDS_LAST)
        self.F = np.diag(kept)
        self.F[np.arange(of_pose), n + np.arange(of_pose)] = 1.0
        speed = pose_sigmas(freedom, *_SPEEDS)
        shifts = shift_sigmas(freedom, settings)
        self.sigma = np.concatenate([np.full(of_pose, np.nan), shifts, speed / fps])
        self.noise = self.sigma**2 * (1.0 - kept**2)
        self.noise[:of_pose] = (_UNEVEN * speed / fps) ** 2

    def walk(
        self,
        states: Sequence[FitState],
        speeds: FloatArray,
        factors: FloatArray,
        usual: Pose,
        pose_sigma: FloatArray,
    ) -> Walk:
        """The walk in error states around a trajectory of K frames.

        `speeds` (K, of_pose) are per frame, `factors` (K - 1, of_pose) on the movement's variances;
        of the first frame `usual` is expected, with `pose_sigma` (of_pose,).
        """
        f = self.freedom
        nothing = np.zeros(f.of_pose)
        pairs = zip(states, speeds, strict=True)
        rows = ([nothing, s.offsets.ravel(), s.biases.ravel(), speed] for s, speed in pairs)
        at = np.array([np.concatenate(row) for row in rows])
        kept = np.diagonal(self.F)
        c = at[:-1] * kept - at[1:]
        for k, (one, other) in enumerate(pairwise(states)):
            c[k, : f.of_pose] = f.pose_difference(one.pose, other.pose) + speeds[k]
        Q = np.tile(self.noise, (len(c), 1))
        Q[:, : f.of_pose] *= factors
        Q[:, f.columns.n :] *= factors
        mean = -at[0]
        mean[: f.of_pose] = f.pose_difference(usual, states[0].pose)
        sigma = self.sigma.copy()
        sigma[: f.of_pose] = pose_sigma
        return Walk(self.F, c, Q, mean, np.diag(sigma**2))

    def factors(self, noise: FloatArray) -> FloatArray:
        """Factors (K - 1, of_pose) on the variances that make the movements usual ones.

        Expected variance under Student's distribution; position, rotation and each joint alone.
        `noise` (K - 1, N): expected squares of what was left of the movement.
        """
        n, of_pose = self.freedom.columns.n, self.freedom.of_pose
        relative = noise / self.noise
        squared = 0.5 * (relative[:, :of_pose] + relative[:, n:])
        factors = np.empty_like(squared)
        starts = [0, 3, *range(6, of_pose, 2)]
        for first, end in zip(starts, [*starts[1:], of_pose], strict=True):
            own = 2 * (end - first)
            total = squared[:, first:end].sum(axis=1) * 2
            factors[:, first:end] = ((_TAIL + total) / (_TAIL + own))[:, None]
        return np.maximum(factors, _SLOWEST)


def pose_sigmas(
    freedom: Freedom, position: float, rotation_deg: float, joint_deg: float
) -> FloatArray:
    """One number (of_pose,) for each of the pose's: metres, and degrees turned to radians."""
    sigma = np.full(freedom.of_pose, np.radians(joint_deg))
    sigma[:3], sigma[3:6] = position, np.radians(rotation_deg)
    return sigma


_LANDMARK_SHIFT, _HEAD_SHIFT = 0.006, 0.02  # m; landmarks that are no joints, and the head's
_SURFACE_SHIFT, _SURFACE_TURN = 0.012, np.radians(4.0)  # of a limb's measured surface; metres
_TRUNK_SHIFT = 0.025  # metres; of the trunk's
# Metres along upper arms and forearms. Halos and missing hands move the ends of a measured arm by
# centimetres, differently wherever it points. With 12 mm, what clicks say of a T pose pushed
# hanging arms up by 45 mm, and 20 mm were stated; with 60 mm depth says too little of arms.
_ARM_SLIDE = 0.03


def shift_sigmas(freedom: Freedom, settings: FitSettings) -> FloatArray:
    """Usual sizes of landmarks' shifts and of surface biases."""
    shifts = np.where(freedom.shifts_joint, settings.sigma_joint_shift, _LANDMARK_SHIFT)
    shifts[freedom.parts == HEAD] = _HEAD_SHIFT
    limbs = len(LIMBS) if freedom.with_depth else 0
    biases = np.tile(np.repeat([_SURFACE_SHIFT, _SURFACE_TURN], 3), (limbs, 1))
    biases[: TORSO + 1, :3] = _TRUNK_SHIFT
    biases[LEFT_UPPER_ARM:, 2] = _ARM_SLIDE
    return np.concatenate([np.repeat(shifts, 3), biases.ravel()])


def _kept(fps: float, seconds: float) -> float:
    return float(np.exp(-1.0 / (fps * seconds)))
