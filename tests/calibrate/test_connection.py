"""First places of cameras that share few far boards, each of which may be tilted either way."""

import numpy as np
import pytest

from stereotrack_core.calibrate.connection import connected
from tests.calibrate.scenes import BENT, BOARD, SIZE, boards_before, looking_at, sightings_of


def camera_at(name, *place):
    return BENT.camera(name, SIZE, looking_at(place))


@pytest.mark.parametrize("boards", [3, 5])
def test_few_far_boards_do_not_put_a_camera_elsewhere(boards):
    cameras = [camera_at("a", 0, -3.2, 1.2), camera_at("b", 2.6, -2.2, 1.4)]
    true = cameras[1].camera_from_world @ cameras[0].world_from_camera
    off = []
    for seed in range(20):
        many = boards_before(cameras[0], 60, seed=seed, distances=(6.0, 9.0))
        seen = [sightings_of(one, many, seed, noise=0.8) for one in cameras]
        common = sorted(set(seen[0].frames.tolist()) & set(seen[1].frames.tolist()))[:boards]
        few = [one.only(np.flatnonzero(np.isin(one.frames, common))) for one in seen]
        found = connected(few, [BENT, BENT], BOARD)
        assert found.shared[0, 1] == boards
        off.append(np.linalg.norm(found.cameras[1].translation - true.translation))
    assert max(off) < 2.0, f"metres, by seed: {np.round(off, 1)}"
