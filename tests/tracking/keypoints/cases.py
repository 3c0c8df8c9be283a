"""Cameras and detections for the tests."""

from dataclasses import replace

import numpy as np

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.detections import Detection
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.tracking.recordings import camera_towards_the_middle
from tests.tracking.scenes import CAMERAS

BODY = body_model(AVERAGE)
VIEWS = {n: camera_towards_the_middle(n, at) for n, at in zip("NOSW", CAMERAS, strict=True)}
PLAIN_CAMERA = VIEWS["N"]
BENT_CAMERA = replace(
    VIEWS["O"],
    matrix=np.array([[150.0, 0.0, 62.0], [0.0, 156.0, 55.0], [0.0, 0.0, 1.0]]),
    distortions=np.array([-0.12, 0.03, 0.001, -0.001, 0.0]),
)


def seen(name, pose, *, kind=None, time=0.0, camera=None, sigma=0.03, off=0.0, confidence=1.0):
    """Detection of a landmark of BODY in a pose, moved by `off`."""
    place = landmarks(BODY, pose)[LANDMARKS.index(name)]
    place = place if camera is None else camera.project(place)
    return Detection(time, kind or name, place + off, sigma, confidence, camera)
