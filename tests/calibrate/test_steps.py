"""The steps that a window takes, and their verdicts."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.calibrate import report
from stereotrack_core.calibrate.lens import RADIAL, Lens
from stereotrack_core.calibrate.work import fit_lenses
from stereotrack_core.errors import InputError
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
    found = fit_lenses((sightings[0], few), BOARD, "radial", asker)
    assert found["N_left"].rms_px < 0.3
    assert isinstance(found["N_right"], InputError)
    assert [word.words for word in asker.told] == ["lens of N_left", "lens of N_right"]
    said = report.of_lenses(found)
    assert said.words == "Film again with N_right."
    assert "found in 2 pictures of 14" in said.remarks[0]
