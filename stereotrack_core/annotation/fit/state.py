"""The state of the fit: a pose, and the freedom that a real person's landmarks have around it.

The error state begins with the numbers of :mod:`body.manifold`. Three numbers for each landmark
follow: where the landmark is a joint, the joint itself is shifted, in the frame of the part that
it sits on, and with it all parts beyond; another landmark is shifted on its own part. Six numbers
for each limb come last: a small displacement of the measured surface against the limb, a shift
and a rotation vector in the limb's frame. Range errors of stereo and cones that are not quite the
person's shape are alike in neighbouring data and successive frames; a state says so.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stereotrack_core.annotation.landmark_set import Landmark, LandmarkSet
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
from stereotrack_core.body.skeleton import HEAD, PARENTS, PARTS, TORSO
from stereotrack_core.geometry.rotation import rotation_from_vector

ARMS_AND_HEAD = (*THESIS_JOINTS, HEAD)
"""Joints that landmarks can tell; legs are there for depth."""


def is_joint(landmark: Landmark) -> bool:
    """Whether a landmark lies where its part is joined to the next."""
    on_joint = landmark.along == landmark.across == 0.0 and not any(landmark.offset)
    return on_joint and PARTS.index(landmark.part) not in (TORSO, HEAD)


@dataclass(frozen=True, eq=False)
class FitState:
    """A pose and the shifts around it.

    Attributes
    ----------
    pose : Pose
    offsets : (L, 3) float64, metres
    slips : (6, 6) float64
        For each limb metres and radians in its frame; no rows without depth.
    """

    pose: Pose
    offsets: FloatArray
    slips: FloatArray


@dataclass(frozen=True, eq=False)
class Freedom:
    """Which number of the error state moves what.

    Attributes
    ----------
    landmark_set : LandmarkSet
    body : BodyModel
        With the subject's own lengths.
    with_depth : bool
        Whether legs and the slips of the surface are in the state.
    """

    landmark_set: LandmarkSet
    body: BodyModel
    with_depth: bool

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Parts whose joints are in the state."""
        return self.body.joints if self.with_depth else ARMS_AND_HEAD

    @cached_property
    def of_pose(self) -> int:
        """Numbers of the pose, which come first."""
        return 6 + 2 * len(self.joints)

    @cached_property
    def of_offsets(self) -> slice:
        """Columns of the landmarks' shifts."""
        return slice(self.of_pose, self.of_pose + 3 * len(self.landmark_set.landmarks))

    @cached_property
    def of_slips(self) -> slice:
        """Columns of the surface's slips."""
        first = self.of_offsets.stop
        return slice(first, first + (6 * len(LIMBS) if self.with_depth else 0))

    @cached_property
    def columns(self) -> Columns:
        """Columns as residuals of the tracker know them, with room for the rest."""
        return Columns(self.of_slips.stop, columns_of(self.joints).first)

    @cached_property
    def parts(self) -> IntArray:
        """Part (L,) that each landmark is on."""
        return np.array([PARTS.index(one.part) for one in self.landmark_set.landmarks])

    @cached_property
    def shifts_joint(self) -> BoolArray:
        """Whether each landmark (L,) is a joint; of several at one joint the first alone is."""
        found: BoolArray = np.array([is_joint(one) for one in self.landmark_set.landmarks])
        for i in np.flatnonzero(found):
            found[i] = not np.any(found[:i] & (self.parts[:i] == self.parts[i]))
        return found

    @cached_property
    def local(self) -> FloatArray:
        """Where the landmarks (L, 3) are in their parts, without shifts."""
        lengths = self.body.skeleton.lengths[self.parts]
        across = self.body.skeleton.proportions.hip_width
        places = np.array([one.offset for one in self.landmark_set.landmarks])
        places[:, 2] += lengths * [one.along for one in self.landmark_set.landmarks]
        places[:, 0] += across * np.array([one.across for one in self.landmark_set.landmarks])
        return places

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
        slips = len(LIMBS) if self.with_depth else 0
        return FitState(pose, np.zeros((len(self.parts), 3)), np.zeros((slips, 6)))

    def displaced(self, state: FitState, delta: FloatArray) -> FitState:
        """Displace a state by an error state (n,)."""
        pose = orthonormal(displaced(state.pose, delta[: self.of_pose], self.joints))
        return FitState(
            pose,
            state.offsets + delta[self.of_offsets].reshape(-1, 3),
            state.slips + delta[self.of_slips].reshape(-1, 6),
        )

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


def slipped(frames: PartFrames, slips: FloatArray) -> PartFrames:
    """Frames of the parts as the measured surface shows them."""
    rotations, origins = frames.rotations.copy(), frames.origins.copy()
    limbs = len(slips)
    origins[:limbs] += np.einsum("lij,lj->li", rotations[:limbs], slips[:, :3])
    rotations[:limbs] = rotations[:limbs] @ rotation_from_vector(slips[:, 3:])
    return PartFrames(rotations, origins)
