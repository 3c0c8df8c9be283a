"""Clicks alone: points in space, lengths of the body, and two readings' difference."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.agreement import (
    agreement,
    agreement_by_landmark,
    click_sigmas,
    differences,
)
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


HEAD = Click(0, "S", "head", (10.0, 20.0))
OUTSIDE = replace(HEAD, position=None, visibility=Visibility.OUTSIDE)


@pytest.mark.parametrize(
    ("first", "second", "kind", "distance"),
    [
        (HEAD, HEAD, "same", 0.0),
        (HEAD, replace(HEAD, visibility=Visibility.GUESSED), "same", 0.0),
        (HEAD, replace(HEAD, position=(13.0, 24.0)), "apart", 5.0),
        (HEAD, OUTSIDE, "seen differently", None),
        (OUTSIDE, OUTSIDE, "same", None),
        (HEAD, None, "only first", None),
        (None, HEAD, "only second", None),
        (HEAD, replace(HEAD, deleted=True), "only first", None),
        (replace(HEAD, deleted=True), HEAD, "only second", None),
        (replace(HEAD, deleted=True), None, "same", None),
    ],
)
def test_kinds_of_differences(first, second, kind, distance):
    (found,) = differences([first] if first else [], [second] if second else [])
    assert (found.kind, found.distance) == (kind, distance)
    assert found.key == HEAD.key


def two_readings(sigma: float, count: int) -> tuple[list[Click], list[Click]]:
    rng = np.random.default_rng(0)
    truth = rng.uniform(100, 500, (count, 2))
    return tuple(
        [
            Click(frame, "S", landmark, tuple(place + rng.normal(0, sigma, 2)))
            for frame, place in enumerate(truth)
            for landmark in ("head", "left_hip")
        ]
        for _ in range(2)
    )


def test_the_sigma_of_a_click_is_found_from_two_readings():
    """4,000 distances: the standard error of sigma is below 1 percent."""
    first, second = two_readings(2.0, 2000)
    found = agreement(differences(first, second))
    assert found.count == 4000
    assert found.sigma == pytest.approx(2.0, rel=0.03)
    assert found.robust_sigma == pytest.approx(2.0, rel=0.04)
    assert np.hypot(*found.bias) < 0.15


def test_single_outliers_do_not_change_the_robust_sigma():
    first, second = two_readings(2.0, 500)
    for i in range(0, 1000, 50):
        x, y = second[i].position
        second[i] = replace(second[i], position=(x + 80.0, y))
    found = agreement(differences(first, second))
    assert found.sigma > 5.0
    assert found.robust_sigma == pytest.approx(2.0, rel=0.08)
    assert found.largest > 70.0


def test_a_landmark_that_is_understood_differently_shows_as_bias():
    first, second = two_readings(1.0, 300)
    moved = [
        replace(one, position=(one.position[0] + 6.0, one.position[1] - 3.0))
        if one.landmark == "left_hip"
        else one
        for one in second
    ]
    found = agreement_by_landmark(differences(first, moved))
    assert set(found) == {"head", "left_hip"}
    assert found["left_hip"].bias == pytest.approx((6.0, -3.0), abs=0.3)
    assert found["head"].bias == pytest.approx((0.0, 0.0), abs=0.3)


def test_measured_sigmas_start_from_the_usual_one_and_settle_on_what_is_measured():
    first, second = two_readings(4.0, 400)
    found = differences(first, second)
    names = ["head", "left_hip", "right_hip"]
    assert click_sigmas((), names, 2.0) == dict.fromkeys(names, 2.0)
    many = click_sigmas(found, names, 2.0)
    assert many["head"] == pytest.approx(4.0, rel=0.1)
    assert many["right_hip"] == pytest.approx(4.0, rel=0.1), "as the others, nobody measured it"
    few = click_sigmas(found[:10], names, 2.0)
    assert 2.0 < few["right_hip"] < agreement(found[:10]).robust_sigma
    wild = [replace(one, position=(900.0, 900.0)) for one in second[:20]] + second[20:]
    assert click_sigmas(differences(first, wild), names, 2.0)["head"] < 4.6
