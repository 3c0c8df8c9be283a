"""A person who moves in front of four cameras, and clicks on the landmarks."""

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.context import CLICKED_SHAPE
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from tests.annotation.scenes import cameras
from tests.tracking.scenes import pose_with_arms

CAMERAS = cameras("barrel")
BODY = body_model(AVERAGE, CLICKED_SHAPE)


def pose(k: int):
    """The person at frame `k`: arms that rise and bend, a body that sways."""
    t = 0.15 * k
    return pose_with_arms(
        [1, 0.4 * np.sin(t), 0.5 * np.sin(0.7 * t)],
        [1, 0.8 * np.cos(t), 0.6],
        [-1, 0.5 * np.cos(t), -0.3],
        [-0.6, 1.0, 0.5 * np.sin(t)],
        place=(0.05 * np.sin(t), 0.02 * k, 0.95),
    )


def places(k: int) -> np.ndarray:
    return NINE.places(BODY, BODY.frames(pose(k)))


def clicked(k, rng, sigma=2.0, seen_by=tuple(CAMERAS), names=NINE.names, rig=CAMERAS):
    """Clicks on the landmarks of a frame, with noise."""
    return clicks_on(k, places(k), rng, sigma, names, {camera: rig[camera] for camera in seen_by})


def clicks_on(k, points, rng, sigma, names=NINE.names, rig=CAMERAS):
    """Clicks on the nine points (9, 3) of a frame in all cameras of a rig, with noise."""
    where = dict(zip(NINE.names, points, strict=True))
    return tuple(
        Click(k, name, landmark, tuple(pixel + rng.normal(0, sigma, 2)), sigma=sigma)
        for name, camera in rig.items()
        for landmark in names
        for pixel in [camera.project(where[landmark])]
    )


def fitting(rig=CAMERAS, **changes) -> ClickFit:
    return ClickFit(rig, NINE, AVERAGE, FitSettings(**changes))
