"""Keypoints of 2-D detectors as measurements: the body's points in the pictures of cameras.

Gross errors are told by the other cameras where enough of them agree, and elsewhere by the pose:
weights fall with the distance as those of the cloud's data do. Whether a detector takes left for
right is told in each picture, by which of both fits the pose. One camera alone says nothing against
the heading while it is followed; where that is in question, its sides stand.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.manifold import PIXEL, Rows, rows_of
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.sighted_keypoints import MeetingPoints, SightedKeypoints

_FLOOR = 2.0  # Pixels. No detector is more exact.
_LEAST_SURE = 0.2  # standard deviations are divided by the confidence, at least this
MEETING_GATE = 0.15  # metres by which a ray may miss the point in which others meet
_SCALE, _SETTLED_SCALE = 0.25, 0.4  # metres at which keypoints, and agreed ones, weigh a quarter
_SIDE_SCALE = 0.25  # metres beyond which a keypoint says no more about sides
_SIDE_MARGIN = 0.2  # cost for each keypoint by which the other way round must fit better
_ARM_NAMES = ("elbow", "wrist", "hand")  # whose sides are exchanged while the trunk's are right


@dataclass(frozen=True, eq=False)
class PlacedKeypoints:
    """Points of the body that K keypoints measure; rows of keypoints that measure none are gone."""

    seen: SightedKeypoints
    part: IntArray  # (K,)
    point: FloatArray  # (K, 3), metres. In the frames of the parts.
    slack: FloatArray  # (K,), metres
    arm: BoolArray  # (K,). Whether it is a point of an arm beyond the shoulder.
    meetings: dict[bytes, MeetingPoints] = field(default_factory=dict)  # by exchanged sides


@dataclass(frozen=True, eq=False)
class KeypointObservation:
    """Keypoints of one instant; which of them count is told anew at every pose."""

    seen: SightedKeypoints | None
    sigma: float  # Metres. Standard deviation of a sure keypoint, at the distance of the person.

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[ReprojectionResidual, ...]:
        """What all cameras say about a pose."""
        fit = self.fitted(body, pose, follows=True)
        return () if fit is None else fit.residuals()

    def fitted(self, body: BodyModel, pose: Pose, *, follows: bool = False) -> KeypointFit | None:
        """Sides and weights at a pose; if it `follows`, one view may have exchanged sides."""
        if self.seen is None or not self.seen.count:
            return None
        if body not in self.seen.placed:
            self.seen.placed[body] = _placed(self.seen, body)
        placed: PlacedKeypoints | None = self.seen.placed[body]
        if placed is None:
            return None
        world = body.frames(pose).apply(placed.part, placed.point)
        turned = np.einsum("vij,kj->kvi", placed.seen.rotation, world)
        in_camera = np.asarray(turned + placed.seen.translation)  # (K, V, 3), metres
        predicted = pinhole(in_camera, placed.seen.focal)
        metre = placed.seen.focal / np.maximum(in_camera[..., 2], 0.1)
        exchanged = _exchanged_sides(placed, predicted, metre, follows=follows)
        seen = placed.seen.with_sides_exchanged(exchanged)
        key = exchanged.tobytes()
        if key not in placed.meetings:
            placed.meetings[key] = seen.meeting(MEETING_GATE)
        return KeypointFit(placed, seen, predicted, metre, placed.meetings[key], self.sigma)


@dataclass(frozen=True, eq=False)
class KeypointFit:
    """How the keypoints of one instant fit a pose."""

    placed: PlacedKeypoints
    seen: SightedKeypoints  # with sides as they fit the pose
    predicted: FloatArray  # (K, V, 2), pixels
    metre: FloatArray  # (K, V). Pixels of a metre at the distance of each point.
    meeting: MeetingPoints
    sigma: float

    @property
    def independence(self) -> float:
        """From 1/3 to 1, how much it says of the heading: three views are seldom wrong together."""
        return min(int(np.count_nonzero(self.seen.confidence.any(axis=0))), 3) / 3.0

    @cached_property
    def off(self) -> FloatArray:
        """Distances (K, V) of keypoints from the pose, metres at the point; NaN where unknown."""
        pixels = np.linalg.norm(self.seen.pixel - self.predicted, axis=2)
        return np.asarray(pixels / self.metre)

    @cached_property
    def sure(self) -> FloatArray:
        """Confidences (K, V); 0 of arms that may be crossed, unless enough cameras agree."""
        crossed = self.placed.arm & ~self.meeting.settled & self.seen.crossed
        return np.where(crossed[:, None], 0.0, self.seen.confidence)

    @cached_property
    def weight(self) -> FloatArray:
        """From 0 to 1 (K, V): w = (g^2 / (g^2 + e^2))^2, 0 where other cameras contradict."""
        settled = self.meeting.settled[:, None]
        squared = np.where(settled, _SETTLED_SCALE, _SCALE) ** 2
        weight = (squared / (squared + self.off**2)) ** 2
        used = (self.sure > 0.0) & (self.meeting.agreed | ~settled)
        return np.nan_to_num(np.where(used, weight, 0.0))

    def cost(self) -> float:
        """What speaks against the pose, 0 to 1: mean e^2 / (g^2 + e^2), by confidence."""
        known = np.isfinite(self.off) & ~(self.meeting.settled[:, None] & ~self.meeting.agreed)
        if not known.any():
            return 1.0
        squared = self.off[known] ** 2
        sure = self.seen.confidence[known]
        return float(np.average(squared / (squared + _SCALE**2), weights=sure))

    @cached_property
    def counted(self) -> tuple[IntArray, IntArray]:
        """Keypoint and camera (m,) of everything that has weight."""
        k, v = np.nonzero(self.weight > 1e-3)
        return k, v

    def residuals(self) -> tuple[ReprojectionResidual, ...]:
        """Rows of everything that has weight."""
        weight, seen, placed = self.weight, self.seen, self.placed
        k, v = self.counted
        if not len(k):
            return ()
        sure = np.clip(seen.confidence[k, v], _LEAST_SURE, 1.0)
        own = (self.sigma**2 / sure**2 + placed.slack[k] ** 2) * self.metre[k, v] ** 2
        variance = (own + _FLOOR**2) / weight[k, v]
        residual = ReprojectionResidual(
            part=placed.part[k],
            point=placed.point[k],
            rotation=seen.rotation[v],
            translation=seen.translation[v],
            focal=seen.focal[v],
            measured=seen.pixel[k, v].reshape(-1),
            variance=np.repeat(variance, 2),
        )
        return (residual,)


def _placed(seen: SightedKeypoints, body: BodyModel) -> PlacedKeypoints | None:
    """What the keypoints measure; None where they measure nothing of this body."""
    places = keypoint_places(body)
    kept = np.array([name in places for name in seen.names], dtype=np.bool_)
    if not kept.any():
        return None
    seen = seen.part(kept)
    own = [places[name] for name in seen.names]
    return PlacedKeypoints(
        seen,
        np.array([place.part for place in own], dtype=np.int64),
        np.array([place.point for place in own]),
        np.array([place.slack for place in own]),
        np.array([name.split("_")[-1] in _ARM_NAMES for name in seen.names], dtype=np.bool_),
    )


def _exchanged_sides(
    placed: PlacedKeypoints, predicted: FloatArray, metre: FloatArray, *, follows: bool
) -> BoolArray:
    """Where (K, V) left and right are exchanged: of all keypoints in a picture, or of the arms.

    Where most cameras say so, the pose is the other way round. With one camera the trunk tells it,
    which cannot have turned round since the frame before.
    """
    seen = placed.seen
    there: BoolArray = np.asarray(np.isfinite(seen.pixel).all(axis=2))
    two_sided: BoolArray = np.asarray(seen.other_side != np.arange(len(seen.names)))
    pairs = two_sided[:, None] & (there | there[seen.other_side])
    result = np.zeros(pairs.shape, dtype=np.bool_)
    alone = follows and np.count_nonzero(pairs.any(axis=0)) == 1
    trunk = ~placed.arm[:, None]
    for group in (np.ones(len(seen.names), dtype=np.bool_), placed.arm):
        asked = pairs & group[:, None]
        judged = asked & trunk if alone else asked
        pixel = np.where(result[..., None], seen.pixel[seen.other_side], seen.pixel)
        other = np.where(result[..., None], seen.pixel, seen.pixel[seen.other_side])
        gain = _side_cost(pixel - predicted, metre) - _side_cost(other - predicted, metre)
        gain, count = np.where(judged, gain, 0.0).sum(axis=0), judged.sum(axis=0)
        better = gain > _SIDE_MARGIN * np.maximum(count, 1)
        if alone or 2 * np.count_nonzero(better) <= np.count_nonzero(count):
            result ^= asked & better
    return result


def _side_cost(off: FloatArray, metre: FloatArray) -> FloatArray:
    """From 0 to 1 (K, V); 1 where nothing is predicted."""
    distance = np.nan_to_num(np.linalg.norm(off, axis=2) / metre, nan=np.inf)
    return np.asarray(np.minimum(distance / _SIDE_SCALE, 1.0) ** 2)


_NEAREST = 0.05  # metres in front of a camera within which nothing is projected


def undistorted(camera: Camera, pixels: FloatArray) -> FloatArray:
    """Pixels (..., 2) of the ideal camera, from the principal point, of raw pixels (..., 2)."""
    return float(camera.matrix[0, 0]) * camera.normalised(pixels)


def pinhole(in_camera: FloatArray, focal: FloatArray | float) -> FloatArray:
    """Pixels (..., 2) of points (..., 3) in the camera's frame; NaN behind the camera."""
    depth = np.where(in_camera[..., 2:] > _NEAREST, in_camera[..., 2:], np.nan)
    return np.asarray(focal)[..., None] * in_camera[..., :2] / depth


def pixel_gradients(
    rotation: FloatArray, in_camera: FloatArray, focal: FloatArray | float
) -> FloatArray:
    """Derivatives (..., 2, 3) of pixels by world points; `rotation`: camera_from_world."""
    z = in_camera[..., 2:]
    slope = in_camera[..., :2] / z
    rows = rotation[..., :2, :] - slope[..., None] * rotation[..., 2:, :]
    result: FloatArray = (np.asarray(focal)[..., None] / z)[..., None] * rows
    return result


@dataclass(frozen=True, eq=False)
class ReprojectionResidual:
    """Measured pixels of m points of the body, each in the picture of a camera."""

    part: IntArray  # (m,)
    point: FloatArray  # (m, 3). In the frames of the parts.
    rotation: FloatArray  # (m, 3, 3). camera_from_world
    translation: FloatArray  # (m, 3), metres. camera_from_world
    focal: FloatArray  # (m,), pixels
    measured: FloatArray  # (2 m,), pixels, column and row of one point after the other
    variance: FloatArray  # (2 m,), square pixels

    def in_camera(self, frames: PartFrames) -> FloatArray:
        """The points (..., m, 3) in the frames of their cameras, for one pose or stacked ones."""
        world = frames.apply(self.part, self.point)
        return np.asarray(np.einsum("mij,...mj->...mi", self.rotation, world) + self.translation)

    def predicted(self, frames: PartFrames) -> FloatArray:
        """The points' pixels (S, 2 m) for stacked poses."""
        pixels = pinhole(self.in_camera(frames), self.focal)
        return pixels.reshape(len(pixels), -1)

    def rows(self, frames: PartFrames) -> Rows:
        """Columns and rows of the pixels in turn, linearised at one pose."""
        at = self.in_camera(frames)
        off = self.measured - pinhole(at, self.focal).reshape(-1), self.variance
        along = pixel_gradients(self.rotation, at, self.focal).reshape(-1, 3)
        world = np.repeat(frames.apply(self.part, self.point), 2, axis=0)
        return rows_of(PIXEL, np.repeat(self.part, 2), world, along, off)
