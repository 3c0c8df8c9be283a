"""Keypoints that the installed pose detector sees in the pictures, while clouds are made.

What a detector sees depends on the picture and on the crop that it is given. The crop follows from
the cloud of the same frame and not from the frame before, so that a frame gives the same keypoints
in whatever order frames are asked for.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.pose_model.crops import Crop, crop_from_body
from stereotrack_core.pose_model.detect import DETECTOR_NAME, LEAST_CONFIDENCE, confidence
from stereotrack_core.pose_model.detector import (
    PERSON_SCORE,
    POINT_NAMES,
    DetectedPose,
    PoseDetector,
    load_detector,
    next_crop,
)
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints, Row, keypoints_of
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, sighted
from stereotrack_core.tracking.parameters import Settings

_TO_SHOULDERS = 0.5  # metres from the hips to the shoulders of somebody who stands
# Share of the radius of a body by which its hips may lie beside the middle of a crop: farther, the
# landmarks are looked for again around them.
_FAR = 0.25
# Metres by which the detector's points lie beside the landmarks of their names: medians of
# simulated people whose truth is known; those of a rendered mesh have the same signs.
KEYPOINT_OFFSETS: Mapping[str, float] = MappingProxyType(
    {
        "keypoint_shoulder_out": -0.015,
        "keypoint_shoulder_up": 0.02,
        "keypoint_elbow_along": -0.045,
        "keypoint_wrist_along": -0.02,
        "keypoint_hip_out": -0.008,
        "keypoint_hip_up": -0.02,
    }
)
# (33,). Factors on the confidences: points of arms are off by twice as much as those of the trunk,
# however sure the detector is.
_TRUST = np.array(
    [0.5 if n.split("_")[-1] in ("elbow", "wrist", "hand") else 1.0 for n in POINT_NAMES]
)
_LEAST_DEPTH = 0.1  # metres before a camera from which points can be seen
# Metres from the cloud within which keypoints of the person lie, and from which one is none of the
# person. In undisturbed recordings, 99 % of the trunk's are within 0.06, of the wrists 0.2.
_NEAR, _BESIDE = 0.12, 0.3
# Share of a picture's keypoints that lie on the person; where fewer do, none is used. Undisturbed:
# 0.78 and more, 0.93 in 95 % of all pictures; with half of them anywhere in the picture, 0.6.
_FEWEST_NEAR = 0.7
# Distances of wrists and of elbows in a picture, over that of the shoulders, below and above which
# arms may be crossed. The detector then puts both wrists where forearms cross, and each elbow where
# the other hand is: simulated elbows are 0.15 m off, with confidences of 0.8 to 1, else 0.05 m.
_TOGETHER, _AT_SIDES = 0.5, 0.9
_FEET = ("ankle", "heel", "toe")  # clouds lack points with these names, as they lack the floor


class SeenKeypoints:
    """Keypoints of the person of each cloud, as the installed detector sees them.

    A frame is looked at once, in the reference pictures of the views: what was seen is kept, and
    what an earlier run has `seen` by frame is taken instead, all that is known without a detector.
    """

    def __init__(
        self,
        detector: PoseDetector | None,
        recording: Recording,
        views: Sequence[str],
        reader: FrameReader,
        upright: Upright,
        seen: Mapping[int, Keypoints] | None = None,
    ) -> None:
        self.name, self._seen = DETECTOR_NAME, dict(seen or {})
        self._detector, self._reader, self._upright = detector, reader, upright
        self._views = {name: recording.view(name).image.camera for name in views}
        self._cameras = _reference_cameras(recording, views)
        self._every = len(views)  # one picture a frame on average

    def of(self, cloud: Cloud, first: int) -> SightedKeypoints | None:
        """Keypoints of a cloud's frame in a run from the first on; None where it is passed over."""
        if cloud.frame not in self._seen:
            looks = not (cloud.frame - first) % self._every and len(cloud.points)
            rows = keypoints_of(self._rows(cloud) if looks else ())
            self._seen[cloud.frame] = without_outliers(rows, cloud, self._cameras)
        return _sighted_used(self._seen[cloud.frame], self._cameras)

    def seen(self, frame: int) -> Keypoints:
        """What was seen in a frame; empty if it was passed over."""
        return self._seen.get(frame, keypoints_of(()))

    def body(self, body: BodyModel) -> BodyModel:
        """The body whose keypoints are where the detector sees them."""
        return body.with_shape(body.shape.replaced(**KEYPOINT_OFFSETS))

    def _rows(self, cloud: Cloud) -> Iterator[Row]:
        if self._detector is None:
            return
        hips = np.median(cloud.points, axis=0)
        shoulders = hips + _TO_SHOULDERS * self._upright.up
        images = self._reader.frame_set(cloud.frame).views
        for view, camera in self._views.items():
            if view not in images:
                continue
            picture = images[view].image
            crop = crop_from_body(self._cameras[camera], hips, shoulders)
            pose = None if crop is None else _pose_in(self._detector, picture, crop)
            if pose is None:
                continue
            sure = confidence(pose, picture.shape) * _TRUST
            for k in np.flatnonzero(sure >= LEAST_CONFIDENCE * _TRUST).tolist():
                x, y = pose.points[k].tolist()
                yield cloud.frame, camera, POINT_NAMES[k], x, y, float(sure[k]), DETECTOR_NAME, 0


def _pose_in(detector: PoseDetector, picture: ImageArray, crop: Crop) -> DetectedPose | None:
    """Landmarks of the person in a picture; None where none is seen."""
    pose = detector.landmarks(picture, crop)
    if pose.score < PERSON_SCORE:
        return None
    radius = np.linalg.norm(pose.circle[1] - pose.circle[0])
    if np.linalg.norm(pose.circle[0] - crop.centre) > _FAR * radius:
        pose = detector.landmarks(picture, next_crop(pose))
    return pose if pose.score >= PERSON_SCORE else None


def _reference_cameras(recording: Recording, views: Sequence[str]) -> dict[str, Camera]:
    chosen = map(recording.view, views)
    return {view.image.camera: recording.reference_camera(view) for view in chosen}


def seen_in_views(
    recording: Recording, views: Sequence[str], seen: Keypoints
) -> SightedKeypoints | None:
    """What the detector saw in a frame, in the reference cameras of views; None if nothing."""
    return _sighted_used(seen, _reference_cameras(recording, views))


def _sighted_used(seen: Keypoints, cameras: Mapping[str, Camera]) -> SightedKeypoints | None:
    used = seen[seen.confidence > 0.0]
    crossed = any(_may_cross(used[used.camera == name]) for name in cameras)
    return replace(sighted(used, cameras), crossed=crossed) if len(used) else None


def without_outliers(seen: Keypoints, cloud: Cloud, cameras: Mapping[str, Camera]) -> Keypoints:
    """Keypoints of a frame with confidence 0 for those that are none of the person in the cloud.

    They are kept, so that a run states what was left out.
    """
    sure = seen.confidence.copy()
    for name, camera in cameras.items():
        own = np.flatnonzero(seen.camera == name)
        if not len(own):
            continue
        beside = _beside(seen.place[own], cloud.points, camera)
        feet = np.array([one.endswith(_FEET) for one in seen.keypoint[own].tolist()])
        few = np.mean(beside[~feet] < _NEAR) < _FEWEST_NEAR if not feet.all() else False
        sure[own[(beside > _BESIDE) & ~feet | few]] = 0.0
    return replace(seen, confidence=sure)


def _may_cross(seen: Keypoints) -> bool:
    """Whether one picture has the wrists together between elbows at the sides."""
    places, nowhere = dict(zip(seen.keypoint.tolist(), seen.place, strict=True)), np.full(2, np.nan)
    wrists, elbows, shoulders = (
        np.linalg.norm(places.get(f"left_{one}", nowhere) - places.get(f"right_{one}", nowhere))
        for one in ("wrist", "elbow", "shoulder")
    )
    return bool(wrists < _TOGETHER * shoulders and elbows > _AT_SIDES * shoulders)


def _beside(places: FloatArray, points: FloatArray, camera: Camera) -> FloatArray:
    """Metres (K,) by which rays through pixels (K, 2) miss the nearest of points (N, 3), world."""
    depth = camera.camera_from_world.apply(points)[:, 2]
    points, depth = points[depth > _LEAST_DEPTH], depth[depth > _LEAST_DEPTH]
    if not len(points):
        return np.full(len(places), np.inf)
    off = np.linalg.norm(places[:, None] - camera.project(points), axis=2)
    return np.asarray((off * depth).min(axis=1) / float(camera.matrix[0, 0]))


def detects_first(recording: Recording, settings: Settings) -> bool:
    """Whether the installed detector looks at mono views before they are tracked.

    It does where no keypoints are given. Views that give depth are looked at while tracking.
    """
    return settings.uses_detector and not gives_depth(recording) and is_installed()


def seen_keypoints(
    recording: Recording,
    views: Sequence[str],
    reader: FrameReader,
    settings: Settings,
    seen: Mapping[int, Keypoints] | None = None,
) -> SeenKeypoints | None:
    """Keypoints of the installed detector for a run; None where it is missing or not wanted.

    `seen`: by frame, what an earlier run saw; it is used without an installed detector, too.
    """
    if not (settings.uses_detector and gives_depth(recording)):
        return None
    detector = load_detector()
    if detector is None and seen is None:
        return None
    return SeenKeypoints(detector, recording, views, reader, settings.depth.upright, seen)
