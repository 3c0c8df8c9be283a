"""Keypoints of 2-D detectors as measurements: the body's points in the pictures of cameras.

Gross errors are told by the other cameras where enough of them agree, and elsewhere by the pose:
weights fall with the distance as those of the cloud's data do. A detector that takes left for right
is recognised in each picture, by which of both fits the pose. One camera alone says nothing against
the way that a body faces while it is followed; where that is in question, its sides stand.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.recording.sighted_keypoints import MeetingPoints, SightedKeypoints
from stereotrack_core.tracking.residuals.projection import (
    PinholePoints,
    ReprojectionResidual,
    pinhole,
)

_FLOOR = 2.0
"""Pixels. No detector is more exact."""

_LEAST_SURE = 0.2
"""Confidence below which a keypoint is as uncertain as with it; standard deviations are divided by
it."""

MEETING_GATE = 0.15
"""Metres by which a ray may miss the point in which others meet."""

_SCALE, _SETTLED_SCALE = 0.25, 0.4
"""Metres from the pose at which a keypoint loses three quarters of its weight, and one that enough
cameras agree on."""

_SIDE_SCALE = 0.25
"""Metres beyond which a keypoint says no more about sides."""

_SIDE_MARGIN = 0.2
"""Cost for each keypoint by which the other way round must fit better."""

_ARM_NAMES = ("elbow", "wrist", "hand")
"""Keypoints whose sides detectors exchange while those of the trunk are right."""


@dataclass(frozen=True, eq=False)
class PlacedKeypoints:
    """Points of the body that K keypoints measure; rows of keypoints that measure none are gone."""

    seen: SightedKeypoints
    part: IntArray
    """(K,)."""
    point: FloatArray
    """(K, 3), metres. In the frames of the parts."""
    slack: FloatArray
    """(K,), metres."""
    arm: BoolArray
    """(K,). Whether it is a point of an arm beyond the shoulder."""

    def in_cameras(self, frames: PartFrames) -> FloatArray:
        """The points (K, V, 3) in the frames of the cameras, for one pose."""
        world = frames.apply(self.part, self.point)
        seen = self.seen
        turned = np.einsum("vij,kj->kvi", seen.rotation, world)
        result: FloatArray = turned + seen.translation
        return result


@dataclass(frozen=True, eq=False)
class KeypointObservation:
    """Keypoints of one instant; which of them count is told anew at every pose."""

    seen: SightedKeypoints | None
    sigma: float
    """Metres. Standard deviation of a sure keypoint, at the distance of the person."""
    _meeting: dict[bytes, MeetingPoints] = field(default_factory=dict)

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[ReprojectionResidual, ...]:
        """What all cameras say about a pose."""
        fit = self.fitted(body, pose, follows=True)
        return () if fit is None else fit.residuals()

    def fitted(self, body: BodyModel, pose: Pose, *, follows: bool = False) -> KeypointFit | None:
        """Sides and weights of the keypoints at a pose; None where nothing was predicted.

        `follows`: the way that the pose faces is known, so that one camera may have exchanged
        sides.
        """
        if self.seen is None or not self.seen.count:
            return None
        placed = _placed(self.seen, body)
        if placed is None:
            return None
        in_camera = placed.in_cameras(body.frames(pose))
        predicted = pinhole(in_camera, placed.seen.focal)
        metre = placed.seen.focal / np.maximum(in_camera[..., 2], 0.1)
        exchanged = _exchanged_sides(placed, predicted, metre, follows=follows)
        seen = placed.seen.with_sides_exchanged(exchanged)
        key = exchanged.tobytes()
        if key not in self._meeting:
            self._meeting[key] = seen.meeting(MEETING_GATE)
        return KeypointFit(placed, seen, predicted, metre, self._meeting[key], self.sigma)


@dataclass(frozen=True, eq=False)
class KeypointFit:
    """How the keypoints of one instant fit a pose."""

    placed: PlacedKeypoints
    seen: SightedKeypoints
    """With sides as they fit the pose."""
    predicted: FloatArray
    """(K, V, 2), pixels."""
    metre: FloatArray
    """(K, V). Pixels of a metre at the distance of each point."""
    meeting: MeetingPoints
    sigma: float

    @property
    def independence(self) -> float:
        """From 1/3 to 1: how much it says about the way that the body faces.

        A detector that takes left for right does so in a view again and again; three cameras seldom
        are wrong together.
        """
        return min(int(np.count_nonzero(self.seen.confidence.any(axis=0))), 3) / 3.0

    @property
    def off(self) -> FloatArray:
        """Distances (K, V) of keypoints from the pose, metres at the point; NaN where unknown."""
        pixels = np.linalg.norm(self.seen.pixel - self.predicted, axis=2)
        result: FloatArray = pixels / self.metre
        return result

    @property
    def sure(self) -> FloatArray:
        """Confidences (K, V); 0 of arms that may be crossed, unless enough cameras agree."""
        crossed = self.placed.arm & ~self.meeting.settled & self.seen.crossed
        return np.where(crossed[:, None], 0.0, self.seen.confidence)

    @property
    def weight(self) -> FloatArray:
        """From 0 to 1 (K, V): w = (g^2 / (g^2 + e^2))^2, 0 where other cameras contradict."""
        settled = self.meeting.settled[:, None]
        squared = np.where(settled, _SETTLED_SCALE, _SCALE) ** 2
        weight = (squared / (squared + self.off**2)) ** 2
        used = (self.sure > 0.0) & (self.meeting.agreed | ~settled)
        result: FloatArray = np.nan_to_num(np.where(used, weight, 0.0))
        return result

    def cost(self) -> float:
        """What speaks against the pose, from 0 to 1: mean of e^2 / (g^2 + e^2) over what counts.

        Means are weighted by the confidences.
        """
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
        points = PinholePoints(
            placed.part[k], placed.point[k], seen.rotation[v], seen.translation[v], seen.focal[v]
        )
        measured = seen.pixel[k, v].reshape(-1)
        return (ReprojectionResidual(points, measured, np.repeat(variance, 2)),)


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

    Where most cameras say so, the pose is the other way round and not they. With one camera the
    trunk tells it, which cannot have turned round since the frame before.
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
    result: FloatArray = np.minimum(distance / _SIDE_SCALE, 1.0) ** 2
    return result
