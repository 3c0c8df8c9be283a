"""Clicks alone in space: points, residuals, lengths of the body, and two readings' difference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.click_points import (
    click_pixels,
    measured_lengths,
    subject_of,
)
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE, proportions_of
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform

MATRIX = np.array([[520.0, 0, 319.5], [0, 520.0, 239.5], [0, 0, 1]])
DISTORTIONS = np.array([-0.2, 0.05, 0.001, -0.001, 0.0])
TALL = replace(AVERAGE, upper_arm_length=0.33, forearm_length=0.29, torso_length=0.55)


def looking_in(azimuth_deg: float) -> RigidTransform:
    azimuth = np.radians(azimuth_deg)
    place = np.array([2.8 * np.cos(azimuth), 2.8 * np.sin(azimuth), 1.7])
    z = np.array([0.0, 0.0, 1.1]) - place
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    return RigidTransform(rotation, -rotation @ place)


CAMERAS = {
    name: Camera(name, 640, 480, MATRIX, DISTORTIONS, False, looking_in(azimuth))
    for name, azimuth in {"N": 95.0, "O": 8.0, "S": 262.0, "W": 187.0}.items()
}


def person(frames: int, proportions=AVERAGE) -> np.ndarray:
    """Landmarks (F, 9, 3) of somebody who turns."""
    body = body_model(proportions)
    poses = [
        hanging_pose(np.array([0.0, 0.0, 0.9]), rotation_from_vector(np.array([0, 0, 0.2 * k])))
        for k in range(frames)
    ]
    return np.stack([NINE.places(body, body.frames(pose)) for pose in poses])


def clicks_of(points, *, sigma=0.0, seed=0, cameras=tuple(CAMERAS)) -> list[Click]:
    rng = np.random.default_rng(seed)
    found = []
    for frame, places in enumerate(points):
        for name in cameras:
            pixels = CAMERAS[name].project(places) + rng.normal(0, sigma, (9, 2))
            found += [
                Click(frame, name, landmark, (float(x), float(y)))
                for landmark, (x, y) in zip(NINE.names, pixels, strict=True)
            ]
    return found


def test_clicks_in_two_views_are_a_point_and_in_one_are_none():
    truth = person(3)
    clicks = clicks_of(truth, cameras=("N", "O"))
    kept = [c for c in clicks if not (c.frame == 1 and c.camera == "O" and c.landmark == "head")]
    found = click_pixels(kept, CAMERAS, NINE.names)
    points = found.points()
    head = NINE.names.index("head")
    assert np.isnan(points[1, head]).all()
    points[1, head] = truth[1, head]
    np.testing.assert_allclose(points, truth, atol=1e-6)


@pytest.mark.parametrize(("sigma", "mm"), [(0.0, 0.01), (2.0, 4.0), (8.0, 15.0)])
def test_lengths_are_measured_from_clicks(sigma, mm):
    clicks = clicks_of(person(120, TALL), sigma=sigma, seed=1)
    lengths = measured_lengths(click_pixels(clicks, CAMERAS, NINE.names))
    subject = subject_of("tall", lengths)
    assert 1000 * subject.upper_arm_length == pytest.approx(330, abs=mm)
    assert 1000 * subject.torso_length == pytest.approx(550, abs=mm)
    whole = proportions_of(subject)
    assert 1000 * whole.elbow_to_hand == pytest.approx(1000 * TALL.elbow_to_hand, abs=mm)
    assert lengths["upper_arm_length"].count == 240
    assert lengths["torso_length"].count == 120
