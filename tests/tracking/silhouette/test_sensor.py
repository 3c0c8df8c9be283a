"""Outlines of the model against silhouettes that are cast ray by ray from the same cones."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_FOREARM
from stereotrack_core.tracking.residuals.silhouette import (
    SilhouetteObservation,
    contours_of,
    edge_maps,
)
from tests.tracking.scenes import POSES, moved, pose_with_arms
from tests.tracking.views import FOCAL, cloud_of_body, cloud_seen

BODY = body_model(AVERAGE)
SIGMA = 0.02
PIXEL = 3.0 / FOCAL
"""Metres that a pixel shows at the body."""


@pytest.fixture(scope="module")
def clouds():
    return {name: cloud_of_body(BODY, pose) for name, pose in POSES.items()}


@pytest.fixture(scope="module")
def edges(clouds):
    return {name: edge_maps(cloud) for name, cloud in clouds.items()}


def _outlines(edges, pose):
    return contours_of(edges, BODY, BODY.frames(pose))


@pytest.mark.parametrize("name", POSES)
def test_at_the_true_pose_outlines_lie_on_the_edges(edges, name):
    found = _outlines(edges[name], POSES[name])
    assert len(found.distance) > 150
    assert abs(np.median(found.distance)) < 0.3 * PIXEL
    assert np.median(abs(found.distance)) < 0.6 * PIXEL
    assert np.quantile(abs(found.distance), 0.9) < 1.5 * PIXEL


@given(
    angle=st.floats(0.0, 2.0 * np.pi),
    length=st.floats(0.01, 0.03),
    name=st.sampled_from(sorted(POSES)),
)
@settings(max_examples=30)
def test_a_shift_is_seen_along_the_directions(edges, angle, length, name):
    """Who stands aside by b is b . n away from every edge: outside one side, inside the other."""
    by = length * np.array([np.cos(angle), np.sin(angle), 0.0])
    found = _outlines(edges[name], moved(POSES[name], by))
    expected = -found.direction @ by
    off = abs(found.distance - expected)
    assert np.median(off) < 0.7 * PIXEL
    clear = abs(expected) > 1.5 * PIXEL
    if clear.sum() > 20:
        same = np.sign(found.distance[clear]) == np.sign(expected[clear])
        assert same.mean() > 0.9


def _part_alone(part):
    """The body of one part's cones."""
    return dataclasses.replace(BODY, cones=BODY.cones[BODY.cones["part"] == part])


def _of_forearm(found, body=BODY):
    return (body.cones["part"][found.cone] == LEFT_FOREARM).sum()


def test_outlines_that_another_part_covers_are_left_out():
    """All edges of the forearm are there to be measured, but before the chest they are no edges."""
    arm = _part_alone(LEFT_FOREARM)
    for name, fore, kept in (("before", [1, 0.2, 0.1], False), ("aside", [-1, 0.2, 0.1], True)):
        pose = pose_with_arms([1, 0, 0], [1, 0.05, 0], [-0.2, 0.7, -0.6], fore)
        edges = edge_maps(cloud_of_body(arm, pose, "N"))
        alone = contours_of(edges, arm, arm.frames(pose))
        whole = contours_of(edges, BODY, BODY.frames(pose))
        assert _of_forearm(alone, arm) >= 12, name
        assert _of_forearm(whole) >= 10 if kept else _of_forearm(whole) <= 6, name


def test_an_empty_room_gives_no_residuals():
    assert SilhouetteObservation(edge_maps(cloud_seen([])), SIGMA).residuals(BODY, POSES["t"]) == ()
    post = [(np.eye(3), np.array([1.2, 0.0, 0.2]), 0.1, 0.1, 1.0, 1.0, False)]
    (residual,) = SilhouetteObservation(edge_maps(cloud_seen(post)), SIGMA).residuals(
        BODY, POSES["t"]
    )
    assert len(residual.distance) < 10
