"""Clicks alone in space: points, residuals, lengths of the body, and two readings' difference."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.click_points import click_pixels, measured_lengths, subject_of
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE, proportions_of
from stereotrack_core.geometry.rotation import rotation_from_vector
from tests.annotation.scenes import cameras, clicks_of

TALL = replace(AVERAGE, upper_arm_length=0.33, forearm_length=0.29, torso_length=0.55)


CAMERAS = cameras()


def person(frames: int, proportions=AVERAGE) -> np.ndarray:
    """Landmarks (F, 9, 3) of somebody who turns."""
    body = body_model(proportions)
    poses = [
        hanging_pose(np.array([0.0, 0.0, 0.9]), rotation_from_vector(np.array([0, 0, 0.2 * k])))
        for k in range(frames)
    ]
    return np.stack([NINE.places(body, body.frames(pose)) for pose in poses])


def test_clicks_in_two_views_are_a_point_and_in_one_are_none():
    truth = person(3)
    clicks = clicks_of(truth, {name: CAMERAS[name] for name in "NO"})
    kept = [c for c in clicks if not (c.frame == 1 and c.camera == "O" and c.landmark == "head")]
    found = click_pixels(kept, CAMERAS, NINE.names)
    points = found.points()
    head = NINE.names.index("head")
    assert np.isnan(points[1, head]).all()
    points[1, head] = truth[1, head]
    np.testing.assert_allclose(points, truth, atol=1e-6)


@pytest.mark.parametrize(("sigma", "mm"), [(0.0, 0.01), (2.0, 4.0), (8.0, 15.0)])
def test_lengths_are_measured_from_clicks(sigma, mm):
    clicks = clicks_of(person(120, TALL), CAMERAS, sigma=sigma, seed=1)
    lengths = measured_lengths(click_pixels(clicks, CAMERAS, NINE.names))
    subject = subject_of("tall", lengths)
    assert 1000 * subject.upper_arm_length == pytest.approx(330, abs=mm)
    assert 1000 * subject.torso_length == pytest.approx(550, abs=mm)
    whole = proportions_of(subject)
    assert 1000 * whole.elbow_to_hand == pytest.approx(1000 * TALL.elbow_to_hand, abs=mm)
    assert lengths["upper_arm_length"].count == 240
    assert lengths["torso_length"].count == 120


CLICK = Click(4, "N_right", "left_elbow", (12.5, 40.0))


@pytest.mark.parametrize(
    "wrong",
    [
        {"frame": -1},
        {"position": None},
        {"visibility": Visibility.OUTSIDE},
        {"position": (float("nan"), 1.0)},
        {"sigma": 0.0},
        {"sigma": float("inf")},
    ],
)
def test_what_cannot_be_is_refused(wrong: dict[str, object]):
    with pytest.raises(ValueError, match=r"."):
        replace(CLICK, **wrong)


def test_who_and_when_do_not_change_what_a_click_says():
    assert CLICK.says_the_same(replace(CLICK, who="A", at="2026-01-01T00:00:00", origin="merged"))
    assert not CLICK.says_the_same(replace(CLICK, position=(12.5, 40.1)))
    assert not CLICK.says_the_same(replace(CLICK, deleted=True))
    assert not CLICK.says_the_same(replace(CLICK, flag="uncertain"))
