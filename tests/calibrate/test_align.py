"""Alignment: the true world found again from floor, board, points and person."""

import numpy as np
import pytest

from stereotrack_core.calibrate.align import (
    aligned,
    from_board,
    from_cameras,
    from_floor,
    from_person,
    from_points,
    triangulated,
)
from stereotrack_core.calibrate.report import of_alignment
from stereotrack_core.calibrate.world_checks import seen_board
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.calibrate.scenes import BENT, BOARD, SIZE, looking_at, sightings_of

_OLD_FROM_NEW = RigidTransform(rotation_from_vector(np.array([0.4, -0.3, 2.0])), np.ones(3))
"""The world as it was before; the new one is what the tests expect."""


@pytest.fixture
def cameras():
    """Three cameras in the old world, the first in the north."""
    places = {"a": (0, 2.5, 1.6), "b": (2.2, 0.5, 1.8), "c": (-1.5, -2, 1.5)}
    new = {
        name: BENT.camera(name, SIZE, looking_at(place, (0, 0, 0.4)))
        for name, place in places.items()
    }
    return aligned(new, _OLD_FROM_NEW)


def check(cameras, alignment, place=0.01, degrees=0.5):
    """The cameras are where they are in the new world."""
    new = aligned(cameras, alignment.new_from_old)
    both = alignment.new_from_old @ _OLD_FROM_NEW
    np.testing.assert_allclose(both.translation, 0, atol=place)
    np.testing.assert_allclose(both.rotation, np.eye(3), atol=np.radians(degrees))
    np.testing.assert_allclose(new["a"].position_world, (0, 2.5, 1.6), atol=3 * place)


def test_the_floor_is_found_below_furniture_and_beside_walls(cameras):
    rng = np.random.default_rng(0)
    floor = np.column_stack([rng.uniform(-2, 2, (3000, 2)), rng.normal(0, 0.01, 3000)])
    table = np.column_stack([rng.uniform(-0.5, 0.5, (2000, 2)), rng.normal(0.7, 0.005, 2000)])
    wall = np.column_stack(
        [np.full(4000, 2.5), rng.uniform(-2, 2, 4000), rng.uniform(0, 2.5, 4000)]
    )
    points = _OLD_FROM_NEW.apply(np.concatenate([floor, table, wall, np.full((5, 3), np.nan)]))
    found = from_floor(points, list(cameras.values()), cameras["a"])
    new = aligned(cameras, found.new_from_old)
    assert new["a"].position_world[2] == pytest.approx(1.6, abs=0.005)
    assert new["a"].position_world[1] > 2
    assert new["a"].camera_from_world.rotation[2, 0] == pytest.approx(0, abs=1e-6)
    assert found.points == pytest.approx(3000, abs=150)


def test_a_board_on_the_floor(cameras):
    # seen from above its upper side points north
    rotation = np.diag([1.0, -1.0, -1.0])
    middle = BOARD.corners.mean(axis=0)
    lying = _OLD_FROM_NEW @ RigidTransform(rotation, -rotation @ middle)
    seen = [sightings_of(camera, [lying], 1) for camera in cameras.values()]
    found = seen_board(cameras, seen, BOARD)
    assert len(found.cameras) >= 2
    assert found.rms_px < 0.3
    assert found.scale.ratio == pytest.approx(1, abs=0.01)
    on_floor = from_board(found.world_from_board, BOARD.corners)
    check(cameras, on_floor, degrees=0.7)
    held = [
        _OLD_FROM_NEW @ RigidTransform(rotation, np.array([x, 0.0, 0.8])) for x in (-0.6, 0.0, 0.6)
    ]
    for alignment, below in ((on_floor, 0), (from_board(held[0], BOARD.corners), 1)):
        new = alignment.new_from_old
        told = of_alignment(alignment, aligned(cameras, new), [new @ one for one in (lying, *held)])
        words = f"{below} position of the board lie below" if below else "board"
        assert (words in " ".join(told.remarks)) is bool(below), "then another one lies on it"


def test_three_clicked_points(cameras):
    points = {"origin": (0, 0, 0), "north": (0, 0.8, 0), "floor": (-0.6, 0.1, 0)}
    clicks = {
        name: {c.name: c.project(_OLD_FROM_NEW.apply(np.array(point))) for c in cameras.values()}
        for name, point in points.items()
    }
    found = triangulated(cameras, clicks)
    above = np.mean([one.position_world for one in cameras.values()], axis=0)
    check(cameras, from_points(found["origin"], found["north"], found["floor"], above))
    with pytest.raises(InputError, match="on a line"):
        from_points(found["origin"], found["north"], found["north"] * 1.01, above)
    del clicks["floor"]["b"], clicks["floor"]["c"]
    with pytest.raises(InputError, match="'floor' is clicked in 1 camera"):
        triangulated(cameras, clicks)


def person(frames):
    """Landmarks (F, 9, 3) of a person who faces north."""
    places = {"shoulder": (0.2, 1.5), "hip": (0.12, 1.0)}
    points = np.full((frames, 9, 3), np.nan)
    for name, (aside, height) in places.items():
        for side, sign in (("left", -1), ("right", 1)):
            row = LANDMARKS.index(f"{side}_{name}")
            points[:, row] = (sign * aside, 0, height * 0.92)
    return _OLD_FROM_NEW.apply(points)


def test_a_person_who_stands(cameras):
    found = from_person(person(20))
    assert found.points == 20
    check(cameras, found, place=0.08)


def test_cameras_are_laid_over_those_of_another_calibration(cameras):
    new = {
        name: BENT.camera(name, SIZE, looking_at(place, (0, 0, 0.4)))
        for name, place in {"a": (0, 2.5, 1.6), "b": (2.2, 0.5, 1.8), "other": (0, 1, 9)}.items()
    }
    found = from_cameras(cameras, new)
    check(cameras, found, 1e-9, 1e-6)
    assert found.points == 2
    assert found.spread_m < 1e-9
    # one camera is enough, because its axes are known
    check(cameras, from_cameras(cameras, {"a": new["a"]}), 1e-9, 1e-6)
    with pytest.raises(InputError, match="same name"):
        from_cameras(cameras, {"other": new["other"]})
