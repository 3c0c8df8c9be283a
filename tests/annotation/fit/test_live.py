"""One frame fitted by itself: near the truth, honest about what it does not know."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import ACCEPTED, measurements
from stereotrack_core.annotation.fit.results import PROBABLE
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel
from tests.annotation.fit.scenes import BODY, CAMERAS, clicked, fitting, places, pose
from tests.annotation.scenes import cameras, moved_click
from tests.tracking.scenes import cloud_of, surface_points


def off(fit, k=0):
    return np.linalg.norm(fit.landmarks_world - places(k), axis=1)


@pytest.mark.parametrize("lens", ["barrel", "fisheye"])
def test_exact_clicks_give_the_pose(lens):
    rig = cameras(lens)
    fit = fitting(rig).frame(clicked(0, np.random.default_rng(0), sigma=0.05, rig=rig))
    assert off(fit).max() < 1e-3
    assert np.abs(fit.residual_px).max() < 0.5
    assert (fit.outlier_probability < 0.1).all()
    assert fit.words == ()


def test_the_fit_is_better_than_its_clicks_and_knows_how_good():
    rng, fit = np.random.default_rng(1), fitting()
    z = []
    for k in range(12):
        found = fit.frame(clicked(k, rng, sigma=4.0))
        sigma = np.sqrt(np.diagonal(found.landmark_covariance, axis1=1, axis2=2))
        z.append((found.landmarks_world - places(k)) / sigma)
    assert 0.88 < np.mean(np.abs(z) < 1.96) <= 1.0
    assert 0.6 < np.sqrt(np.mean(np.square(z))) < 1.2


def test_an_outlier_is_named_and_does_not_pull():
    clicks = list(clicked(0, np.random.default_rng(2)))
    wrong = 11  # the right shoulder in the second camera
    clicks[wrong] = moved_click(clicks[wrong], [45.0, 20.0])
    fit = fitting().frame(clicks)
    assert np.flatnonzero(fit.outlier_probability > PROBABLE).tolist() == [wrong]
    assert off(fit).max() < 0.03
    landmark = clicks[wrong].landmark
    assert f"{landmark.replace('_', ' ')} in {clicks[wrong].camera}" in fit.words[0]
    assert "outlier" in fit.words[0]


def test_a_click_of_a_person_beats_what_was_accepted_in_the_other_images():
    rng, elbow = np.random.default_rng(5), NINE.names.index("right_elbow")
    clicks = [replace(one, sigma=None) for one in clicked(0, rng)]
    wrong = places(0)[elbow] + [0.12, -0.06, 0.08]
    for i, one in enumerate(clicks):
        if one.landmark == "right_elbow" and one.camera != "N":
            there = tuple(CAMERAS[one.camera].project(wrong))
            clicks[i] = replace(one, position=there, origin=ACCEPTED)
    fit = fitting().frame(measurements(clicks, NINE.names))
    own = next(i for i, c in enumerate(clicks) if (c.landmark, c.camera) == ("right_elbow", "N"))
    assert fit.outlier_probability[own] < PROBABLE
    missed = CAMERAS["N"].project(fit.landmarks_world[elbow]) - clicks[own].position
    assert np.linalg.norm(missed) < 6.0


def test_a_lone_camera_leaves_the_distance_open_and_says_so():
    k = 10  # the left arm is stretched out sideways, across the view of N
    clicks = list(clicked(k, np.random.default_rng(3), names=NINE.names[:2] + NINE.names[6:]))
    clicks += clicked(k, np.random.default_rng(3), seen_by=("N",), names=("left_elbow",))
    fit = fitting().frame(clicks)
    elbow = NINE.names.index("left_elbow")
    _, vectors = np.linalg.eigh(fit.landmark_covariance[elbow])
    ray = places(k)[elbow] - CAMERAS["N"].position_world
    assert abs(vectors[:, -1] @ ray) / np.linalg.norm(ray) > 0.8
    said = [line for line in fit.words if line.startswith("left elbow")]
    assert "along the view of N" in said[0]
    assert "seen by one camera" in said[0]


def test_few_clicks_and_none_give_the_usual_pose_without_certainty():
    fit = fitting()
    for clicks in ((), clicked(0, np.random.default_rng(4), seen_by=("N",), names=("head",))):
        found = fit.frame(clicks)
        assert np.isfinite(found.landmarks_world).all()
        assert (found.limb_sigma_deg > 30).all()
        assert (found.outlier_probability < 0.05).all()
        assert any("not clicked in any camera" in line for line in found.words)
        assert found.limb_sigma_deg.shape == (len(LIMBS),)


@pytest.mark.parametrize("turn", [0.0, 2.0, 4.0])
def test_the_person_may_face_anywhere(turn):
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    clicks = [
        moved_click(
            one, CAMERAS[one.camera].project(R @ point) - CAMERAS[one.camera].project(point)
        )
        for one in clicked(0, np.random.default_rng(5))
        for point in [places(0)[NINE.names.index(one.landmark)]]
    ]
    found = fitting().frame(clicks)
    assert np.linalg.norm(found.landmarks_world - places(0) @ R.T, axis=1).max() < 0.04


def test_measured_points_place_what_is_not_clicked():
    rng = np.random.default_rng(6)
    names = [name for name in NINE.names if not name.endswith("hand")]
    clicks = clicked(0, rng, names=names)
    cloud = cloud_of(surface_points(BODY, pose(0), 3000, rng, noise=0.005))
    without = fitting().frame(clicks, cloud=cloud)
    again = fitting(use_depth=False).frame(clicks, cloud=cloud)
    assert off(without).max() < 0.05
    assert off(again).max() > 0.08
    assert (without.limb_sigma_deg[2:] < again.limb_sigma_deg[2:]).all()


@pytest.mark.parametrize("deep", [False, True])
@pytest.mark.parametrize("count", [3, 14, 36])
def test_a_frame_is_fitted_while_somebody_clicks(count, deep, monkeypatch):
    """Half a millisecond for each look at the body leaves less than a tenth of a second."""
    rng, fit, looks, frames = np.random.default_rng(8), fitting(), [], BodyModel.frames
    every = clicked(0, rng)
    clicks = [every[i] for i in rng.permutation(len(every))[:count]]
    cloud = cloud_of(surface_points(BODY, pose(0), 3000, rng, noise=0.005)) if deep else None
    monkeypatch.setattr(
        BodyModel, "frames", lambda body, pose: looks.append(pose) or frames(body, pose)
    )
    fit.frame(clicks, cloud=cloud)
    assert 10 < len(looks) < 170


NO_TRUNK = ("left_elbow", "right_elbow", "left_hand", "right_hand", "head")


@pytest.mark.parametrize("k", [0, 5, 11])
def test_clicks_without_a_trunk_are_met_all_the_same(k):
    clicks = clicked(k, np.random.default_rng(k), names=NO_TRUNK)
    found = fitting().frame(clicks)
    assert np.median(np.linalg.norm(found.residual_px, axis=1)) < 4.0
    assert (found.outlier_probability < 0.5).all()


@pytest.mark.parametrize("k", [0, 5, 11])
def test_rough_clicks_are_rough_and_no_outliers(k):
    rng = np.random.default_rng(k)
    rough = [moved_click(one, rng.normal(0.0, 12.0, 2)) for one in clicked(k, rng)]
    found = fitting().frame(rough)
    assert (found.outlier_probability < 0.5).mean() > 0.9
    assert 3.0 < found.sigma_factor < 10.0
    assert f"{found.sigma_factor:.1f} times" in found.words[0]
    assert np.median(np.linalg.norm(found.residual_px, axis=1)) < 1.5 * 12.0
    assert np.linalg.norm(found.landmarks_world - places(k), axis=1).mean() < 0.1
