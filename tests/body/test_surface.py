"""The nearest place on the surface, against brute force."""

import numpy as np
import pytest

from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.surface import nearest_on_surface, parts_of_cones
from tests.body.poses import random_pose, single_cone
from tests.oracle.cone import depth_inside, nearest_on_half_sphere, nearest_on_side

ROUND = {
    "upper arm": (0.058, 0.045, 0.272),
    "widening": (0.06, 0.09, 0.135),
    "cylinder": (0.1, 0.1, 0.3),
    "pointed": (0.05, 0.0, 0.2),
}


def _around(rng, count, r, height, margin=0.3):
    low = [-r - margin, -r - margin, -margin]
    return rng.uniform(low, [r + margin, r + margin, height + margin], (count, 3))


@pytest.mark.parametrize("name", ROUND)
def test_round_cones_are_exact(rng, name):
    r1, r2, height = ROUND[name]
    placed, turn, origin = single_cone(rng, r1, r2, height)
    local = _around(rng, 60, max(r1, r2), height)
    closest = nearest_on_surface(local @ turn.T + origin, placed, np.inf)
    found = closest.cone == 0
    assert found.sum() > 40
    for point, place, distance in zip(
        local[found], (closest.point[found] - origin) @ turn, closest.distance[found], strict=True
    ):
        best = nearest_on_side(r1, r2, height, 1.0, point)
        assert abs(distance) == pytest.approx(np.linalg.norm(point - best), abs=1e-6)
        np.testing.assert_allclose(place, best, atol=1e-4)
        assert (distance < 0) == (depth_inside(r1, r2, height, 1.0, point) > 0)


def test_a_half_sphere_closes_a_round_end(rng):
    r1, r2, height = 0.04, 0.032, 0.194
    placed, turn, origin = single_cone(rng, r1, r2, height, round_end=True)
    local = _around(rng, 50, r1, height, 0.2)
    local = local[[depth_inside(r1, r2, height, 1.0, point) < 0 for point in local]]
    closest = nearest_on_surface(local @ turn.T + origin, placed, np.inf)
    for i in np.flatnonzero(closest.cone == 0):
        side = nearest_on_side(r1, r2, height, 1.0, local[i])
        places = side, nearest_on_half_sphere(r2, height, 1.0, local[i])
        best = min(np.linalg.norm(local[i] - place) for place in places)
        assert abs(closest.distance[i]) == pytest.approx(best, abs=1e-3)


@pytest.mark.parametrize("s", [0.6, 0.8])
def test_the_flattened_torso_is_good_to_some_millimetres(rng, s):
    """The point lies on the surface, but beside the nearest one; distances are what is used."""
    r1, r2, height = 0.165, 0.175, 0.511
    placed, turn, origin = single_cone(rng, r1, r2, height, s)
    local = _around(rng, 1200, 0.17, height, 0.2)
    closest = nearest_on_surface(local @ turn.T + origin, placed, 0.25)
    near, far, deep = [], [], []
    for i in np.flatnonzero(closest.cone == 0)[:400]:
        point, place = local[i], turn.T @ (closest.point[i] - origin)
        radius = r1 + (r2 - r1) * place[2] / height
        assert np.hypot(place[0], place[1] / s) == pytest.approx(radius, abs=1e-12)
        best = np.linalg.norm(point - nearest_on_side(r1, r2, height, s, point))
        inside = depth_inside(r1, r2, height, s, point) > 0
        bin_ = deep if inside and best > 0.05 else near if best < 0.1 else far
        bin_.append(abs(abs(closest.distance[i]) - best))
    assert min(len(near), len(far)) > 80
    assert np.mean(near) < 0.0024
    assert max(near) < 0.0076
    assert max(far) < 0.022
    assert max(deep) < 0.035


def test_directions_are_unit_vectors_that_point_outwards(rng, body):
    placed = placed_cones(body, body.frames(random_pose(rng)))
    data = placed["origin"][rng.integers(0, 15, 500)] + 0.15 * rng.normal(size=(500, 3))
    closest = nearest_on_surface(data, placed, 0.5)
    taken = closest.cone >= 0
    assert taken.sum() > 400
    np.testing.assert_allclose(np.linalg.norm(closest.direction[taken], axis=1), 1.0)
    along = np.einsum("ni,ni->n", data - closest.point, closest.direction)
    np.testing.assert_allclose(along[taken], closest.distance[taken], atol=1e-12)


def test_the_nearest_cone_takes_the_datum(rng, body):
    placed = placed_cones(body, body.frames(random_pose(rng)))
    data = placed["origin"][rng.integers(0, 15, 300)] + 0.2 * rng.normal(size=(300, 3))
    together = nearest_on_surface(data, placed, np.inf)
    single = np.array(
        [nearest_on_surface(data, placed[c : c + 1], np.inf).distance for c in range(15)]
    )
    np.testing.assert_array_equal(np.abs(together.distance), np.abs(single).min(axis=0))
    taken = together.cone >= 0
    np.testing.assert_array_equal(together.cone[taken], np.abs(single).argmin(axis=0)[taken])
    np.testing.assert_array_equal(
        parts_of_cones(body, together.cone),
        [body.cones["part"][c] if c >= 0 else -1 for c in together.cone],
    )
