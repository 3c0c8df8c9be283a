"""Keypoints that the installed pose detector sees in the pictures, while clouds are made.

What a detector sees depends on the picture and on the crop that it is given. The crop follows from
the cloud of the same frame and not from the frame before, so that a frame gives the same keypoints
in whatever order frames are asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.pose_model.crops import crop_from_body
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
from stereotrack_core.recording.keypoints import Row, keypoints_of
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, sighted
from stereotrack_core.tracking.parameters import Settings

_TO_SHOULDERS = 0.5
"""Metres from the hips to the shoulders of somebody who stands."""

_FAR = 0.25
"""Share of the radius of a body by which its hips may lie beside the middle of a crop: farther, the
landmarks are looked for again around them."""


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
"""Metres by which the detector's points lie beside the landmarks of their names: medians of
simulated people whose truth is known; those of a rendered mesh have the same signs."""


_TRUST = np.array(
    [0.5 if n.split("_")[-1] in ("elbow", "wrist", "hand") else 1.0 for n in POINT_NAMES]
)
"""(33,). Factors on the confidences: points of arms are off by twice as much as those of the trunk,
and more where arms cross, however sure the detector is."""


class SeenKeypoints:
    """Keypoints of the person of each cloud, as the installed detector sees them.

    Attributes
    ----------
    name : str
        Of the detector.

    Parameters
    ----------
    recording : Recording
    views : sequence of str
        Whose reference pictures are looked at.
    reader : FrameReader
    upright : Upright
    """

    def __init__(
        self,
        detector: PoseDetector,
        recording: Recording,
        views: Sequence[str],
        reader: FrameReader,
        upright: Upright,
    ) -> None:
        self.name = DETECTOR_NAME
        self._detector, self._reader, self._upright = detector, reader, upright
        chosen = [recording.view(name) for name in views]
        self._views = {view.name: view.image.camera for view in chosen}
        self._cameras = {view.image.camera: recording.reference_camera(view) for view in chosen}
        self._every = len(views)  # one picture a frame on average

    def of(self, cloud: Cloud, first: int) -> SightedKeypoints | None:
        """Keypoints of a cloud's frame in a run from the first on; None where it is passed over."""
        if (cloud.frame - first) % self._every or not len(cloud.points):
            return None
        return sighted(keypoints_of(self._rows(cloud)), self._cameras)

    def body(self, body: BodyModel) -> BodyModel:
        """The body whose keypoints are where the detector sees them."""
        return body.with_shape(body.shape.replaced(**KEYPOINT_OFFSETS))

    def _rows(self, cloud: Cloud) -> Iterator[Row]:
        hips = np.median(cloud.points, axis=0)
        shoulders = hips + _TO_SHOULDERS * self._upright.up
        images = self._reader.frame_set(cloud.frame).views
        for view, camera in self._views.items():
            if view not in images:
                continue
            picture = images[view].image
            pose = self._pose(picture, self._cameras[camera], hips, shoulders)
            if pose is None:
                continue
            sure = confidence(pose, picture.shape) * _TRUST
            for k in np.flatnonzero(sure >= LEAST_CONFIDENCE * _TRUST).tolist():
                x, y = pose.points[k].tolist()
                yield cloud.frame, camera, POINT_NAMES[k], x, y, float(sure[k]), DETECTOR_NAME, 0

    def _pose(
        self, picture: ImageArray, camera: Camera, hips: FloatArray, shoulders: FloatArray
    ) -> DetectedPose | None:
        """Landmarks of the person in a picture; None where none is seen."""
        crop = crop_from_body(camera, hips, shoulders)
        if crop is None:
            return None
        pose = self._detector.landmarks(picture, crop)
        if pose.score < PERSON_SCORE:
            return None
        radius = np.linalg.norm(pose.circle[1] - pose.circle[0])
        if np.linalg.norm(pose.circle[0] - crop.centre) > _FAR * radius:
            pose = self._detector.landmarks(picture, next_crop(pose))
        return pose if pose.score >= PERSON_SCORE else None


def detects_first(recording: Recording, settings: Settings) -> bool:
    """Whether the installed detector looks at mono views before they are tracked.

    It does where no keypoints are given. Views that give depth are looked at while tracking.
    """
    wanted = settings.tracking.detector == "auto" and settings.follows_data
    return wanted and not gives_depth(recording) and is_installed()


def seen_keypoints(
    recording: Recording,
    views: Sequence[str],
    reader: FrameReader,
    settings: Settings,
    *,
    may: bool = True,
) -> SeenKeypoints | None:
    """Keypoints of the installed detector for a run; None where it is missing or not wanted."""
    wanted = may and settings.tracking.detector == "auto" and settings.follows_data
    if not (wanted and gives_depth(recording)):
        return None
    detector = load_detector()
    if detector is None:
        return None
    return SeenKeypoints(detector, recording, views, reader, settings.depth.upright)
