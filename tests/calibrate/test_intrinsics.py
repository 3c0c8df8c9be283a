"""Lenses from projected corners: models, outlying pictures, what cannot work."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.calibrate import intrinsics, report
from stereotrack_core.calibrate.intrinsics import calibrate_intrinsics
from stereotrack_core.calibrate.lens import BROWN, RADIAL, Lens, lens_of
from stereotrack_core.calibrate.work import fit_lenses
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from tests.calibrate.scenes import (
    BENT,
    BOARD,
    HERE,
    ROUND,
    SIZE,
    WIDE,
    boards_before,
    looking_at,
    sightings_of,
)


def seen_by(lens, count=16, noise=0.1, seed=1, distances=(1.0, 2.0)):
    camera = lens.camera("a", SIZE, HERE)
    boards = boards_before(camera, count, seed, distances=distances)
    return sightings_of(camera, boards, seed, noise), camera


@pytest.mark.parametrize(
    ("lens", "model", "distances"),
    [
        (BENT.as_model(BROWN), "brown", (1.0, 2.0)),
        (BENT.as_model(RADIAL), "radial", (1.0, 2.0)),
        (WIDE, "rational", (0.4, 1.0)),
        (ROUND, "fisheye", (0.3, 1.0)),
    ],
    ids=["brown", "radial", "rational", "fisheye"],
)
def test_the_model_is_no_richer_than_the_lens(lens, model, distances):
    sightings, camera = seen_by(lens, noise=0.05, distances=distances)
    found = calibrate_intrinsics(sightings, BOARD)
    assert found.lens.model.name == model
    assert abs(found.camera.focal / camera.focal - 1) < 0.002
    assert found.rms_px < found.held_out_px < 0.1
    off = np.abs(found.lens.values[:4] - lens.values[:4])
    assert (off < 5 * found.sigma).all()
    assert {one.model.name for one in found.candidates} >= {model, "radial"}


def test_a_model_that_leaves_the_focal_length_open_is_not_taken(monkeypatch):
    """A rational lens without distortion, of which numerator and denominator are alike."""
    sightings, camera = seen_by(WIDE, noise=0.05, distances=(0.4, 1.0))
    known = intrinsics._sigma

    def open_if_rational(fit):
        return known(fit) * (1e3 if fit.lens.model.name == "rational" else 1.0)

    monkeypatch.setattr(intrinsics, "_sigma", open_if_rational)
    found = calibrate_intrinsics(sightings, BOARD)
    assert found.lens.model.name != "rational"
    assert abs(found.camera.focal / camera.focal - 1) < 0.02


def test_outlying_pictures_are_removed_with_a_reason():
    sightings, camera = seen_by(BENT)
    rng = np.random.default_rng(5)
    pixels = sightings.pixels.copy()
    pixels[3] += rng.normal(0, 2.0, pixels[3].shape)
    pixels[7, :6] += 15.0
    found = calibrate_intrinsics(replace(sightings, pixels=pixels), BOARD, model="brown5")
    out = {one.frame: one.reason for one in found.sightings.left_out}
    assert set(out) == {3} or set(out) == {3, 7}
    assert "px off, usual are 0." in out[3]
    assert abs(found.camera.focal / camera.focal - 1) < 0.003
    assert found.rms_px < 0.16


def test_too_few_pictures_are_refused():
    sightings, _ = seen_by(BENT, count=3)
    with pytest.raises(InputError, match="found in 3 pictures of 3") as refusal:
        calibrate_intrinsics(sightings, BOARD)
    assert "15 to 30 positions" in refusal.value.remedy


def test_parallel_boards_are_refused():
    lens = BENT.as_model(BROWN)
    camera = lens.camera("a", SIZE, HERE)
    rng = np.random.default_rng(2)
    boards = []
    for _ in range(14):
        rotation = rotation_from_vector(rng.normal(0, 0.002, 3))
        place = np.array([*rng.uniform(-0.6, 0.1, 2), rng.uniform(1.6, 2.0)])
        boards.append(RigidTransform(rotation, place))
    sightings = sightings_of(camera, boards, 1)
    assert len(sightings) > 5
    with pytest.raises(InputError, match="all nearly parallel") as refusal:
        calibrate_intrinsics(sightings, BOARD, model="radial")
    assert "tilt the board" in refusal.value.remedy


def test_noise_in_the_values_is_as_large_as_stated():
    lens = Lens(RADIAL, BENT.as_model(RADIAL).values)
    scaled = []
    for seed in range(3):
        sightings, _ = seen_by(lens, seed=seed)
        found = calibrate_intrinsics(sightings, BOARD, model="radial")
        scaled.append((found.lens.values[:4] - lens.values[:4]) / found.sigma)
    assert 0.5 < np.sqrt(np.mean(np.square(scaled))) < 1.6


def test_a_board_that_is_small_in_the_image_has_to_come_nearer():
    far, near = (
        calibrate_intrinsics(seen_by(ROUND, 25, distances=distances)[0], BOARD, model="fisheye")
        for distances in ((1.5, 3.0), (0.4, 1.0))
    )
    (vague,) = [one for one in far.findings if "only known to" in one.what]
    assert abs(far.lens.focal / ROUND.focal - 1.0) < 3.0 * far.sigma.max() / ROUND.focal
    assert vague.remedy.startswith("The board is too small in the pictures: it fills ")
    assert "about 0." in vague.remedy
    assert abs(near.lens.focal / ROUND.focal - 1.0) < 0.002
    assert not [one for one in near.findings if "only known to" in one.what]


@pytest.mark.parametrize("lens", [BENT, WIDE, ROUND])
def test_a_camera_gives_its_lens_again(lens):
    again = lens_of(lens.camera("a", SIZE, HERE))
    assert again.model is lens.model
    np.testing.assert_array_equal(again.values, lens.values)


_LENS = Lens(RADIAL, np.array([600.0, 600, 320, 240, -0.1, 0.02, 0, 0, 0, 0, 0, 0]))


class Asker:
    def __init__(self):
        self.told = []

    def tell(self, word):
        self.told.append(word)

    def cancelled(self):
        return False


def test_lenses_that_fail_do_not_keep_the_others_from_their_results():
    left, right = (
        _LENS.camera(name, SIZE, looking_at((x, -2, 1.2)))
        for name, x in (("N_left", 0.0), ("N_right", 0.12))
    )
    boards = boards_before(left, 14, seed=7, distances=(0.9, 1.8))
    few = replace(sightings_of(right, boards, 3).only(np.arange(2)), searched=14)
    asker = Asker()
    found = fit_lenses((sightings_of(left, boards, 3), few), BOARD, "radial", asker)
    assert found["N_left"].rms_px < 0.3
    assert isinstance(found["N_right"], InputError)
    assert [word.words for word in asker.told] == ["lens of N_left", "lens of N_right"]
    said = report.of_lenses(found)
    assert said.words == "Film again with N_right."
    assert "found in 2 pictures of 14" in said.remarks[0]
