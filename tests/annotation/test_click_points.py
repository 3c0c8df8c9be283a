"""Clicks alone in space: points, residuals, lengths of the body, and two readings' difference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.agreement import agreement_in_space, differences
from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.click_points import (
    click_pixels,
    click_residuals,
    limb_residuals,
    measured_lengths,
    subject_of,
)
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.limbs import LIMBS
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


def test_residuals_are_distances_from_the_projected_trajectory():
    truth = person(4)
    clicks = clicks_of(truth)
    elbow = clicks.index(next(c for c in clicks if c.landmark == "left_elbow" and c.frame == 2))
    x, y = clicks[elbow].position
    clicks[elbow] = replace(clicks[elbow], position=(x + 3.0, y + 4.0))
    found = click_pixels(clicks, CAMERAS, NINE.names)
    away = click_residuals(found, np.array([0, 2, 3]), truth[[0, 2, 3]])
    assert np.isnan(away[1]).all()
    assert away[2, NINE.names.index("left_elbow"), 0] == pytest.approx(5.0, abs=1e-6)
    assert limb_residuals(away[:0], NINE).shape == (0, 6), "of no frame"
    limbs = limb_residuals(away, NINE)
    # one of the shoulder's and the elbow's eight clicks is five pixels off
    assert limbs[2, LIMBS.index("left_upper_arm")] == pytest.approx(np.sqrt(25 / 8), abs=1e-6)
    assert limbs[2, LIMBS.index("torso")] == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(limbs[1]).all()


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


def test_two_readings_differ_in_millimetres_and_degrees():
    truth = person(40)
    first, second = clicks_of(truth), clicks_of(truth, sigma=2.0, seed=4)
    found = agreement_in_space(differences(first, second), CAMERAS, NINE)
    assert found["left_elbow"].count == 40
    # 2 px at 2.8 m and 520 px of focal length, averaged over four views
    assert 4.0 < found["left_elbow"].median_mm < 15.0
    assert 0.5 < found["left_elbow"].median_deg < 5.0
    assert found["head"].p95_mm > found["head"].median_mm
    same = agreement_in_space(differences(first, first), CAMERAS, NINE)
    assert same["left_hand"].median_mm == pytest.approx(0.0, abs=1e-9)
