"""Predicted points have honest errors and do not creep; curves go through all places of a click."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.predict import (
    epipolar_curve,
    in_image,
    predicted_point,
    ray_in_volume,
    volume_in_sight,
)
from stereotrack_core.depth.points import Volume
from tests.annotation.scenes import LENSES, VOLUME, cameras

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


pixels = st.tuples(st.floats(0, 639), st.floats(0, 479)).map(np.array)


def distance_to_line(point, line):
    """Least distance of a point (2,) from a line of points (K, 2)."""
    if len(line) == 1:
        return np.linalg.norm(point - line[0])
    start, step = line[:-1], np.diff(line, axis=0)
    length = np.maximum(np.einsum("ki,ki->k", step, step), 1e-12)
    share = np.clip(np.einsum("ki,ki->k", point - start, step) / length, 0, 1)
    return np.linalg.norm(start + share[:, None] * step - point, axis=1).min()


@pytest.mark.parametrize("lens", LENSES)
@settings(max_examples=30)
@given(pixel=pixels, share=st.floats(0, 1), names=st.permutations("NOSW"))
def test_curve_goes_through_every_point_of_the_ray(lens, pixel, share, names):
    rig = cameras(lens)
    one, two = rig[names[0]], rig[names[1]]
    direction = one.rays_world(pixel)
    near, far = ray_in_volume(one.position_world, direction, VOLUME)
    assume(far > near)
    point = one.position_world + (near + share * (far - near)) * direction
    seen = two.project(point)
    assume(in_image(two, seen) and min(*seen, *(two.width, two.height) - seen) > 3)
    curve = epipolar_curve(one, pixel, two, VOLUME)
    assert distance_to_line(seen, curve) < 0.1
    assert in_image(two, curve)[1:-1].all()


def test_volume_out_of_sight_is_put_where_the_cameras_look():
    far = Volume(VOLUME.low + 50.0, VOLUME.high + 50.0)
    found = volume_in_sight(far, tuple(cameras().values()))
    assert np.allclose(found.high - found.low, VOLUME.high - VOLUME.low)
    assert np.allclose(0.5 * (found.low + found.high), [0.0, 0.0, 1.1], atol=0.1)
    one = cameras()["N"]
    alone = volume_in_sight(far, (one,))
    assert in_image(one, one.project(0.5 * (alone.low + alone.high)))
