"""Predicted points: where the clicks' rays meet, with honest errors, and without creeping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
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


def test_clicks_of_several_landmarks_are_refused():
    rig = cameras()
    one, two = clicked(rig, np.array([0, 0, 1.0]), "NO")
    with pytest.raises(ValueError, match="several"):
        predicted_point(rig, [one, replace(two, landmark="head")])


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
        predicted_point(rig, clicked(rig, world, "NOW", 2.0, k), sigma=2.0) for k in range(300)
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


def test_sigma_of_a_click_is_its_weight():
    rig = cameras()
    world = np.array([0.0, 0.0, 1.2])
    clicks = clicked(rig, world, "NOS")
    x, y = clicks[0].position
    off = replace(clicks[0], position=(x + 6.0, y + 6.0))
    sure = predicted_point(rig, [replace(off, sigma=1.0), *clicks[1:]], sigma=2.0)
    doubted = predicted_point(rig, [replace(off, sigma=20.0), *clicks[1:]], sigma=2.0)
    assert np.linalg.norm(doubted.world - world) < 0.2 * np.linalg.norm(sure.world - world)


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


def test_accepting_with_a_single_click_of_a_person_does_not_creep():
    rig = cameras()
    n, o = clicked(rig, np.array([0.3, 0.1, 1.3]), "NO", 4.0)
    clicks = {"N": n, "O": replace(o, origin="accepted")}
    worlds = []
    for _ in range(100):
        found = predicted_point(rig, clicks.values())
        worlds.append(found.world)
        for name in "SW":
            x, y = found.pixel[name]
            clicks[name] = Click(5, name, "left_elbow", (float(x), float(y)), origin="accepted")
    # Four clicks are weighed against each other and two are not: it settles, and less and less.
    ways = np.linalg.norm(np.array(worlds) - worlds[0], axis=1)
    assert ways.max() < 1e-6
    assert np.linalg.norm(worlds[-1] - worlds[-2]) < 1e-9


def test_nearly_parallel_rays_say_how_little_is_known():
    rig = cameras()
    right = rig["N"]
    near = replace(right.camera_from_world, translation=right.camera_from_world.translation + 0.001)
    left = replace(right, name="L", camera_from_world=near)
    found = predicted_point(
        {"N": right, "L": left}, clicked({"N": right, "L": left}, np.array([0.0, 0, 1.1]), "NL")
    )
    assert found is None or np.sqrt(np.linalg.norm(found.covariance, 2)) > 1.0
