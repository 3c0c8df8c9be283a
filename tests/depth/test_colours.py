"""Colours of points and the calibration of the views against each other."""

import numpy as np
import pytest

from stereotrack_core.depth.cloud import DepthGeometry, ViewDepth
from stereotrack_core.depth.colours import (
    ColourCalibration,
    ColourPairs,
    fitted_gains,
    shared_colours,
)
from stereotrack_core.geometry.transform import RigidTransform

GAINS = np.array([[1.0, 1.0, 1.0], [1.2, 0.9, 1.05], [0.8, 1.1, 0.95], [1.02, 0.97, 1.3]])


@pytest.fixture
def rng():
    return np.random.default_rng(1811)


def _pairs(rng, links, count=400, noise=4.0, wrong=0.2):
    """Colours as views with GAINS show them; a share of the places are not the same place."""
    pairs = []
    for a, b in links:
        true = rng.uniform(40.0, 160.0, (count, 3))
        other = true.copy()
        other[rng.random(count) < wrong] = rng.uniform(40.0, 160.0, 3)
        seen = [c / GAINS[v] + rng.normal(0, noise, c.shape) for v, c in ((a, true), (b, other))]
        pairs.append(ColourPairs(a, b, *seen))
    return pairs


def test_known_gains_are_recovered_through_noise_and_wrong_pairs(rng):
    found = fitted_gains(4, _pairs(rng, [(0, 1), (1, 2), (2, 3), (0, 3)]))
    np.testing.assert_allclose(found, GAINS, rtol=0.03)
    np.testing.assert_array_equal(found[0], 1.0)


@pytest.fixture
def wall():
    """Function from a camera's place aside and its gains to its view of a patterned wall."""
    v, u = np.mgrid[:90, :120]

    def view(aside, gains):
        geometry = DepthGeometry(
            100.0, 59.5, 44.5, 0.1, 0.0, 120, 90,
            RigidTransform(np.eye(3), np.array([aside, 0.0, 0.0])),
        )  # fmt: skip
        x = (u - 59.5) / 100.0 * 2.0 + aside
        y = (v - 44.5) / 100.0 * 2.0
        bright = 90.0 + 30.0 * np.sin(2.0 * x) * np.cos(1.5 * y)
        picture = bright[..., None] * np.array([0.8, 1.0, 1.1]) / gains
        z = np.full((90, 120), 2.0, dtype=np.float32)
        seen = np.rint(picture).astype(np.uint8)
        return ViewDepth(geometry, None, z, np.ones((90, 120), bool), picture=seen)

    return view


def test_views_are_calibrated_by_what_both_see(wall):
    depths = {"N": wall(0.0, GAINS[0]), "O": wall(0.4, GAINS[1])}
    (pair,) = shared_colours(("N", "O"), depths)
    assert 100 < len(pair.of_a) == len(pair.of_b)
    calibration = ColourCalibration.of(("N", "O"), [depths])
    np.testing.assert_allclose(calibration.gains, GAINS[:2], rtol=0.01)
    pixels = np.array([[60, 45], [40, 45]])  # the same place, 0.4 m nearer to the middle for O
    found = calibration.of_pixels(depths, np.array([0, 1]), pixels)
    np.testing.assert_allclose(found[0], found[1], atol=2.0)
    raw = ColourCalibration.none(("N", "O")).of_pixels(depths, np.array([0, 1]), pixels)
    assert np.abs(raw[0] - raw[1]).max() > 8.0
