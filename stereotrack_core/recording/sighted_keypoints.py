"""Keypoints of one frame as rays of calibrated cameras, and where several of them meet.

A gross error of one camera is told by the others before any pose is known: of all points in which
two rays meet, the one is taken that most cameras agree with.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.recording.keypoints import Keypoints, of_one_person

_AGREED = 3  # cameras that have to agree on a point before the others are taken for wrong


@dataclass(frozen=True, eq=False)
class MeetingPoints:
    """Points in which rays of K keypoints meet."""

    world: FloatArray  # (K, 3), metres. NaN where fewer than two rays meet.
    agreed: BoolArray  # (K, V). Cameras whose rays meet there.

    @property
    def settled(self) -> BoolArray:
        """Keypoints (K,) that enough cameras agree on."""
        return np.asarray(self.agreed.sum(axis=1) >= _AGREED)


@dataclass(frozen=True, eq=False)
class SightedKeypoints:
    """K keypoints in V cameras at one instant, in pixels from the principal point, undistorted."""

    names: tuple[str, ...]  # (K,). Of the keypoints; a name stands once for each detector.
    other_side: IntArray  # (K,). Place of the same keypoint of the other side, or its own.
    cameras: tuple[str, ...]  # (V,)
    pixel: FloatArray  # (K, V, 2). NaN where not predicted.
    confidence: FloatArray  # (K, V). 0 where not predicted.
    rotation: FloatArray  # (V, 3, 3). camera_from_world.
    translation: FloatArray  # (V, 3), metres
    focal: FloatArray  # (V,), pixels
    crossed: bool = False  # whether arms may be crossed, so that an elbow may be the other hand

    @property
    def count(self) -> int:
        """Predictions of all cameras."""
        return int(np.count_nonzero(self.confidence))

    def part(self, kept: BoolArray) -> SightedKeypoints:
        """Some of the keypoints; both sides of what is kept have to be."""
        place = np.cumsum(kept) - 1
        return replace(
            self,
            names=tuple(name for name, one in zip(self.names, kept, strict=True) if one),
            other_side=place[self.other_side[kept]],
            pixel=self.pixel[kept],
            confidence=self.confidence[kept],
        )

    @cached_property
    def placed(self) -> dict[Any, Any]:
        """Places of the keypoints on each body that they are compared with, worked out once."""
        return {}

    @cached_property
    def rays(self) -> tuple[FloatArray, FloatArray]:
        """Optical centres (V, 3) and unit directions (K, V, 3), world."""
        centres = -np.einsum("vji,vj->vi", self.rotation, self.translation)
        ones = np.ones((*self.pixel.shape[:2], 1))
        ahead = np.concatenate([self.pixel / self.focal[:, None], ones], axis=2)
        turned = np.einsum("vji,kvj->kvi", self.rotation, ahead)
        return centres, turned / np.linalg.norm(turned, axis=2, keepdims=True)

    def with_sides_exchanged(self, exchanged_there: BoolArray) -> SightedKeypoints:
        """With left for right where `exchanged_there` (K, V) says so, alike for both sides."""
        pixel = np.where(exchanged_there[..., None], self.pixel[self.other_side], self.pixel)
        sure = np.where(exchanged_there, self.confidence[self.other_side], self.confidence)
        return replace(self, pixel=pixel, confidence=sure)

    def meeting(self, gate: float) -> MeetingPoints:
        """Where rays meet, by consensus; `gate` is how far from a ray its point may lie, metres."""
        centres, directions = self.rays
        pairs = np.array(list(combinations(range(len(self.cameras)), 2)), dtype=np.int64)
        if not len(pairs) or not len(self.names):
            nowhere = np.full((len(self.names), 3), np.nan)
            return MeetingPoints(nowhere, np.zeros(self.confidence.shape, dtype=np.bool_))
        candidates = nearest_to_rays(centres[pairs], directions[:, pairs])
        off = _distances(candidates[:, :, None], centres, directions[:, None])
        cost = np.minimum(np.nan_to_num(off / gate, nan=1.0), 1.0) ** 2
        best = np.argmin((cost * self.confidence[:, None]).sum(axis=2), axis=1)
        rows = np.arange(len(best))
        agreed = np.nan_to_num(off[rows, best], nan=np.inf) < gate
        weight = np.where(agreed, self.confidence**2, np.nan)
        world = nearest_to_rays(centres, directions, weight)
        enough = agreed.sum(axis=1) >= 2
        return MeetingPoints(np.where(enough[:, None], world, np.nan), agreed & enough[:, None])


def _distances(points: FloatArray, centres: FloatArray, directions: FloatArray) -> FloatArray:
    """Distances (...) of points (..., 3) from rays; NaN behind the camera."""
    away = points - centres
    along = np.einsum("...i,...i->...", away, directions)
    across = away - along[..., None] * directions
    return np.where(along > 0.0, np.linalg.norm(across, axis=-1), np.nan)


KeypointsByFrame: TypeAlias = Callable[[int], SightedKeypoints | None]
"""Gives the keypoints of a frame; None if nothing is known of any frame."""


def keypoints_in_views(
    recording: Recording, views: Sequence[str], keypoints: Keypoints | None
) -> KeypointsByFrame:
    """Keypoints of one person in the cameras of these views, both of a stereo camera's."""
    if keypoints is None:
        return lambda _frame: None
    streams = [one for name in views for one in recording.view(name).streams().values()]
    names = sorted({one.camera for one in streams if one.camera})
    cameras = {name: recording.cameras[name] for name in names}
    own = of_one_person(keypoints)
    own = own[np.isin(own.camera, names)]
    return lambda frame: sighted(own.of_frame(frame), cameras)


def sighted(keypoints: Keypoints, cameras: Cameras) -> SightedKeypoints:
    """Keypoints of one frame in calibrated cameras; of two with the same name the surer counts."""
    keys = list(zip(keypoints.source.tolist(), keypoints.keypoint.tolist(), strict=True))
    places = {key: k for k, key in enumerate(sorted(set(keys)))}
    others = [places.get((key[0], exchanged(key[1])), k) for key, k in places.items()]
    names = tuple(name for _, name in places)
    pixel = np.full((len(places), len(cameras), 2), np.nan)
    sure = np.zeros((len(places), len(cameras)))
    for v, (name, camera) in enumerate(cameras.items()):
        own = np.flatnonzero(keypoints.camera == name)
        own = own[np.argsort(keypoints.confidence[own], kind="stable")]
        k = np.array([places[keys[row]] for row in own], dtype=np.int64)
        pixel[k, v] = float(camera.matrix[0, 0]) * camera.normalised(keypoints.place[own])
        sure[k, v] = keypoints.confidence[own]
    moves = [camera.camera_from_world for camera in cameras.values()]
    return SightedKeypoints(
        names,
        np.array(others, dtype=np.int64),
        tuple(cameras),
        pixel,
        sure,
        np.array([move.rotation for move in moves]).reshape(-1, 3, 3),
        np.array([move.translation for move in moves]).reshape(-1, 3),
        np.array([float(camera.matrix[0, 0]) for camera in cameras.values()]),
    )


def points_by_name(names: Sequence[str], meeting: MeetingPoints) -> dict[str, FloatArray]:
    """Points (3,) in space by keypoint; of several detectors, the one with most cameras."""
    found: dict[str, tuple[int, FloatArray]] = {}
    support = meeting.agreed.sum(axis=1)
    for name, point, cameras in zip(names, meeting.world, support.tolist(), strict=True):
        if np.isfinite(point).all() and cameras > found.get(name, (0,))[0]:
            found[name] = cameras, point
    return {name: point for name, (_, point) in found.items()}
