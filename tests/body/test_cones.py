"""The cones that stand for the body, the margins of its outline, and its meshes."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from stereotrack_core.body.mesh import body_mesh
from stereotrack_core.body.model import body_cones, body_model, placed_cones
from stereotrack_core.body.parameters import BodyParameters, BodyShape
from stereotrack_core.body.proportions import AVERAGE, Proportions, proportions_of
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.recording.description import Subject
from tests.body.poses import random_pose


def test_radii_and_heights_are_those_of_the_table():
    parameters = BodyParameters(legs=False, torso_radius_low=0.165, torso_radius_high=0.175)
    c, a = body_cones(AVERAGE, parameters), AVERAGE
    rows = np.column_stack([c[name] for name in ("r1", "r2", "height", "flatness")])
    shoulder = [0.075, 0.07, 0.5 * a.shoulder_width - 0.03, 1.0]
    upper = [0.058, 0.045, a.upper_arm_length, 1.0]
    fore, hand = [0.045, 0.032, a.forearm_length, 1.0], [0.040, 0.032, a.hand_length, 1.0]
    expected = [
        [0.165, 0.175, a.torso_length + 0.05, parameters.torso_flatness],
        *[shoulder] * 2,
        [0.06, 0.09, 0.135, 1.0],
        [0.09, 0.055, 0.135, 1.0],
        *[upper] * 2,
        *[fore, hand] * 2,
    ]
    np.testing.assert_allclose(rows, expected, atol=1e-3)


def test_arm_cones_lead_from_joint_to_joint(rng, legless):
    frames = legless.frames(random_pose(rng))
    placed = placed_cones(legless, frames)
    ends = placed["origin"] + placed["rotation"][..., 2] * placed["height"][:, None]
    for side in ("left", "right"):
        upper, fore = PARTS.index(f"{side}_upper_arm"), PARTS.index(f"{side}_forearm")
        (u,), (f, h) = (np.flatnonzero(placed["part"] == part) for part in (upper, fore))
        np.testing.assert_allclose(placed["origin"][u], frames.origins[upper], atol=1e-12)
        np.testing.assert_allclose(ends[u], frames.origins[fore], atol=1e-12)
        np.testing.assert_allclose(placed["origin"][h], ends[f], atol=1e-12)


def test_cones_grow_with_the_proportions():
    tall = Proportions(**{k: 1.1 * v for k, v in dataclasses.asdict(AVERAGE).items()})
    small, big = (body_cones(p, BodyParameters()) for p in (AVERAGE, tall))
    for name in ("r1", "r2"):
        np.testing.assert_allclose(big[name], 1.1 * small[name])


@pytest.mark.parametrize(
    ("name", "value", "parts"),
    [("arm_radius_factor", 1.5, (2, 3, 4, 5)), ("leg_radius_factor", 0.8, (6, 7, 8, 9))],
)
def test_radius_factors_act_on_their_parts_alone(name, value, parts):
    plain, changed = (body_cones(AVERAGE, BodyShape(**v)) for v in ({}, {name: value}))
    factor = np.where(np.isin(plain["part"], parts), value, 1.0)
    for end in ("r1", "r2"):
        np.testing.assert_allclose(changed[end], factor * plain[end])


NAMES = tuple(row.name for row in BodyShape.rows() if row.name.startswith("contour_"))
EXPECTED = {
    "contour_torso_side": [(0, 0)],
    "contour_torso_front": [(0, 1)],
    "contour_shoulder_top": [(1, 0), (2, 0)],
    "contour_shoulder_front": [(1, 1), (2, 1)],
    "contour_jaw_side": [(3, 0)],
    "contour_jaw_front": [(3, 1)],
    "contour_head_side": [(4, 0)],
    "contour_head_front": [(4, 1)],
    "contour_upper_arm": [(5, 0), (5, 1), (6, 0), (6, 1)],
    "contour_forearm": [(7, 0), (7, 1), (9, 0), (9, 1)],
    "contour_hand": [(8, 0), (8, 1), (10, 0), (10, 1)],
}
"""Cone and axis, 0 for x and 1 for y, by margin."""


@pytest.mark.parametrize("name", NAMES)
def test_a_margin_acts_on_its_cones_alone(name):
    plain, changed = (body_cones(AVERAGE, BodyShape().replaced(**v)) for v in ({}, {name: 0.03}))
    where = np.argwhere(changed["outline"] != plain["outline"])
    assert [tuple(index) for index in where.tolist()] == EXPECTED[name]
    assert (changed["outline"][tuple(where.T)] == 0.03).all()
    for field in ("r1", "r2", "height", "origin", "flatness"):
        np.testing.assert_array_equal(changed[field], plain[field])


@pytest.fixture
def placed_and_meshes(rng, legless):
    pose = random_pose(rng)
    return placed_cones(legless, legless.frames(pose)), body_mesh(legless, pose, around=24)


def _corners(mesh):
    """Corners (T, 3, 3) of the triangles that have an area."""
    corners = mesh.vertices[mesh.triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return corners[np.linalg.norm(area, axis=1) > 1e-12]


def test_meshes_are_closed(placed_and_meshes):
    for mesh in placed_and_meshes[1]:
        edges = Counter()
        for triangle in np.round(_corners(mesh), 7):
            names = [tuple(corner) for corner in triangle]
            edges.update((names[i], names[(i + 1) % 3]) for i in range(3))
        assert edges
        assert all(count == 1 and edges[b, a] == 1 for (a, b), count in edges.items())


def test_triangles_are_counter_clockwise_from_outside(placed_and_meshes):
    placed, meshes = placed_and_meshes
    for c, mesh in enumerate(meshes):
        corners = _corners(mesh)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        middle = placed["origin"][c] + 0.5 * placed["height"][c] * placed["rotation"][c, :, 2]
        assert (np.einsum("ti,ti->t", normal, corners.mean(axis=1) - middle) > 0).all()


def test_vertices_lie_on_the_surface(placed_and_meshes):
    placed, meshes = placed_and_meshes
    for c, mesh in enumerate(meshes):
        one = placed[c : c + 1]
        local = (mesh.vertices - one["origin"][0]) @ one["rotation"][0]
        on_axis = np.hypot(local[:, 0], local[:, 1]) < 1e-9
        closest = nearest_on_surface(mesh.vertices, one, 1.0)
        flat_ends = on_axis & (local[:, 2] <= one["height"][0] + 1e-9)
        np.testing.assert_allclose(closest.distance[~flat_ends], 0.0, atol=1e-9)
        np.testing.assert_allclose(closest.point[~flat_ends], mesh.vertices[~flat_ends], atol=1e-9)


def test_without_a_subject_lengths_are_average():
    assert proportions_of(None) == proportions_of(Subject()) == AVERAGE


def test_measured_lengths_are_kept_and_missing_ones_scaled():
    known = {"torso_length": 1.1 * AVERAGE.torso_length, "hand_length": 1.1 * AVERAGE.hand_length}
    filled = proportions_of(Subject(name="P1", **known))
    for field in dataclasses.fields(Proportions):
        assert getattr(filled, field.name) == pytest.approx(1.1 * getattr(AVERAGE, field.name))
    assert filled.torso_length == known["torso_length"]
    assert filled.scale == pytest.approx(1.1)


def test_average_proportions_can_be_asked_for():
    tall = Proportions(**{k: 1.2 * v for k, v in dataclasses.asdict(AVERAGE).items()})
    average = body_model(tall, BodyParameters(proportions="average"))
    np.testing.assert_array_equal(average.skeleton.lengths, body_model(AVERAGE).skeleton.lengths)
    individual = body_model(tall, BodyParameters(proportions="individual"))
    np.testing.assert_allclose(individual.skeleton.lengths, 1.2 * average.skeleton.lengths)
