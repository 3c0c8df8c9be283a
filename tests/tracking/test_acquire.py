"""Bodies are found without help, whichever way they face, and told from what is not theirs."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.manifold import difference
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.posing import TRUNK
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking import step
from stereotrack_core.tracking.initialise.first_pose import facing_right, first_pose_in
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.model import initialiser as looking
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from tests.tracking.running import Stepping
from tests.tracking.scenes import (
    CAMERAS,
    POSES,
    angle_errors,
    axis_off,
    cloud_of,
    clouds_of,
    surface_points,
    turned,
)


@pytest.fixture
def initialiser(make_tracker):
    body = make_tracker("manifold").setup.body
    volume = Volume.of(DepthParameters())
    setup = Setup(body, preset("fast").tracking, CAMERAS, 10.0, 0, volume)
    return Stepping(looking(setup))


def stepped(initialiser, true, rng, frames=range(3)):
    """The last estimate of some frames of a still body."""
    for frame, cloud in zip(frames, clouds_of(initialiser.setup.body, true, rng, 3), strict=True):
        found = initialiser.step(replace(cloud, frame=frame))
    return found


@pytest.mark.parametrize(("name", "heading"), [("t", 75.0), ("reaching", 200.0)])
def test_a_body_is_found_in_any_heading_anywhere(initialiser, rng, name, heading):
    true = turned(POSES[name], heading, (0.4, -0.5, 0.0))
    found = stepped(initialiser, true, rng)
    assert found.tracked
    assert np.linalg.norm(found.pose.position - true.position) < 0.06
    assert axis_off(found.pose, true) < 12.0


def test_arms_that_reach_to_the_front_tell_where_the_front_is(initialiser, rng):
    true = turned(POSES["reaching"], 140.0)
    found = stepped(initialiser, true, rng)
    assert angle_errors(initialiser.setup.body, found.pose, true).max() < 15.0


def test_somebody_else_in_the_volume_does_not_draw_the_body(initialiser, rng):
    true = POSES["reaching"]
    alone = surface_points(initialiser.setup.body, true, 2000, rng, 0.005)
    other = surface_points(
        initialiser.setup.body, turned(POSES["t"], 90.0, (1.5, 0.3, 0.0)), 2500, rng
    )
    initialiser.start(true)
    for frame in range(3):
        found = initialiser.step(cloud_of(np.concatenate([alone, other]), frame))
        assert found.tracked
    assert angle_errors(initialiser.setup.body, found.pose, true).max() < 5.0
    assert np.linalg.norm(found.pose.position - true.position) < 0.02


def test_a_body_that_a_side_of_the_volume_cuts_is_not_tracked(initialiser, rng):
    true = turned(POSES["reaching"], 0.0, (1.78, 0.0, 0.0))
    points = surface_points(initialiser.setup.body, true, 4000, rng, 0.005)
    inside = cloud_of(points[points[:, 0] < 1.8])
    found = initialiser.step(inside)
    assert not found.tracked
    assert "volume" in found.reason or "too little of the body" in found.reason


def test_who_comes_back_elsewhere_is_found_again(initialiser, rng):
    initialiser.start(POSES["t"])
    assert initialiser.step(*clouds_of(initialiser.setup.body, POSES["t"], rng, 1)).tracked
    assert not initialiser.step(cloud_of(np.empty((0, 3)), 1)).tracked
    true = turned(POSES["reaching"], 100.0, (-0.8, 0.6, 0.0))
    found = stepped(initialiser, true, rng, range(2, 5))
    assert found.tracked
    assert np.linalg.norm(found.pose.position - true.position) < 0.06
    assert axis_off(found.pose, true) < 12.0


def test_the_first_pose_is_that_of_the_first_cloud(initialiser, rng):
    poses = [turned(POSES["reaching"], 100.0, (0.0, 0.03 * k, 0.0)) for k in range(4)]
    clouds = [
        cloud_of(surface_points(initialiser.setup.body, pose, 2000, rng, 0.005), k)
        for k, pose in enumerate(poses)
    ]
    shares = []
    found = first_pose_in(
        initialiser.model, clouds, lambda done, count: shares.append(done / count)
    )
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert 0.5 < shares[-1] < 1.0
    assert found is not None
    assert np.abs(difference(found, poses[0], initialiser.setup.joints)[:3]).max() < 0.03
    assert first_pose_in(initialiser.model, [cloud_of(np.empty((0, 3)))]) is None


@pytest.mark.parametrize(("views", "at_once"), [(("N", "S"), True), (("N",), False)])
def test_the_usual_first_pose_is_recognised_in_the_first_cloud_of_several_views(
    initialiser, rng, views, at_once
):
    told = []
    made = clouds_of(initialiser.setup.body, POSES["t"], rng, 4)
    clouds = [replace(cloud, view_names=views) for cloud in made]
    found = first_pose_in(initialiser.model, clouds, lambda done, _count: told.append(done))
    assert (told == [0, 1]) == at_once, "found, and followed from the usual one"
    assert axis_off(found, POSES["t"]) < 12.0


@pytest.mark.parametrize(("name", "heading"), [("reaching", 180.0), ("t", 90.0)])
def test_another_first_pose_is_not_taken_for_the_usual(initialiser, rng, name, heading):
    true = turned(POSES[name], heading)
    found = first_pose_in(initialiser.model, clouds_of(initialiser.setup.body, true, rng, 4))
    assert found is not None
    assert axis_off(found, true) < 12.0
    if name == "reaching":
        assert angle_between(found.torso[:, 0], true.torso[:, 0]) < np.radians(30.0)


@pytest.mark.parametrize("heading", [130.0])
def test_a_body_taken_from_the_wrong_side_is_turned(initialiser, rng, heading):
    true = turned(POSES["reaching"], heading)
    clouds = clouds_of(initialiser.setup.body, true, rng, 2)
    for start in (true, turned_round(true)):
        found = facing_right(initialiser.model, start, clouds, lambda: None)
        assert angle_between(found.torso[:, 1], true.torso[:, 1]) < np.radians(30.0)


@pytest.mark.parametrize(
    ("unchanged", "cut", "partial"),
    [(0, 0.006, False), (0, 0.008, True), (12, 0.034, False), (12, 0.036, True)],
)
def test_less_of_a_half_seen_body_may_be_cut_while_its_pose_is_on_trial(
    initialiser, monkeypatch, unchanged, cut, partial
):
    monkeypatch.setattr(step, "trunk_support", lambda *_: 0.8)
    monkeypatch.setattr(step, "share_at_sides", lambda *_: cut)
    state = replace(initialiser.model.first(POSES["t"]), unchanged=unchanged)
    assert bool(initialiser.model._why_partial(state, cloud_of(np.zeros((1, 3))))) == partial


@pytest.mark.parametrize(
    ("unconfirmed", "inside", "partial"), [(1, 0.05, True), (1, 0.15, False), (0, 0.05, False)]
)
def test_a_body_that_came_back_is_partial_while_its_trunk_is_at_a_side_of_the_volume(
    initialiser, monkeypatch, unconfirmed, inside, partial
):
    places = landmarks(initialiser.setup.body, POSES["t"])
    trunk = places[[LANDMARKS.index(name) for name in TRUNK], 0].max()
    aside = initialiser.setup.volume.high[0] - inside - trunk
    at_side = turned(POSES["t"], 0.0, (aside, 0.0, 0.0))
    monkeypatch.setattr(step, "trunk_support", lambda *_: 0.8)
    monkeypatch.setattr(step, "share_at_sides", lambda *_: 0.0)
    state = replace(initialiser.model.first(at_side), unconfirmed=unconfirmed)
    assert bool(initialiser.model._why_partial(state, cloud_of(np.zeros((1, 3))))) == partial
