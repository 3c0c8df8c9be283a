"""Detectors that work on the cloud at hand."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.model import landmarks
from stereotrack_core.recording.detections import HAND, HEAD
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.residuals.keypoint_detectors import (
    extremities,
    is_skin,
    skin_detections,
    surface_graph,
)
from stereotrack_core.tracking.residuals.keypoints import DetectionObservation, detections_in
from tests.tracking.keypoints.cases import BODY, seen
from tests.tracking.recordings import camera_towards_the_middle, rendered_depth
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points

SHIRT, SKIN = (120.0, 70.0, 40.0), (105.0, 130.0, 190.0)
FREE = ("t", "pointing")


def _landmark(pose, name):
    return landmarks(BODY, pose)[LANDMARKS.index(name)]


def _found(detections, kind):
    return np.array([d.position for d in detections if d.kind == kind]).reshape(-1, 3)


def _misses(detections, pose):
    """Distances of head, left and right hand from the nearest detection of their kind."""
    wanted = [(HEAD, "head"), (HAND, "left_hand"), (HAND, "right_hand")]
    distances = []
    for kind, name in wanted:
        off = _found(detections, kind) - _landmark(pose, name)
        distances.append(np.linalg.norm(off, axis=1).min(initial=np.inf))
    return distances


def _seen_by_one(pose, place):
    """World points of a rendered depth image."""
    camera = camera_towards_the_middle("N", place)
    depth = rendered_depth(BODY, pose, camera)
    v, u = np.nonzero(np.isfinite(depth))
    z = depth[v, u]
    rays = np.stack([u - camera.matrix[0, 2], v - camera.matrix[1, 2]], axis=1)
    local = np.column_stack([rays / camera.matrix[0, 0] * z[:, None], z])
    return camera.world_from_camera.apply(local)


@pytest.mark.parametrize("name", FREE)
def test_ends_of_the_cloud_are_head_and_hands(name, rng):
    points = surface_points(BODY, POSES[name], 6000, rng, 0.005)
    detections = extremities(points, 3)
    assert max(_misses(detections, POSES[name])) < 0.12
    assert len(_found(detections, HEAD)) == 1
    assert {d.time for d in detections} == {3}


@pytest.mark.parametrize("name", FREE)
def test_one_view_is_enough(name):
    points = _seen_by_one(POSES[name], CAMERAS[0])
    assert max(_misses(extremities(points, 0), POSES[name])) < 0.15


def test_pieces_that_hide_each_other_are_joined(rng):
    points = surface_points(BODY, POSES["t"], 6000, rng, 0.005)
    gap = np.abs(points[:, 0] - _landmark(POSES["t"], "right_elbow")[0]) < 0.06
    assert max(_misses(extremities(points[~gap], 0), POSES["t"])) < 0.12


def test_too_little_data_give_nothing(rng):
    assert extremities(np.zeros((0, 3)), 0) == ()
    assert extremities(rng.normal(size=(40, 3)), 0) == ()
    assert len(surface_graph(np.zeros((5, 3)))[0]) <= 1


def _clothed(pose, rng):
    points = surface_points(BODY, pose, 6000, rng, 0.004)
    naked = np.zeros(len(points), dtype=bool)
    for name, reach in (("head", 0.13), ("left_hand", 0.11), ("right_hand", 0.11)):
        naked |= np.linalg.norm(points - _landmark(pose, name), axis=1) < reach
    colours = np.where(naked[:, None], SKIN, SHIRT) + rng.normal(0, 3.0, points.shape)
    return replace(cloud_of(points, 7), colours=colours)


@pytest.mark.parametrize("name", POSES)
def test_skin_is_head_and_hands(name, rng):
    detections = skin_detections(_clothed(POSES[name], rng))
    assert max(_misses(detections, POSES[name])) < 0.12
    assert len(detections) == 3


def test_grey_clouds_have_no_skin(rng):
    cloud = _clothed(POSES["t"], rng)
    assert skin_detections(replace(cloud, colours=None)) == ()
    assert skin_detections(replace(cloud, colours=cloud.colours[:10])) == ()
    grey = np.repeat(rng.uniform(0, 255, (len(cloud.points), 1)), 3, axis=1)
    assert skin_detections(replace(cloud, colours=grey)) == ()


def test_skin_of_all_shades_is_skin():
    shades = np.array([(94, 120, 168), (56, 74, 107), (125, 148, 194), (105, 130, 190)], float)
    assert is_skin(shades).all()
    others = np.array([(128, 128, 128), (150, 80, 40), (40, 140, 40), (5, 5, 9), (255, 255, 255)])
    assert not is_skin(others.astype(float)).any()


@pytest.mark.parametrize(("detect", "count"), [("none", 1), ("extremities", 4), ("skin", 4)])
def test_the_sensor_adds_what_came_with_the_frame(detect, count, rng):
    given = seen("head", POSES["t"], time=7.0)
    early = seen("head", POSES["t"], time=6.5)
    cloud = replace(_clothed(POSES["t"], rng), detections=(early, given))
    observed = DetectionObservation(detections_in(cloud, detect), 0.3)
    assert len(observed.detections) >= count
    assert given in observed.detections
    assert early not in observed.detections
    rows = observed.residuals(BODY, POSES["t"])
    assert {row.part for row in rows} <= set(ALL_JOINTS)
    assert len(rows) == min(count, 3)
