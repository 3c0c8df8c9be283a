"""Cameras in one world: chains, stereo cameras, wrong pictures, what cannot work."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.calibrate.connection import connected
from stereotrack_core.calibrate.lens import BROWN
from stereotrack_core.calibrate.world import calibrate_world, pair_of
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import vector_from_rotation
from tests.calibrate.scenes import BENT, BOARD, SIZE, boards_before, looking_at, sightings_of

_LENS = BENT.as_model(BROWN)


def camera_at(name, *place):
    return _LENS.camera(name, SIZE, looking_at(place))


def off(world, true):
    """Distances (m) and angles (rad) of cameras from the truth, relative to the first ones."""
    first, known = world.cameras[0], true[0]
    places, turns = [], []
    for found, own in zip(world.cameras, true, strict=True):
        mine = found.camera_from_world @ first.world_from_camera
        right = own.camera_from_world @ known.world_from_camera
        places.append(np.linalg.norm(mine.inverse().translation - right.inverse().translation))
        turns.append(np.linalg.norm(vector_from_rotation(mine.rotation @ right.rotation.T)))
    return np.array(places), np.array(turns)


@pytest.fixture(scope="module")
def pair():
    cameras = [camera_at("N_left", 0.06, -2, 1.2), camera_at("N_right", 0.18, -2, 1.2)]
    return cameras, boards_before(cameras[0], 18, seed=7, distances=(0.9, 1.8))


@pytest.fixture(scope="module")
def chain():
    """Three cameras; the first and the last never see the same board."""
    cameras = [camera_at("a", -2, -1.2, 1.2), camera_at("b", 0, -2.2, 1.3)]
    cameras.append(camera_at("c", 2, -1.2, 1.1))
    first = [sightings_of(one, boards_before(cameras[0], 40, seed=1), 1) for one in cameras]
    last = [sightings_of(one, boards_before(cameras[2], 40, seed=2), 2) for one in cameras]
    joined = []
    for one, other in zip(first, last, strict=True):
        frames = np.concatenate([one.frames, other.frames + 40])
        pixels = np.concatenate([one.pixels, other.pixels])
        joined.append(
            replace(one, frames=frames, pixels=pixels, pictures=(*one.pictures, *other.pictures))
        )
    near = set(joined[0].frames) & set(joined[2].frames)
    only = [np.flatnonzero(~np.isin(one.frames, list(near))) for one in joined]
    return cameras, [one.only(rows) for one, rows in zip(joined, only, strict=True)]


def test_a_stereo_camera(pair):
    cameras, boards = pair
    seen = [sightings_of(camera, boards, 3) for camera in cameras]
    world = calibrate_world(seen, BOARD, model="brown")
    places, turns = off(world, cameras)
    assert places.max() < 0.002
    assert np.degrees(turns.max()) < 0.1
    assert world.rms_px < 0.16
    assert world.rms_px < world.held_out_px < 0.3
    assert abs(world.scale.ratio - 1) < 0.005
    assert 0 < world.position_sigma_m[1] < 0.003
    found = pair_of(*world.cameras, *world.sightings)
    assert found.baseline_m == pytest.approx(0.12, abs=0.001)
    assert found.row_error_px < 0.3
    with pytest.raises(InputError, match="exchanged"):
        pair_of(*world.cameras[::-1], *world.sightings[::-1])


def test_cameras_that_share_no_board_are_connected_over_others(chain):
    cameras, seen = chain
    assert not set(seen[0].frames) & set(seen[2].frames)
    world = calibrate_world(seen, BOARD, model="brown")
    places, turns = off(world, cameras)
    assert places.max() < 0.005
    assert np.degrees(turns.max()) < 0.2
    assert world.shared[0, 2] == 0
    assert world.shared[0, 1] > 3


def test_cameras_without_a_connection_are_refused(chain):
    _, seen = chain
    with pytest.raises(InputError, match="a and c never saw the board at the same time") as refusal:
        calibrate_world([seen[0], seen[2]], BOARD, model="radial")
    assert "one camera of each group" in refusal.value.remedy


def test_given_lenses_stay_as_they_are(pair):
    cameras, boards = pair
    seen = [sightings_of(camera, boards[:8], 3) for camera in cameras]
    given = {camera.name: camera for camera in cameras}
    world = calibrate_world(seen, BOARD, given=given)
    assert world.lenses == (None, None)
    for found, own in zip(world.cameras, cameras, strict=True):
        np.testing.assert_allclose(found.matrix, own.matrix)
        np.testing.assert_allclose(found.distortions, own.distortions)
    assert off(world, cameras)[0].max() < 0.002
    wrong = {"N_left": replace(cameras[0], width=320)}
    with pytest.raises(InputError, match="320x480"):
        calibrate_world(seen, BOARD, given=wrong)


def test_a_picture_of_another_instant_is_left_out(pair):
    cameras, boards = pair
    seen = [sightings_of(camera, boards, 3) for camera in cameras]
    pixels = seen[1].pixels.copy()
    pixels[4] += (12.0, -9.0)
    world = calibrate_world([seen[0], replace(seen[1], pixels=pixels)], BOARD, model="brown")
    out = [one for own in world.sightings for one in own.left_out]
    assert {int(seen[1].frames[4])} == {one.frame for one in out}
    assert off(world, cameras)[0].max() < 0.002


def bent_camera_at(name, *place):
    return BENT.camera(name, SIZE, looking_at(place))


def test_few_far_boards_do_not_put_a_camera_elsewhere():
    boards = 3
    cameras = [bent_camera_at("a", 0, -3.2, 1.2), bent_camera_at("b", 2.6, -2.2, 1.4)]
    true = cameras[1].camera_from_world @ cameras[0].world_from_camera
    off = []
    for seed in range(10):
        many = boards_before(cameras[0], 60, seed=seed, distances=(6.0, 9.0))
        seen = [sightings_of(one, many, seed, noise=0.8) for one in cameras]
        common = sorted(set(seen[0].frames.tolist()) & set(seen[1].frames.tolist()))[:boards]
        few = [one.only(np.flatnonzero(np.isin(one.frames, common))) for one in seen]
        found = connected(few, [BENT, BENT], BOARD)
        assert found.shared[0, 1] == boards
        off.append(np.linalg.norm(found.cameras[1].translation - true.translation))
    assert max(off) < 2.0, f"metres, by seed: {np.round(off, 1)}"
