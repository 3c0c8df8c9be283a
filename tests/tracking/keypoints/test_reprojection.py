"""Keypoints of a 2-D detector as measurements of the pose."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.manifold import difference
from stereotrack_core.body.model import landmarks
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, sighted
from stereotrack_core.tracking.keypoint_step import pose_of_keypoints
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation, pinhole
from tests.tracking.keypoints.cases import BODY, VIEWS
from tests.tracking.scenes import POSES, disturbed


def predictions(pose, off=None, body=BODY, names=COCO_17) -> list:
    """Rows of keypoints in all views, moved by `off` at (view, keypoint)."""
    places, frames, rows = keypoint_places(body), body.frames(pose), []
    for name in (name for name in names if name in places):
        place = places[name]
        world = frames.apply(np.array([place.part]), place.point[None])[0]
        for view, camera in VIEWS.items():
            moved = camera.project(world) + (off or {}).get((view, name), 0.0)
            rows.append((0, view, name, *moved, 0.9, "x", 0))
    return rows


def seen(pose, off=None) -> SightedKeypoints:
    return sighted(keypoints_of(predictions(pose, off)), VIEWS)


def at(keypoints: SightedKeypoints, name: str, view: str) -> tuple[int, int]:
    return keypoints.names.index(name), keypoints.cameras.index(view)


@pytest.mark.parametrize("names", [("shoulder", "elbow", "wrist", "hip"), ("elbow", "wrist")])
def test_exchanged_sides_are_recognised_in_their_picture(names):
    rows = []
    for frame, view, name, *rest in predictions(POSES["pointing"]):
        side, _, joint = name.partition("_")
        if view == "O" and joint in names:
            side = "right" if side == "left" else "left"
            name = f"{side}_{joint}"
        rows.append((frame, view, name, *rest))
    wrong, right = sighted(keypoints_of(rows), VIEWS), seen(POSES["pointing"])
    fit = KeypointObservation(wrong, 0.03).fitted(BODY, POSES["pointing"])
    for side in ("left", "right"):
        for joint in names:
            k = at(right, f"{side}_{joint}", "O")
            np.testing.assert_allclose(fit.seen.pixel[k], right.pixel[k])


def test_a_pose_comes_of_keypoints_alone_and_faces_the_right_way():
    for pose in POSES.values():
        found = pose_of_keypoints(seen(pose), BODY)
        assert np.degrees(np.abs(difference(found, pose, (2, 3, 4, 5))[3:])).max() < 6.0
        apart = np.linalg.norm(landmarks(BODY, found) - landmarks(BODY, pose), axis=1)
        assert apart.max() < 0.05


def test_rays_that_diverge_meet_nowhere():
    left, aside = VIEWS["N"], VIEWS["N"].camera_from_world
    aside = replace(aside, translation=aside.translation - [0.2, 0.0, 0.0])
    pair, middle = {"L": left, "R": replace(left, camera_from_world=aside)}, left.matrix[:2, 2]
    for inwards, met in ((8.0, True), (-8.0, False)):
        places = [("L", middle + [inwards, 0.0]), ("R", middle - [inwards, 0.0])]
        rows = [(0, name, "head", *place, 0.9, "x", 0) for name, place in places]
        found = sighted(keypoints_of(rows), pair).meeting(0.1)
        assert np.isfinite(found.world).all() == found.agreed.all() == met


@pytest.mark.parametrize("missing", ["left_shoulder", "right_shoulder", "left_hip", "right_hip"])
def test_a_joint_of_the_trunk_that_nobody_sees_is_opposite_to_its_other_side(missing):
    rows = [row for row in predictions(POSES["t"]) if row[2] != missing]
    found = pose_of_keypoints(sighted(keypoints_of(rows), VIEWS), BODY)
    away = landmarks(BODY, found) - landmarks(BODY, POSES["t"])
    assert np.linalg.norm(away, axis=1).max() < 0.05


@pytest.mark.parametrize("known", [True, False], ids=["as in the last pose", "hanging"])
def test_an_arm_that_nobody_sees_is_taken_from_the_last_pose_or_hangs(known):
    away = ("left_elbow", "left_wrist", "left_hand")
    rows = [row for row in predictions(POSES["t"]) if row[2] not in away]
    last = POSES["reaching"] if known else None
    found = pose_of_keypoints(sighted(keypoints_of(rows), VIEWS), BODY, last)
    arm = [LANDMARKS.index(f"left_{name}") for name in ("shoulder", "elbow", "hand")]
    limbs = np.diff(landmarks(BODY, found)[arm], axis=0)
    if known:
        assert np.allclose(limbs, np.diff(landmarks(BODY, last)[arm], axis=0), atol=0.03)
    else:
        assert (limbs[:, 2] < -0.95 * np.linalg.norm(limbs, axis=1)).all()


def _noisy(pose, rng):
    """Keypoints some of which are far off, in a picture exchanged, unsure or missing."""
    every = product("NOSW", seen(pose).names)
    shown = seen(pose, {at: rng.normal(0.0, rng.choice([1.0, 12.0, 60.0]), 2) for at in every})
    sure = rng.uniform(0.05, 1.0, shown.confidence.shape)
    sure *= rng.random(sure.shape) < 0.9
    if rng.random() < 0.5:
        sure[:, 1:] = 0.0
    pixel = np.where(sure[..., None] > 0.0, shown.pixel, np.nan)
    swap = np.zeros(sure.shape, dtype=bool)
    arms = [n.split("_")[-1] in ("elbow", "wrist") for n in shown.names]
    swap[:, 1] = rng.random() < 0.5
    swap[:, 2] = np.array(arms) & (rng.random() < 0.5)
    shown = replace(shown, pixel=pixel, confidence=sure, crossed=bool(rng.random() < 0.5))
    return shown.with_sides_exchanged(swap)


def _exchanged(shown, predicted, metre, arm, follows):
    """Where sides are exchanged, picture by picture."""
    there = np.isfinite(shown.pixel).all(axis=2)
    other = shown.other_side
    pairs = (other != np.arange(len(other)))[:, None] & (there | there[other])
    result = np.zeros(there.shape, dtype=bool)
    alone = follows and pairs.any(axis=0).sum() == 1

    def cost(k, v, own):
        off = np.linalg.norm(shown.pixel[own, v] - predicted[k, v]) / metre[k, v]
        return min(off / 0.25, 1.0) ** 2 if np.isfinite(off) else 1.0

    for group in (np.ones(len(arm), dtype=bool), arm):
        better = {}
        for v in range(there.shape[1]):
            judged = [k for k in np.flatnonzero(pairs[:, v] & group) if not (alone and arm[k])]
            gain = 0.0
            for k in judged:
                own, opposite = (other[k], k) if result[k, v] else (k, other[k])
                gain += cost(k, v, own) - cost(k, v, opposite)
            better[v] = gain > 0.2 * max(len(judged), 1), len(judged)
        wrong, asked = np.array(list(better.values())).T
        if alone or 2 * wrong.sum() <= np.count_nonzero(asked):
            for v, (wrong, _) in better.items():
                result[:, v] ^= pairs[:, v] & group & wrong
    return result


@pytest.mark.parametrize("seed", range(15))
def test_keypoints_are_weighed_as_plainly_stated(seed):
    rng, pose = np.random.default_rng(seed), POSES[sorted(POSES)[seed % 3]]
    near, sigma, follows = disturbed(pose, (2, 3, 4, 5), rng), 0.04, bool(seed % 2)
    shown = _noisy(pose, rng)
    fit = KeypointObservation(shown, sigma).fitted(BODY, near, follows=follows)
    names, frames, places = fit.seen.names, BODY.frames(near), keypoint_places(BODY)
    kept = [shown.names.index(name) for name in names]
    local = [(places[n].part, places[n].point, places[n].slack) for n in names]
    world = np.array([frames.apply(np.array([p]), at[None])[0] for p, at, _ in local])
    arm = np.array([n.split("_")[-1] in ("elbow", "wrist", "hand") for n in names])
    cameras = [VIEWS[name] for name in shown.cameras]
    depth = np.array([[c.camera_from_world.apply(at)[2] for c in cameras] for at in world])
    metre = np.array([c.matrix[0, 0] for c in cameras]) / depth
    predicted = np.array([[c.project(at) - c.matrix[:2, 2] for c in cameras] for at in world])
    np.testing.assert_allclose(fit.predicted, predicted, atol=1e-6)
    np.testing.assert_allclose(fit.metre, metre)
    part = shown.part(np.isin(np.arange(len(shown.names)), kept))
    swapped = _exchanged(part, predicted, metre, arm, follows)
    used = part.with_sides_exchanged(swapped)
    np.testing.assert_array_equal(fit.seen.pixel, used.pixel)
    off = np.linalg.norm(used.pixel - predicted, axis=2) / metre
    settled = fit.meeting.settled[:, None]
    scale = np.where(settled, 0.4, 0.25)
    sure = np.where(arm[:, None] & ~settled & shown.crossed, 0.0, used.confidence)
    counts = (sure > 0.0) & (fit.meeting.agreed | ~settled)
    weight = np.where(counts, (1 + (off / scale) ** 2) ** -2, 0.0)
    np.testing.assert_allclose(fit.weight, np.nan_to_num(weight), atol=1e-9)
    known = np.isfinite(off) & (fit.meeting.agreed | ~settled)
    cost = off[known] ** 2 / (0.25**2 + off[known] ** 2)
    assert fit.cost() == pytest.approx(np.average(cost, weights=used.confidence[known]))
    assert fit.independence == pytest.approx(min(used.confidence.any(axis=0).sum(), 3) / 3)
    k, v = np.nonzero(fit.weight > 1e-3)
    [residual] = KeypointObservation(shown, sigma).fitted(BODY, near, follows=follows).residuals()
    deviation = sigma / np.clip(used.confidence[k, v], 0.2, 1.0)
    slack = np.array([one for *_, one in local])[k]
    variance = ((deviation**2 + slack**2) * metre[k, v] ** 2 + 4.0) / fit.weight[k, v]
    np.testing.assert_allclose(residual.variance, np.repeat(variance, 2))
    np.testing.assert_array_equal(residual.measured, used.pixel[k, v].ravel())
    step, rows = 1e-6, residual.rows(frames)
    for i, row in enumerate(rows):
        camera = cameras[v[i // 2]]
        moved = [camera.project(row["point"] + way * step)[i % 2] for way in np.eye(3)]
        slope = (np.array(moved) - camera.project(row["point"])[i % 2]) / step
        np.testing.assert_allclose(row["direction"], slope, rtol=1e-3, atol=1e-3)
        at = predicted[k[i // 2], v[i // 2]][i % 2]
        assert row["innovation"] == pytest.approx(residual.measured[i] - at)


def test_nothing_is_projected_that_is_within_5_cm_of_a_camera():
    for z, seen_there in ((0.049, False), (0.051, True), (-1.0, False)):
        assert np.isfinite(pinhole(np.array([0.0, 0.0, z]), 100.0)).all() == seen_there
