"""A whole trajectory: filled between clicked frames, never across a gap, honest everywhere."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED
from stereotrack_core.annotation.fit.state import FitSettings, Freedom, shift_sigmas
from stereotrack_core.annotation.landmark_set import NINE
from tests.annotation.fit.scenes import BODY, CAMERAS, clicked, clicks_on, fitting, places, pose
from tests.annotation.scenes import moved_click
from tests.tracking.scenes import cloud_of, pose_with_arms, surface_points

TRUTH = np.array([places(k) for k in range(24)])


def every(step, count=24, sigma=2.0, seed=0):
    rng = np.random.default_rng(seed)
    return {k: clicked(k, rng, sigma) for k in range(0, count, step)}


@pytest.fixture(scope="module")
def third():
    return fitting().trajectory(every(3), range(24))


def test_frames_between_are_filled_and_say_so(third):
    assert third.frame.tolist() == list(range(24))
    assert set(third.kind[::3]) == {CLICKED}
    assert set(np.delete(third.kind, np.s_[::3])) == {INTERPOLATED}
    off = np.linalg.norm(third.landmarks - TRUTH, axis=2)
    assert off[::3].mean() < 0.012
    assert off.mean() < 0.02


def test_the_uncertainty_grows_away_from_clicks_and_holds(third):
    sigma = np.sqrt(np.trace(third.covariance, axis1=2, axis2=3))
    assert (sigma[1:22:3].mean(axis=0) > sigma[0:21:3].mean(axis=0)).all()
    z = (third.landmarks - TRUTH) / np.sqrt(np.diagonal(third.covariance, axis1=2, axis2=3))
    assert np.mean(np.abs(z) < 1.96) > 0.88
    assert third.limb_sigma_deg.shape == (24, 6)
    assert np.isfinite(third.limb_sigma_deg).all()


def test_residuals_belong_to_their_clicks(third):
    assert len(third.residual_px) == 8 * 36
    key = ClickKey(3, "N", "head")
    assert np.linalg.norm(third.residual_px[key]) < 12
    assert third.outlier_probability[key] < 0.5
    assert 0.7 < third.sigma_factor < 1.3


def test_nothing_is_filled_across_a_flagged_gap():
    found = fitting().trajectory(every(4), range(24), gaps=[range(9, 12)])
    assert set(found.kind[9:12]) == {GAP}
    assert np.isnan(found.landmarks[9:12]).all()
    assert np.isnan(found.limb_sigma_deg[9:12]).all()
    assert np.isfinite(found.landmarks[np.r_[0:9, 12:24]]).all()
    alone = fitting().trajectory({k: c for k, c in every(4).items() if k < 9}, range(9))
    np.testing.assert_allclose(found.landmarks[:9], alone.landmarks, atol=1e-9)


def test_frames_far_from_every_click_are_not_filled():
    found = fitting().trajectory({0: every(1)[0]}, range(24))
    assert found.kind.tolist() == [CLICKED, *[INTERPOLATED] * 20, *[GAP] * 3]


def test_outliers_are_flagged_and_good_clicks_are_not():
    rng, clicks = np.random.default_rng(1), every(1)
    wrong = set()
    for frame, own in clicks.items():
        own = list(own)
        for i in np.flatnonzero(rng.random(len(own)) < 0.03):
            angle, away = rng.uniform(0, 2 * np.pi), rng.uniform(30, 100)
            own[i] = moved_click(own[i], away * np.array([np.cos(angle), np.sin(angle)]))
            wrong.add(own[i].key)
        clicks[frame] = tuple(own)
    found = fitting().trajectory(clicks, range(24))
    flagged = set(found.flagged())
    assert len(flagged & wrong) >= 0.9 * len(wrong)
    assert len(flagged - wrong) <= 0.02 * (24 * 36)
    assert np.linalg.norm(found.landmarks - TRUTH, axis=2).mean() < 0.012


def test_an_arm_clicked_in_one_camera_is_put_on_the_right_side():
    rng, clicks = np.random.default_rng(2), {}
    for k in range(12):
        own = clicked(k, rng)
        if 3 <= k < 9:
            own = tuple(c for c in own if c.landmark != "left_hand" or c.camera == "N")
        clicks[k] = own
    found = fitting().trajectory(clicks, range(12))
    hand = NINE.names.index("left_hand")
    assert np.linalg.norm(found.landmarks[:, hand] - TRUTH[:12, hand], axis=1).max() < 0.1


def test_depth_tells_what_happens_between_clicked_frames():
    rng = np.random.default_rng(3)
    clouds = {
        k: cloud_of(surface_points(BODY, pose(k), 1500, rng, noise=0.005), k) for k in range(13)
    }
    asked = []

    def cloud(frame):
        asked.append(frame)
        return clouds[frame]

    clicks = every(12, 13)
    told = []
    found = fitting().trajectory(clicks, range(13), clouds=cloud, on_frame=told.append)
    alone = fitting().trajectory(clicks, range(13))
    assert asked == told == list(range(13))
    off = np.linalg.norm(found.landmarks - TRUTH[:13], axis=2)
    assert off.mean() < 0.5 * np.linalg.norm(alone.landmarks - TRUTH[:13], axis=2).mean()
    assert off.mean() < 0.025


def crossing(k: int):
    """Arms apart until frame 2, crossed from frame 4 on."""
    t = np.clip(0.5 * (k - 2), 0.0, 1.0)
    apart = [1, 0.3, 0], [1, 0.3, 0.2], [-1, 0.3, 0], [-1, 0.3, 0.2]
    crossed = [0.35, 1, -0.35], [-0.9, 0.45, 0.15], [-0.35, 1, -0.35], [0.9, 0.45, -0.1]
    return pose_with_arms(*((1.0 - t) * np.array(apart) + t * np.array(crossed)))


@pytest.mark.parametrize("order", [range(17), range(17)[::-1]], ids=["crossing", "opening"])
def test_arms_that_cross_between_clicked_frames_are_found_from_both_sides(order):
    rng, poses = np.random.default_rng(0), [crossing(k) for k in order]
    truth = np.array([NINE.places(BODY, BODY.frames(pose)) for pose in poses])
    clouds = [cloud_of(surface_points(BODY, pose, 1200, rng, noise=0.005)) for pose in poses]
    clicks = {k: clicks_on(k, truth[k], rng, 1.0) for k in (0, 16)}
    found = fitting().trajectory(clicks, range(17), clouds=clouds.__getitem__)
    hands = [NINE.names.index(name) for name in ("left_hand", "right_hand")]
    off = np.linalg.norm(found.landmarks - truth, axis=2)[:, hands]
    assert off.max() < 0.05  # 0.13 and 0.12 where the nearer clicked frame alone says which way


def test_arms_are_measured_worse_along_than_across():
    freedom = Freedom(NINE, BODY, with_depth=True)
    sigma = shift_sigmas(freedom, FitSettings())[freedom.of_biases.start - freedom.of_pose :]
    arms = sigma.reshape(-1, 6)[2:]
    assert (arms[:, 2] > 2.0 * arms[:, :2].max(axis=1)).all()


def test_what_the_cameras_state_of_themselves_is_in_the_uncertainty():
    doubtful = {name: replace(one, place_sigma=0.06) for name, one in CAMERAS.items()}
    sure, unsure = (fitting(rig).trajectory(every(2, 3), range(3)) for rig in (CAMERAS, doubtful))
    np.testing.assert_array_equal(sure.landmarks, unsure.landmarks)
    added = np.broadcast_to(0.06**2 / 3.0 / len(CAMERAS) * np.eye(3), (3, 9, 3, 3))
    np.testing.assert_allclose(unsure.covariance - sure.covariance, added, atol=1e-12)


def test_frames_need_not_begin_at_the_recording_s_first():
    clicks = {k: c for k, c in every(3).items() if k >= 9}
    found = fitting().trajectory(clicks, range(9, 24))
    assert found.frame.tolist() == list(range(9, 24))
    assert np.linalg.norm(found.landmarks - TRUTH[9:], axis=2).mean() < 0.02
