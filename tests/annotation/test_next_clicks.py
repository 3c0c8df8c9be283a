"""Suggestions are where a click helps, say why, and are kept up to date by edits."""

from dataclasses import replace

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.click_gains import SCORED
from stereotrack_core.annotation.doubts import Doubt
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.next_clicks import NextClicks, Wish, good_enough
from stereotrack_core.annotation.predict import hidden_landmarks
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from tests.annotation.fits import fit_of
from tests.annotation.scenes import bodies, cameras, clicks_of, one_camera_off

RIG = cameras()
SIDES = ("left", "right")


def clicked_every(points, step, rig=RIG):
    return [click for click in clicks_of(points, rig) if click.frame % step == 0]


def test_clicks_are_asked_for_where_least_is_known():
    points = bodies(60)
    clicked = [0, 10, 50]
    clicks = [click for click in clicks_of(points, RIG) if click.frame in clicked]
    found = NextClicks(RIG, NINE, fit_of(points, clicked), clicks).best()
    assert 25 <= found[0].frame <= 35
    assert "no click for 39 frames" in found[0].reason
    assert "uncertain (" in found[0].reason
    fit = fit_of(points, clicked)
    wide = replace(fit, covariance=400.0 * fit.covariance, limb_sigma_deg=20.0 * fit.limb_sigma_deg)
    unknown = NextClicks(RIG, NINE, wide, clicks).best()[0].reason
    assert unknown.endswith("unknown, no click for 39 frames")
    totals = [one.over_frames_deg for one in found]
    assert totals == sorted(totals, reverse=True)
    assert all(one.over_frames_deg > one.gain_deg > 0 for one in found)
    assert not {one.key for one in found} & {click.key for click in clicks}
    assert all(one.landmark != "head" for one in found)  # the head enters no measure


def test_places_outside_deleted_and_out_of_sight_are_not_asked_for():
    points = bodies(20)
    clicks = clicked_every(points, 19)
    refused = [
        Click(frame, camera, name, None, Visibility.OUTSIDE)
        for frame in range(1, 19)
        for camera in "NOS"
        for name in NINE.names
    ]
    refused += [
        Click(frame, "W", name, (1.0, 1.0), deleted=True)
        for frame in range(1, 19)
        for name in NINE.names
        if name != "left_hand"
    ]
    found = NextClicks(RIG, NINE, fit_of(points, [0, 19]), clicks + refused).best()
    assert {(one.camera, one.landmark) for one in found} == {("W", "left_hand")}
    far = points + [0.0, 0.0, 30.0]
    assert not NextClicks(RIG, NINE, fit_of(far, [0, 19]), []).best()


def test_flagged_gaps_and_wishes_are_kept_to():
    points = bodies(80)
    clicks = clicked_every(points, 20)
    fit = fit_of(points, range(0, 80, 20))
    found = NextClicks(RIG, NINE, fit, clicks).best(Wish(gaps=[range(21, 60)]))
    assert found
    assert not any(21 <= one.frame < 60 for one in found)
    wish = Wish(5, frames=range(40, 60))
    chosen = NextClicks(RIG, NINE, fit, clicks).best(wish)
    assert 0 < len(chosen) <= 5
    assert all(40 <= one.frame < 60 for one in chosen)


def test_probable_outliers_and_high_residuals_are_to_be_looked_at_again():
    points = bodies(20)
    clicks = clicked_every(points, 5)
    wrong, far = ClickKey(5, "N", "left_elbow"), ClickKey(10, "O", "right_hand")
    fit = fit_of(
        points,
        range(0, 20, 5),
        residuals={wrong: np.array([60.0, 0]), far: np.array([0.0, 20])},
        outliers={wrong: 0.97, far: 0.2},
    )
    ranking, unlike = NextClicks(RIG, NINE, fit, clicks), ClickKey(15, "W", "head")
    ranking.add({unlike: Doubt(0.6, 1.0, "elsewhere", "appearance")})
    best = ranking.best(Wish(500))
    found = {one.key: one for one in best}
    assert {one.key for one in best[:3]} == {wrong, far, unlike}, "mend before more is clicked"
    assert max(one.over_frames_deg for one in best[3:]) > found[unlike].over_frames_deg
    assert found[wrong].reason == "probable outlier, 60 px"
    assert found[far].reason == "far from the fit, 20 px"
    assert found[wrong].click_there
    assert found[far].click_there
    assert found[far].gain_deg > 1.0


def test_clicks_of_a_camera_that_is_wrong_itself_are_not_to_be_clicked_again():
    points = bodies(20)
    clicks = one_camera_off(clicked_every(points, 5), "S", (40.0, 0.0))
    keys = [one.key for one in clicks if one.camera == "S"]
    keys.append(ClickKey(10, "O", "right_hand"))  # drawn aside by that camera
    fit = fit_of(
        points,
        range(0, 20, 5),
        residuals=dict.fromkeys(keys, np.array([30.0, 0.0])),
        outliers=dict.fromkeys(keys, 0.9),
    )
    every = NextClicks(RIG, NINE, fit, clicks).best(Wish(500))
    found = [one for one in every if one.kind != "camera"]
    assert not [one for one in found if "outlier" in one.reason]
    assert {one.camera for one in found if one.clear} == {"N", "O", "W"}
    assert "S" not in {one.camera for one in found}, "where others see the landmark as well"


def test_what_would_be_guessed_or_is_seen_by_a_wrong_camera_comes_last():
    points = bodies(20)
    clicks = one_camera_off(clicked_every(points, 5), "S", (40.0, 0.0))
    outside = [
        Click(frame, camera, "left_hand", None, Visibility.OUTSIDE)
        for frame in range(20)
        for camera in "NOW"
        if frame % 5
    ]
    ranking = NextClicks(RIG, NINE, fit_of(points, range(0, 20, 5)), clicks + outside)
    gains, found = ranking.gains, ranking.best(Wish(500))
    for one in found:
        place = one.frame, gains.names.index(one.camera), NINE.names.index(one.landmark)
        assert one.clear == (one.camera != "S" and not gains.hidden[place])
    order = [(not one.clear, -one.over_frames_deg) for one in found]
    assert order == sorted(order)
    last = [one for one in found if not one.clear]
    assert {(one.camera, one.landmark) for one in last} == {("S", "left_hand")}
    assert all(one.reason.startswith("the view disagrees with the others") for one in last)
    assert last[0].over_frames_deg > min(one.over_frames_deg for one in found if one.clear)


def test_swapped_sides_are_told():
    points = bodies(12)
    clicks = {click.key: click for click in clicked_every(points, 4)}
    keys = [ClickKey(4, "S", name) for name in ("left_elbow", "right_elbow")]
    one, two = (clicks[key] for key in keys)
    clicks[keys[0]] = replace(one, position=two.position)
    clicks[keys[1]] = replace(two, position=one.position)
    away = np.subtract(two.position, one.position)
    fit = fit_of(
        points,
        range(0, 12, 4),
        residuals=dict.fromkeys(keys, away),
        outliers=dict.fromkeys(keys, 0.9),
    )
    found = {s.key: s for s in NextClicks(RIG, NINE, fit, clicks.values()).best(Wish(500))}
    assert "seem to be swapped" in found[keys[0]].reason


def test_disagreement_with_a_tracker_moves_its_frames_up_and_is_told():
    points = bodies(60)
    clicks = clicked_every(points, 10)
    fit = fit_of(points, range(0, 60, 10))
    other = points.copy()
    hand, elbow = LANDMARKS.index("left_hand"), LANDMARKS.index("left_elbow")
    other[42:48, hand] = other[42:48, elbow] - (other[42:48, hand] - other[42:48, elbow])
    run = LandmarkTrajectory(np.arange(60), other)
    found = NextClicks(RIG, NINE, fit, clicks, run=run).best()
    assert 42 <= found[0].frame < 48
    assert found[0].reason.startswith("tracker and reference differ by 180 deg (left forearm)")


def test_an_edit_brings_down_what_its_click_would_have_gained():
    points = bodies(60)
    clicks = clicked_every(points, 30)
    ranking = NextClicks(RIG, NINE, fit_of(points, [0, 30]), clicks)
    first = ranking.best()[0]
    all_there = {click.key: click for click in clicks_of(points, RIG)}
    ranking.update(first.frame, [all_there[first.key]])
    after = ranking.best(Wish(500))
    assert first.key not in {one.key for one in after}
    near = [one for one in after if one.landmark == first.landmark and one.camera == first.camera]
    assert all(one.gain_deg < first.gain_deg for one in near)


def test_stop_sign_counts_frames_and_limbs():
    sigma = np.full((100, 6), 2.0)
    sigma[:, LIMBS.index("head")] = 50.0  # not scored
    sigma[:3, LIMBS.index("left_forearm")] = 6.0
    sigma[0, LIMBS.index("right_upper_arm")] = np.nan
    sign = good_enough(sigma, 3.0)
    assert sign.frames_missing == 3
    assert sign.missing_by_limb["left_forearm"] == 3
    assert sign.missing_by_limb["right_upper_arm"] == 1
    assert sign.reached
    assert sign.words() == (
        "3 of 100 frames exceed 3 deg, most often the left forearm (3): target reached"
    )
    assert not replace(sign, allowed=0.0).reached
    assert set(sign.missing_by_limb) == set(SCORED)
    everything = good_enough(np.full((7, 6), 1.0), 3.0)
    assert everything.words() == "all 7 frames are within 3 deg: target reached"
    assert not good_enough(np.empty((0, 6)), 3.0).reached
    unknown = good_enough(np.full((4, 6), np.nan), 3.0)
    assert (unknown.frames_missing, unknown.reached) == (4, False)
    few = np.full((100, 6), 120.0)
    few[:2], few[2:4] = 2.0, 20.0
    assert good_enough(few, 3.0, clicked=2).words() == (
        "2 of 100 frames are within 3 deg, 2 less certain, 96 have unknown limbs, too far from a "
        "click: 2 frames clicked so far"
    )


def test_a_hand_behind_the_back_is_hidden_from_the_front():
    body, hand = body_model(AVERAGE), NINE.names.index("left_hand")
    nine = NINE.places(body, body.frames(hanging_pose(np.array([0.0, 0, 0.95]))))
    nine[hand] = [0.0, -0.25, 1.15]
    places = np.array([[0.0, 3, 1.2], [0, -3, 1.2]])
    hidden = hidden_landmarks(nine[None], NINE.names, nine[None], places)
    assert hidden[0, :, hand].tolist() == [True, False]


def test_doubts_have_kinds_and_near_ones_of_a_kind_come_last():
    points = bodies(40)
    clicks = {click.key: click for click in clicks_of(points, RIG)}
    skipped = ClickKey(20, "S", "left_elbow")
    del clicks[skipped]
    swapped = [ClickKey(frame, "N", f"{side}_hand") for frame in (5, 7, 30) for side in SIDES]
    for left, right in zip(swapped[::2], swapped[1::2], strict=True):
        places = clicks[left].position, clicks[right].position
        clicks[right], clicks[left] = (
            replace(clicks[key], position=place)
            for key, place in zip((right, left), places, strict=True)
        )
    far = ClickKey(12, "O", "right_hand")
    residuals = {far: np.array([0.0, 40.0]), **dict.fromkeys(swapped, np.array([7.0, 0.0]))}
    fit = fit_of(points, range(40), residuals=residuals, outliers={far: 0.9})
    ranking = NextClicks(RIG, NINE, fit, clicks.values())
    beside, alone = ClickKey(13, "O", "right_hand"), ClickKey(12, "W", "head")
    ranking.add({key: Doubt(0.7, 3.0, "elsewhere", "appearance") for key in (beside, alone, far)})
    found = {one.key: one for one in ranking.best(Wish(500)) if one.kind != "free"}
    kinds = {key: one.kind for key, one in found.items()}
    expected = {skipped: "skipped", far: "place", alone: "appearance"}
    assert kinds == {**expected, **dict.fromkeys(swapped, "swapped")}
    assert not found[skipped].click_there
    frames = [key.frame for key, kind in kinds.items() if kind == "swapped"]
    assert sorted(frames[:2]) in ([5, 30], [7, 30]), "five frames apart, then the others"
    ranking.update(12, [one for one in clicks.values() if one.frame == 12])
    assert not {far, alone} & {one.key for one in ranking.best(Wish(500)) if one.click_there}


def test_nothing_is_skipped_in_a_frame_with_a_few_clicks():
    points = bodies(40)
    few = {("N", "left_hand"), ("S", "head"), ("S", "left_elbow")}
    clicks = [
        one
        for one in clicks_of(points, RIG)
        if one.frame % 10 == 0 or (one.frame == 15 and (one.camera, one.landmark) in few)
    ]
    found = NextClicks(RIG, NINE, fit_of(points, range(0, 40, 10)), clicks).best(Wish(500))
    assert "skipped" not in {one.kind for one in found}


def test_a_camera_that_disagrees_is_a_doubt_of_its_own():
    points = bodies(40)
    clicks = one_camera_off(clicks_of(points, RIG), "S", (25.0, 10.0))
    residuals = {one.key: np.array([25.0, 10.0]) for one in clicks if one.camera == "S"}
    fit = fit_of(points, range(40), residuals=residuals)
    found = [one for one in NextClicks(RIG, NINE, fit, clicks).best(Wish(500)) if one.click_there]
    assert [one.kind for one in found] == ["camera"]
    assert found[0].reason.startswith("S disagrees with the other three by 27 px")
