"""Cameras and detections for the tests."""

from __future__ import annotations

import numpy as np

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.detections import Detection
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.tracking.recordings import camera_towards_the_middle
from tests.tracking.scenes import CAMERAS

BODY = body_model(AVERAGE)
PLAIN_CAMERA = camera_towards_the_middle("N", CAMERAS[0])
BENT_CAMERA = Camera(
    "O",
    PLAIN_CAMERA.width,
    PLAIN_CAMERA.height,
    np.array([[150.0, 0.0, 62.0], [0.0, 156.0, 55.0], [0.0, 0.0, 1.0]]),
    np.array([-0.12, 0.03, 0.001, -0.001, 0.0]),
    False,
    camera_towards_the_middle("O", CAMERAS[1]).camera_from_world,
)


def seen(name, pose, *, kind=None, time=0.0, camera=None, sigma=0.03, off=0.0, confidence=1.0):
    """Detection of a landmark of BODY in a pose, moved by `off`."""
    place = landmarks(BODY, pose)[LANDMARKS.index(name)]
    place = place if camera is None else camera.project(place)
    return Detection(time, kind or name, place + off, sigma, confidence, camera)
