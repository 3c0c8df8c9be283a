"""People who are part of a learned background: sizes and distances at which they are found."""

import numpy as np
import pytest

from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.standing import moves, standing_person, still_person
from stereotrack_core.geometry.transform import RigidTransform

GEOMETRY = DepthGeometry(
    100.0, 60.0, 60.0, 0.0, 0.0, 120, 120, RigidTransform(np.eye(3), np.zeros(3))
)
ANYWHERE = Volume(np.full(3, -np.inf), np.full(3, np.inf))
UP = np.array([0.0, -1.0, 0.0])


def _block(rows, columns, z):
    """Ranges of a rectangle in front of nothing."""
    learned = np.full((120, 120), np.nan, dtype=np.float32)
    learned[5 : 5 + rows, 8 : 8 + columns] = z
    return learned


def _measures(rows, columns, z):
    """Area, extent and height of a rectangle, metres; its last row and column end it."""
    side = z / GEOMETRY.focal
    pixels = np.mgrid[: rows - 1, : columns - 1].reshape(2, -1)
    v, u = side * np.subtract(*np.percentile(pixels, [98, 2], axis=1))
    return (rows - 1) * (columns - 1) * side**2, np.hypot(u, v), v


def test_the_tallest_surface_of_a_person_s_size_is_a_person_who_does_not_move(rng):
    found, expected = [], []
    for _ in range(80):
        rows, columns, z = rng.integers(4, 110), rng.integers(2, 30), rng.uniform(1.0, 4.0)
        area, extent, height = _measures(rows, columns, z)
        count = (rows - 1) * (columns - 1)
        expected.append(count >= 12 and 0.1 < area < 1.6 and extent <= 2.3 and height > 0.5)
        person = still_person(GEOMETRY, ANYWHERE, _block(rows, columns, z), UP)
        assert not person.any() or np.array_equal(person, np.isfinite(_block(rows, columns, z)))
        found.append(person.any())
    assert 15 < sum(expected) < 70
    assert found == expected
    two = _block(60, 12, 2.0)
    two[5:75, 60:72] = 2.0
    assert still_person(GEOMETRY, ANYWHERE, two, UP)[:, 60:72].any()
    assert not still_person(GEOMETRY, ANYWHERE, two, UP)[:, 8:20].any()
    near = Volume(np.full(3, -np.inf), np.array([np.inf, np.inf, 1.9]))
    assert not still_person(GEOMETRY, near, two, UP).any()


@pytest.mark.parametrize(("step", "joined"), [(0.055, True), (0.065, False)])
def test_a_surface_ends_where_ranges_jump_by_six_centimetres(step, joined):
    learned = _block(46, 12, 2.0)
    learned[28:] += np.float32(step)  # halves are not tall enough
    assert still_person(GEOMETRY, ANYWHERE, learned, UP).any() == joined


def _standing(rows, columns, apart=0.0, share=0.2, touching=10):
    """Whether a rectangle is a person beside whom something moves, so far in front of it."""
    learned, moving = _block(rows, columns, 2.0), np.zeros((120, 120), dtype=bool)
    moving[5 : 5 + touching, 8 + columns : 18 + columns] = True
    in_front = [moving & (k < share * 20) for k in range(20)]

    def ranges(where):
        assert np.array_equal(where, moving)
        for front in in_front:
            yield np.where(front[where], 2.0 - apart, np.nan).astype(np.float32)

    return standing_person(GEOMETRY, ANYWHERE, learned, in_front, ranges).any()


@pytest.mark.parametrize(
    ("rows", "columns", "person"),
    [(9, 9, False), (10, 10, True), (100, 38, True), (100, 43, False), (118, 8, True)],
)
def test_a_person_who_moves_in_part_has_three_hundredths_to_one_and_a_half_square_metres(
    rows, columns, person
):
    area, _, _ = _measures(rows, columns, 2.0)
    assert person == (0.03 < area < 1.6)
    assert _standing(rows, columns) == person


@pytest.mark.parametrize(
    ("changed", "person"),
    [
        ({"apart": 0.34}, True),
        ({"apart": 0.36}, False),
        ({"apart": -0.34}, True),
        ({"share": 0.1}, True),
        ({"touching": 3}, False),
    ],
)
def test_limbs_move_beside_a_trunk_and_near_it(changed, person):
    assert _standing(60, 12, **changed) == person


@pytest.mark.parametrize(("z", "seen"), [(1.9, False), (2.1, True)])
def test_what_moves_is_as_large_as_a_hand(z, seen):
    front = np.zeros((120, 120), dtype=bool)
    front[40:45, 50:55] = True
    ranges = [np.full(25, z, dtype=np.float32), np.full(25, z + 1.0, dtype=np.float32)]
    assert moves(GEOMETRY, ANYWHERE, [front] * 2, lambda _: ranges) == seen
    rarely = [front, *[np.zeros_like(front)] * 10]
    assert not moves(GEOMETRY, ANYWHERE, rarely, lambda where: [np.full(where.sum(), 3.0)])
