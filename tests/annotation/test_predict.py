"""Predicted points: where the clicks' rays meet, with honest errors, and without creeping."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.predict import predicted_point
from tests.annotation.scenes import LENSES, cameras

places = st.tuples(*3 * [st.floats(-0.5, 0.5)]).map(lambda p: np.array(p) + [0, 0, 1.1])


def clicked(rig, world, names, sigma=0.0, seed=0):
    rng = np.random.default_rng(seed)
    pixels = {name: rig[name].project(world) + rng.normal(0, sigma, 2) for name in names}
    return [Click(5, name, "left_elbow", (float(x), float(y))) for name, (x, y) in pixels.items()]


@pytest.mark.parametrize("lens", LENSES)
@settings(max_examples=30)
@given(world=places, names=st.permutations("NOSW"), count=st.integers(2, 4))
def test_exact_clicks_give_their_point(lens, world, names, count):
    rig = cameras(lens)
    found = predicted_point(rig, clicked(rig, world, names[:count]))
    assert np.allclose(found.world, world, atol=1e-5)
    assert found.rms_px < 1e-3
    assert set(found.used) == set(names[:count])
    for name, pixel in found.pixel.items():
        assert np.allclose(pixel, rig[name].project(world), atol=1e-2)


def test_one_click_predicts_nothing():
    rig = cameras()
    assert predicted_point(rig, clicked(rig, np.array([0, 0, 1.0]), "N")) is None
    assert predicted_point(rig, []) is None


def test_outside_deleted_and_foreign_clicks_take_no_part():
    rig = cameras()
    world = np.array([0.1, -0.1, 1.2])
    n, o, s, w = clicked(rig, world, "NOSW", sigma=2.0)
    outside = replace(s, position=None, visibility=Visibility.OUTSIDE)
    gone = replace(w, position=(0.0, 0.0), deleted=True)
    foreign = replace(w, camera="X")
    both = predicted_point(rig, [n, o])
    assert np.array_equal(predicted_point(rig, [n, o, outside, gone, foreign]).world, both.world)
    assert predicted_point(rig, [n, outside, gone]) is None


def test_covariance_is_that_of_repeated_clicks():
    rig = cameras()
    world = np.array([0.2, 0.1, 1.3])
    found = [
        predicted_point(rig, clicked(rig, world, "NOW", 2.0, k), sigma=2.0) for k in range(150)
    ]
    errors = np.array([one.world - world for one in found])
    mahalanobis = [
        e @ np.linalg.solve(one.covariance, e) for e, one in zip(errors, found, strict=True)
    ]
    assert np.mean(np.array(mahalanobis) < 7.815) > 0.92  # 95 percent of chi squared, 3 degrees
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.007, abs=0.003)


def test_error_of_a_click_is_its_distance_from_what_the_others_say():
    rig = cameras()
    world = np.array([0.0, 0.2, 1.0])
    n, o, s = clicked(rig, world, "NOS")
    moved = replace(n, position=(n.position[0] + 9.0, n.position[1]))
    found = predicted_point(rig, [moved, o, s])
    assert found.error_px["N"] == pytest.approx(9.0, abs=1e-3)
    assert np.allclose(found.pixel["N"], n.position, atol=1e-3)


def test_error_of_two_clicks_is_counted_from_the_curves():
    rig = cameras()
    n, o = clicked(rig, np.array([0.0, 0.0, 1.1]), "NO")
    # Both cameras are at the same height and look alike, so a click that slides along its curve
    # contradicts nothing, and one that goes across it contradicts by the whole way.
    across = replace(n, position=(n.position[0], n.position[1] + 8.0))
    found = predicted_point(rig, [across, o])
    assert 6.0 < found.error_px["N"] <= 8.0
    assert found.rms_px == pytest.approx(
        np.sqrt(np.mean(np.square([found.error_px["N"], found.error_px["O"]])))
    )


def test_outlier_is_an_outlier_and_does_not_move_the_point():
    rig = cameras()
    world = np.array([0.1, 0.0, 1.4])
    clicks = clicked(rig, world, "NOSW", 1.0)
    x, y = clicks[2].position
    clicks[2] = replace(clicks[2], position=(x + 50, y - 40))
    found = predicted_point(rig, clicks, sigma=2.0)
    assert found.outliers == ("S",)
    assert found.error_px["S"] == pytest.approx(64, abs=6)
    assert np.linalg.norm(found.world - world) < 0.012


@pytest.mark.parametrize("hand", ["NO", "NOS", "NSW"])
def test_accepting_a_hundred_times_does_not_creep(hand):
    rig = cameras()
    clicks = {c.camera: c for c in clicked(rig, np.array([0.3, 0.1, 1.3]), hand, 4.0, seed=3)}
    first = predicted_point(rig, clicks.values())
    for _ in range(100):
        found = predicted_point(rig, clicks.values())
        for name in set(rig) - set(hand):
            x, y = found.pixel[name]
            clicks[name] = Click(5, name, "left_elbow", (float(x), float(y)), origin="accepted")
    assert np.linalg.norm(found.world - first.world) < 1e-9
    for name in rig:
        assert np.allclose(found.pixel[name], first.pixel[name], atol=1e-6)
    assert found.used == tuple(hand)
    assert np.allclose(found.covariance, first.covariance)
