"""The steps that a window takes: changes against a calibration before, verdicts."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.calibrate import verdict
from stereotrack_core.calibrate.changes import change_table, changes
from stereotrack_core.calibrate.lens import RADIAL, Lens
from stereotrack_core.calibrate.work import FitLenses, FitWorld
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from tests.calibrate.scenes import BOARD, SIZE, boards_before, looking_at, sightings_of

_LENS = Lens(RADIAL, np.array([600.0, 600, 320, 240, -0.1, 0.02, 0, 0, 0, 0, 0, 0]))


class Asker:
    """Hears what a step tells."""

    def __init__(self):
        self.told = []

    def tell(self, word):
        self.told.append(word)

    def cancelled(self):
        return False


@pytest.fixture(scope="module")
def scene():
    """Three cameras, of which the third sees no board together with the others."""
    cameras = [
        _LENS.camera(name, SIZE, looking_at((x, -2, 1.2)))
        for name, x in (("N_left", 0.0), ("N_right", 0.12))
    ]
    boards = boards_before(cameras[0], 14, seed=7, distances=(0.9, 1.8))
    seen = [sightings_of(camera, boards, 3) for camera in cameras]
    alone = replace(seen[0], camera="far", frames=seen[0].frames + 100)
    return cameras, [*seen, alone]


def test_lenses_that_fail_do_not_keep_the_others_from_their_results(scene):
    sightings = scene[1]
    few = replace(sightings[1].only(np.arange(2)), searched=14)
    asker = Asker()
    found = FitLenses((sightings[0], few), BOARD, "radial")(asker)
    assert found["N_left"].rms_px < 0.3
    assert isinstance(found["N_right"], InputError)
    assert [word.words for word in asker.told] == ["lens of N_left", "lens of N_right"]
    said = verdict.of_lenses(found)
    assert said.words == "Film again with N_right."
    assert "found in 2 pictures of 14" in said.remarks[0]


def test_changes_against_the_calibration_before(scene):
    cameras, sightings = scene
    world = FitWorld(tuple(sightings[:2]), BOARD, given={one.name: one for one in cameras})(Asker())
    turn = RigidTransform(rotation_from_vector(np.array([0.3, -0.2, 1.0])), np.ones(3))
    before = {
        one.name: replace(one, camera_from_world=one.camera_from_world @ turn) for one in cameras
    }
    left, right = changes(world, before)
    assert left.moved_m < 0.002
    assert right.turned_deg < 0.1
    assert left.rms_before_px == pytest.approx(left.rms_after_px, rel=0.2)
    # a camera that was moved, and one that was not there
    pose = before["N_right"].camera_from_world
    shift = RigidTransform(pose.rotation, pose.translation + np.array([0.0, 0.02, 0.0]))
    moved = replace(before["N_right"], camera_from_world=shift)
    left, right = changes(world, {**before, "N_right": moved})
    assert right.rms_before_px > 5 * right.rms_after_px
    (_, new) = changes(world, {"N_left": before["N_left"]})
    assert np.isnan(new.moved_m)
    assert change_table((left, new)).rows[1][1] == "-"
