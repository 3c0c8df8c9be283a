"""Triangles for drawing."""

from collections import Counter

import numpy as np
import pytest

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.mesh import body_mesh
from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.body.surface import nearest_on_surface
from tests.body.poses import random_pose


@pytest.fixture
def placed_and_meshes(rng, legless):
    pose = random_pose(rng)
    return placed_cones(legless, legless.frames(pose)), body_mesh(legless, pose, around=24)


def _corners(mesh):
    """Corners (T, 3, 3) of the triangles that have an area."""
    corners = mesh.vertices[mesh.triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return corners[np.linalg.norm(area, axis=1) > 1e-12]


def test_there_is_a_mesh_for_every_cone_of_the_limbs(body, rng):
    names = [mesh.limb for mesh in body_mesh(body, random_pose(rng))]
    assert len(names) == 11
    assert set(names) == set(LIMBS)
    every = body_mesh(body, random_pose(rng), limbs=PARTS)
    assert {mesh.part for mesh in every} == set(range(len(PARTS)))
    assert {mesh.limb for mesh in every} == {*LIMBS, *PARTS[6:10]}  # shoulders are the torso's


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
        middle = placed.origins[c] + 0.5 * placed.cones.height[c] * placed.rotations[c, :, 2]
        assert (np.einsum("ti,ti->t", normal, corners.mean(axis=1) - middle) > 0).all()


def test_the_volume_is_nearly_that_of_the_cone(placed_and_meshes):
    placed, meshes = placed_and_meshes
    cones = placed.cones
    for c, mesh in enumerate(meshes):
        corners = _corners(mesh) - placed.origins[c]
        volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        r1, r2 = cones.r1[c], cones.r2[c]
        exact = np.pi / 3 * cones.height[c] * (r1 * r1 + r1 * r2 + r2 * r2) * cones.flatness[c]
        exact += cones.round_end[c] * 2 * np.pi / 3 * r2**3
        assert volume == pytest.approx(exact, rel=0.03)


def test_vertices_lie_on_the_surface(placed_and_meshes):
    placed, meshes = placed_and_meshes
    for c, mesh in enumerate(meshes):
        one = placed[c : c + 1]
        local = (mesh.vertices - one.origins[0]) @ one.rotations[0]
        on_axis = np.hypot(local[:, 0], local[:, 1]) < 1e-9
        closest = nearest_on_surface(mesh.vertices, one, 1.0)
        flat_ends = on_axis & (local[:, 2] <= one.cones.height[0] + 1e-9)
        np.testing.assert_allclose(closest.distance[~flat_ends], 0.0, atol=1e-9)
        np.testing.assert_allclose(closest.point[~flat_ends], mesh.vertices[~flat_ends], atol=1e-9)
