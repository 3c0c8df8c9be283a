"""Proposals save clicks; accepting takes what is certain, as visible as in the frames around."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from stereotrack_core.annotation.click import (
    ACCEPTED,
    Click,
    ClickKey,
    Prediction,
    Visibility,
    measurements,
)
from stereotrack_core.annotation.follow import FOLLOWING
from stereotrack_core.annotation.follow_body import BodyStep
from stereotrack_core.annotation.landmark_filter import ProposalQuestion
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.propose import PROPOSED, NearestClicks, Proposer, acceptable
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from tests.annotation.scenes import bodies, cameras, clicks_of
from tests.tracking.views import looking

RIG = cameras()
FPS = 10.0


def question(frame, around, clicks=(), *, rig=RIG, followed=(), steps=(), wanted=inf):
    return ProposalQuestion(
        frame, tuple(clicks), tuple(around), tuple(followed), rig, NINE.names, FPS, {},
        tuple(steps), wanted,
    )  # fmt: skip


def proposed(*what, **how):
    found = Proposer()(question(*what, **how))
    return {one.key: one for one in found.predictions}


def pixels(points, rig=RIG):
    return {
        ClickKey(frame, camera.name, name): camera.project(place)
        for frame, landmarks in enumerate(points)
        for camera in rig.values()
        for name, place in zip(NINE.names, landmarks, strict=True)
    }


def seen_by(truth, *, sigma, seed):
    """Where somebody sees landmarks that are at these pixels."""
    rng = np.random.default_rng(seed)
    return {key: tuple(place + rng.normal(0.0, sigma, 2)) for key, place in truth.items()}


def off_px(found, truth):
    return np.array([np.hypot(*(one.position - truth[key])) for key, one in found.items()])


def test_a_steady_motion_goes_on():
    points = bodies(1) + np.arange(6)[:, None, None] * np.array([0.02, 0.01, 0.0])
    clicks = clicks_of(points, RIG)
    found = proposed(5, [one for one in clicks if one.frame < 5])
    assert len(found) == 36
    assert {one.source for one in found.values()} == {PROPOSED}
    assert off_px(found, pixels(points)).max() < 1.5
    last = {key: pixels(points)[4, *key[1:]] for key in found}
    assert off_px(found, last).max() > 2.5, "it has moved meanwhile"


def test_what_is_expected_before_clicks_mirrors_what_is_expected_after_them():
    points = bodies(16, seed=1)[::2]
    after = proposed(7, [one for one in clicks_of(points, RIG) if one.frame < 4])
    before = proposed(0, [one for one in clicks_of(points[::-1], RIG) if one.frame > 3])
    for key, one in after.items():
        other = before[key._replace(frame=0)]
        np.testing.assert_allclose(other.position, one.position, atol=1e-6)
        np.testing.assert_allclose(other.sigma, one.sigma)


def test_what_is_clicked_or_outside_is_not_proposed():
    points = bodies(3)
    clicks = clicks_of(points, RIG)
    own = [one for one in clicks if one.frame == 2][:3]
    own.append(Click(2, "W", "head", None, Visibility.OUTSIDE))
    found = proposed(2, [one for one in clicks if one.frame < 2], own)
    assert len(found) == 32
    assert not {one.key for one in own} & set(found)


def test_a_click_moves_its_landmark_in_the_other_images():
    points = bodies(6)
    hand = NINE.names.index("left_hand")
    points[5, hand] += np.array([0.10, -0.06, 0.12])  # what nobody could expect
    truth, clicks = pixels(points), clicks_of(points, RIG)
    before = [one for one in clicks if one.frame < 5]
    own = [one for one in clicks if one.frame == 5 and one.landmark == "left_hand"]

    def hands(*given):
        found = proposed(5, before, given)
        return off_px({k: one for k, one in found.items() if k.landmark == "left_hand"}, truth)

    assert hands().min() > 8.0
    assert np.median(hands(own[0])) < 0.5 * np.median(hands())
    assert hands(own[0], own[1]).max() < 2.0, "two images fix it in all"


def test_a_camera_that_is_off_is_proposed_where_it_shows_the_landmark():
    points = bodies(8)
    truth = pixels(points)
    for key in truth:
        if key.camera == "S":
            truth[key] = truth[key] + np.array([30.0, 18.0])
    seen = seen_by(truth, sigma=1.0, seed=4)
    clicks = [Click(*key, place) for key, place in seen.items()]
    found = proposed(7, [one for one in clicks if one.frame < 7])
    in_s = {key: one for key, one in found.items() if key.camera == "S"}
    assert np.median(off_px(in_s, truth)) < 6.0
    own = [one for one in clicks if one.frame == 7 and one.camera in "NO"]
    found = proposed(7, [one for one in clicks if one.frame < 7], own)
    assert off_px(found, truth).max() < 6.0, "the others are corrected by what is clicked"


def seen_to_move(points, start, end, *, sigma=0.002):
    """What following the body tells where it errs nowhere."""
    covariance = np.tile(sigma**2 * np.eye(3), (9, 1, 1))
    return BodyStep(start, end, NINE.names, points[end] - points[start], covariance)


def test_how_the_body_was_seen_to_move_is_believed():
    points = bodies(6)
    points[5] += np.array([0.10, -0.06, 0.12])  # what nobody could expect
    truth, clicks = pixels(points), clicks_of(points, RIG)
    before = [one for one in clicks if one.frame < 5]
    alone = off_px(proposed(5, before), truth)
    told = off_px(proposed(5, before, steps=[seen_to_move(points, 4, 5)]), truth)
    assert np.median(told) < 3.0 < 8.0 < np.median(alone)
    back = [one for one in clicks_of(points[::-1], RIG) if one.frame < 5]
    assert proposed(5, back, steps=[seen_to_move(points, 3, 5)]).keys() == proposed(5, back).keys()


def test_clicks_are_asked_for_until_the_frame_is_as_accurate_as_wanted():
    points = bodies(6)
    clicks = clicks_of(points, RIG)
    before = [one for one in clicks if one.frame < 5]
    proposer = Proposer()
    now = proposer(question(5, before)).accuracy_mm
    wanted, own = 0.5 * now, list[Click]()
    begun = found = proposer(question(5, before, wanted=wanted))
    assert begun.doubtful(RIG, 1e6)[0].key == begun.asked[0]
    assert len(begun.doubtful(RIG, 1e6)) == len(begun.asked) < 36
    assert f"Accuracy now {now:.0f} mm; about {len(begun.asked)} more click" in begun.words()
    while found.asked:
        own.append(next(one for one in clicks if one.key == found.asked[0]))
        found = proposer(question(5, before, own, wanted=wanted))
    assert found.accuracy_mm <= wanted
    assert abs(len(own) - len(begun.asked)) <= 3, "as many as was said"
    assert "good enough" in found.words(body_mm=wanted)
    far = found.words(body_mm=wanted + 30.0)
    assert f"now {wanted + 30.0:.0f} mm, by which the fitted body is off" in far


def test_clicks_do_not_take_away_what_the_cameras_are_off():
    clicks = clicks_of(bodies(6), RIG)
    before, own = ([one for one in clicks if one.frame in k] for k in (range(5), (5,)))
    doubtful = {name: replace(one, place_sigma=0.12) for name, one in RIG.items()}
    sure = Proposer()(question(5, before, own))
    found = Proposer()(question(5, before, own[:4], rig=doubtful, wanted=20.0))
    assert Proposer()(question(5, before, own, rig=doubtful)).accuracy_mm == pytest.approx(
        np.hypot(sure.accuracy_mm, 120.0 / np.sqrt(len(RIG)))
    )
    assert found.then_mm > 120.0 / np.sqrt(len(RIG)) > 20.0


def test_what_is_accepted_in_all_views_tells_no_more_than_once():
    points = bodies(6)
    before = [one for one in clicks_of(points, RIG) if one.frame < 5]
    found = proposed(5, before)
    taken = [
        Click(*key, one.position, origin=ACCEPTED)
        for key, one in found.items()
        if key.landmark == "left_hand"
    ]
    sure = Proposer()(question(5, before, taken)).accuracy_mm
    once = Proposer()(question(5, before, taken[:1])).accuracy_mm
    assert sure > 0.9 * once


def test_a_hand_that_is_expected_behind_a_camera_spoils_nothing():
    """Two cameras that face each other do not tell how far away a fast hand between them is."""
    places = {"N": (0.0, 3.0, 2.2), "S": (0.2, -3.1, 2.2)}
    ways = {name: looking(place, (0.0, 0.0, 1.1)).inverse() for name, place in places.items()}
    rig = {name: replace(RIG[name], camera_from_world=way) for name, way in ways.items()}
    rng, points = np.random.default_rng(28), bodies(6, seed=28)
    hand = NINE.names.index("right_hand")
    points[:, hand] = rng.uniform([0.0, -0.1, 1.1], [0.8, 0.35, 1.8], (6, 3))
    clicks = [one for one in clicks_of(points, rig) if one.frame < 5]
    found = Proposer()(question(5, clicks, rig=rig, wanted=1.0))
    assert np.isfinite([found.accuracy_mm, found.then_mm]).all()
    assert len({one.landmark for one in found.predictions}) >= 8


def test_without_a_calibration_points_are_followed_in_each_view():
    before = [one for one in clicks_of(bodies(2), RIG) if one.frame == 0]
    followed = [
        Prediction(1, one.camera, one.landmark, FOLLOWING, one.position, 1.5) for one in before
    ]
    found = proposed(1, before, before[:0], rig={}, followed=followed)
    assert found.keys() == {one.key for one in followed}
    assert all(one.source == PROPOSED for one in found.values())


def test_what_a_detector_sees_corrects_what_is_expected():
    points = bodies(6)
    points[5, NINE.names.index("left_hand")] += (0.0, 0.0, 0.3)
    truth = pixels(points)
    before = [one for one in clicks_of(points, RIG) if one.frame < 5]
    detected = [
        Prediction(5, key.camera, key.landmark, "detector", tuple(place), 6.0)
        for key, place in truth.items()
        if key.frame == 5
    ]
    hand = {key: place for key, place in truth.items() if key[0::2] == (5, "left_hand")}
    alone, found = (proposed(5, before, followed=seen) for seen in ((), detected))
    off = [off_px({key: one[key] for key in hand}, hand).max() for one in (alone, found)]
    assert off[1] < 0.4 * off[0]


def test_the_first_frame_is_proposed_from_what_a_detector_sees_and_clicks_correct_it():
    truth = pixels(bodies(1))
    blurred = seen_by(truth, sigma=6.0, seed=4)
    seen = [Prediction(*key, "detector", place, 8.0) for key, place in blurred.items()]
    assert not proposed(0, [])
    first = proposed(0, [], followed=seen)
    assert first.keys() == truth.keys()
    assert np.median(off_px(first, truth)) < 0.9 * 6.0
    two = tuple(RIG)[:2]
    own = [Click(*key, tuple(place)) for key, place in truth.items() if key.camera in two]
    after = proposed(0, [], own, followed=seen)
    assert len(after) == len(truth) - len(own)
    assert np.median(off_px(after, truth)) < 0.7 * np.median(off_px(first, truth))


def test_what_the_body_hides_is_proposed_as_guessed():
    points = bodies(6)
    before = [one for one in clicks_of(points, RIG) if one.frame < 5]
    wide = [one for one in before if one.camera != "N"]
    found = proposed(5, wide)
    guessed = {key for key, one in found.items() if one.visibility == Visibility.GUESSED}
    assert guessed
    assert {key.camera for key in guessed} == {"N"}, "elsewhere clicks tell how it is seen"


def test_the_certainty_is_about_right():
    points = bodies(12, seed=2)
    truth, clicks = pixels(points), clicks_of(points, RIG, sigma=1.0)
    ratios = []
    for frame in range(6, 12):
        found = proposed(frame, [one for one in clicks if one.frame < frame])
        spread = np.array([one.sigma for one in found.values()])
        ratios += list(off_px(found, truth) / spread)
    assert 0.2 < np.median(ratios) < 2.5


SEEN, GUESSED, OUTSIDE = Visibility.SEEN, Visibility.GUESSED, Visibility.OUTSIDE


def camera(name: str, lines: int) -> Camera:
    return Camera(name, 2 * lines, lines, np.eye(3), np.zeros(5), False, RigidTransform.identity())


CAMERAS = {"N": camera("N", 480), "S": camera("S", 960)}


def click(frame: int, seen: Visibility, landmark: str = "head", name: str = "N") -> Click:
    return Click(frame, name, landmark, None if seen == OUTSIDE else (1.0, 2.0), seen)


def predicted(sigma: float | None, name: str = "N", frame: int = 5) -> Prediction:
    return Prediction(frame, name, "head", "fit", (3.0, 4.0), sigma)


def test_the_limit_grows_with_the_image_and_an_unknown_sigma_is_beyond_it():
    given = (predicted(5.0), predicted(5.1), predicted(None), predicted(9.9, "S"))
    found = acceptable(given, (), CAMERAS)
    assert found.predictions == (given[0], given[3])
    assert found.words() == (
        "2 points less certain than 5 px at 480 lines stay open. Click or drag them."
    )
    assert acceptable(given[:1], (), CAMERAS).words() == ""
    assert acceptable(given, (), CAMERAS, limit=6.0).predictions == (*given[:2], given[3])


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        (SEEN, SEEN, SEEN),
        (GUESSED, None, GUESSED),
        (SEEN, GUESSED, GUESSED),
        (None, OUTSIDE, OUTSIDE),
        (OUTSIDE, OUTSIDE, OUTSIDE),
        (OUTSIDE, SEEN, None),
        (None, None, SEEN),
    ],
)
def test_visibility_is_that_of_the_nearest_clicks(before, after, expected):
    clicks = [click(0, SEEN), click(99, SEEN), click(4, OUTSIDE, "left_hand"), click(5, OUTSIDE)]
    clicks = clicks if before is not None and after is not None else clicks[2:]
    clicks += [click(2, before)] if before is not None else []
    clicks += [click(8, after)] if after is not None else []
    clicks.append(replace(click(4, GUESSED), deleted=True))
    assert NearestClicks(clicks).visibility(ClickKey(5, "N", "head")) == expected
    found = acceptable((predicted(1.0),), clicks, CAMERAS)
    assert [one.visibility for one in found.predictions] == [expected] * (expected is not None)


def test_what_was_accepted_in_several_images_tells_the_fit_once():
    by_hand = click(0, SEEN)
    taken = [replace(click(0, SEEN, name=name), origin=ACCEPTED) for name in ("S", "O", "W", "E")]
    other = replace(click(1, SEEN), origin=ACCEPTED)
    found = measurements([by_hand, *taken, other], ("head",), 3.0)
    assert [one.sigma for one in found] == [3.0, 6.0, 6.0, 6.0, 6.0, 3.0]
