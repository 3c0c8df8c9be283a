from contextlib import nullcontext

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.match import STEPS, DisparityRange, Matcher
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import range_of_disparity, thinned_pixels
from stereotrack_core.depth.rectify import depth_rectification, stereo_rectification
from stereotrack_core.errors import InputError
from tests.depth.scenes import camera, texture

BARREL = (-0.25, 0.06, 0.001, -0.0007, 0.01)


def _is_identity(rectification):
    return rectification.left_map is None and rectification.image_map is None


def rig(**kinds):
    """A convergent, rolled pair with different lenses, principal points and focal lengths."""
    left = camera(
        "left", (-0.12, 0.01, 1.005), (0.01, -0.04, 0.012),
        focal=(405, 403), principal=(170, 116), distortions=BARREL,
    )  # fmt: skip
    right = camera(
        "right", (0.0, 0.0, 1.0), (-0.012, 0.05, -0.008),
        focal=(398, 399), principal=(150, 124), distortions=(-0.22, 0.05, -0.001, 0.0005),
    )  # fmt: skip
    return left, right


def rectified_pixels(rectification, cameras, raw):
    """Where the rectified image shows what the raw image shows at `raw`, by inverting the map."""
    geometry = rectification.geometry
    rays = cameras.rays_world(raw) @ geometry.world_from_depth.rotation
    offset = geometry.disparity_offset if cameras.name == "left" else 0.0
    return np.stack(
        [
            geometry.focal * rays[:, 0] / rays[:, 2] + geometry.c_x + offset,
            geometry.focal * rays[:, 1] / rays[:, 2] + geometry.c_y,
        ],
        axis=1,
    )


def seen_points(left, right, count=300, seed=1):
    rng = np.random.default_rng(seed)
    points = rng.uniform((-0.8, 1.5, 0.4), (0.7, 4.0, 1.6), (count, 3))
    pixels = np.stack([left.project(points), right.project(points)])
    inside = ((pixels > 2) & (pixels < (317, 237))).all(axis=(0, 2))
    return points[inside], pixels[:, inside]


def test_epipolar_error_and_triangulation_of_a_convergent_distorted_rig():
    left, right = rig()
    points, (in_left, in_right) = seen_points(left, right)
    assert len(points) > 80
    rectification = stereo_rectification(left, right)
    in_l = rectified_pixels(rectification, left, in_left)
    in_r = rectified_pixels(rectification, right, in_right)
    assert np.abs(in_l[:, 1] - in_r[:, 1]).max() < 0.1
    g = rectification.geometry
    z = g.focal * g.baseline / (in_l[:, 0] - in_r[:, 0] - g.disparity_offset)
    x, y = (in_r[:, 0] - g.c_x) / g.focal * z, (in_r[:, 1] - g.c_y) / g.focal * z
    found = g.world_from_depth.apply(np.stack([x, y, z], axis=1))
    assert np.linalg.norm(found - points, axis=1).max() < 1e-3


def matched_wall(rectification, left, right):
    """Points of a textured wall, rendered raw by its rays, matched when rectified."""
    wall, g = texture(900, 1200, seed=3), rectification.geometry
    in_l = rectification.left_map.apply(render_wall(left, wall))
    in_r = rectification.image_map.apply(render_wall(right, wall))
    assert in_r.shape == (g.height, g.width)
    disparities = DisparityRange(int(np.floor(g.disparity_offset)) + 1, 48)
    steps = Matcher(DepthParameters(), disparities)(in_l, in_r)
    d = np.where(steps > disparities.invalid, steps / STEPS, np.nan).astype(np.float32)
    d[rectification.image_map.outside] = np.nan
    pixels = thinned_pixels(np.isfinite(d), 3, (0, 0))
    ranges = range_of_disparity(g, d)[pixels[:, 1], pixels[:, 0]]
    return g.points(*pixels.T, ranges.astype(np.float64))


def test_images_of_a_convergent_rig_match_along_rows():
    left, right = rig()
    points = matched_wall(stereo_rectification(left, right), left, right)
    assert len(points) > 1500
    assert abs(np.median(points[:, 1]) - WALL) < 0.01
    assert np.percentile(np.abs(points[:, 1] - WALL), 90) < 0.05


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.01, 0.02, 0.0)])
def test_pictures_of_wide_lenses_are_enlarged(turn):
    """Through real pixels as well: the wall stays where it is, and shows more points."""
    kinds = {"focal": (200.0, 200.0)}
    left, right = camera("left", (-0.12, 0, 1), **kinds), camera("right", (0, 0, 1), turn, **kinds)
    rectification = stereo_rectification(left, right, least_focal=300.0)
    g = rectification.geometry
    assert (g.focal, g.width, g.height) == (pytest.approx(300.0), 480, 360)
    points, (in_left, in_right) = seen_points(left, right)
    in_l = rectified_pixels(rectification, left, in_left)
    in_r = rectified_pixels(rectification, right, in_right)
    z = g.focal * g.baseline / (in_l[:, 0] - in_r[:, 0] - g.disparity_offset)
    assert np.allclose(z, g.world_from_depth.inverse().apply(points)[:, 2], atol=1e-3)
    found = matched_wall(rectification, left, right)
    assert len(found) > 3000
    assert abs(np.median(found[:, 1]) - WALL) < 0.02


WALL = 2.0


def render_wall(cam, wall):
    """Image of a textured wall at y = WALL; 300 texture pixels per metre."""
    pixels = np.stack(np.meshgrid(np.arange(cam.width), np.arange(cam.height)), axis=-1)
    rays = cam.rays_world(pixels.astype(float))
    hits = cam.position_world + rays * ((WALL - cam.position_world[1]) / rays[..., 1:2])
    u = (hits[..., 0] * 150 + 600).astype(np.float32)
    v = (450 - (hits[..., 2] - 1.0) * 150).astype(np.float32)
    return cv2.remap(wall, u, v, cv2.INTER_CUBIC).clip(0, 255).astype(np.uint8)


@given(st.floats(-60, 60), st.floats(-0.3, 0.3), st.floats(-3, 3), st.floats(0.05, 0.3))
@settings(max_examples=30, deadline=None)
def test_rectified_pairs_are_recognised(difference, tilt, yaw, baseline):
    """Different principal points and any place in the world leave rectified images alone."""
    right = camera("right", (1.0, 2.0, 1.4), (tilt, 0.0, 0.0))
    rotation = right.camera_from_world.rotation
    across = rotation[0]
    left = camera(
        "left", tuple(right.position_world - baseline * across), (tilt, 0.0, 0.0),
        principal=(159.5 + difference, 119.5),
    )  # fmt: skip
    rectification = stereo_rectification(left, right)
    assert _is_identity(rectification)
    assert rectification.geometry.disparity_offset == pytest.approx(difference)
    assert rectification.geometry.baseline == pytest.approx(baseline)
    assert np.allclose(rectification.geometry.world_from_depth.rotation, rotation.T, atol=1e-9)


def test_fisheye_pairs_are_rectified():
    kinds = {"fisheye": True, "distortions": (0.05, -0.01, 0.002, 0.0), "focal": (190.0, 190.0)}
    left = camera("left", (-0.12, 0, 1), (0.0, -0.02, 0.01), **kinds)
    right = camera("right", (0, 0, 1), (0.01, 0.02, 0.0), **kinds)
    _, (in_left, in_right) = seen_points(left, right)
    rectification = stereo_rectification(left, right)
    in_l = rectified_pixels(rectification, left, in_left)
    in_r = rectified_pixels(rectification, right, in_right)
    assert np.abs(in_l[:, 1] - in_r[:, 1]).max() < 0.1


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ((0.12, 0.0, 1.0), "to the right"),
        ((0.0, 0.0, 1.12), "one above the other"),
        ((0.02, 0.2, 1.0), "one behind the other"),
        ((0.0, 0.0, 1.0), "same position"),
    ],
)
def test_pairs_that_cannot_be_rectified_say_why(place, words):
    with pytest.raises(InputError, match=words) as caught:
        stereo_rectification(camera("L", place), camera("R", (0.0, 0.0, 1.0)), where="view N")
    assert caught.value.where == "view N"
    assert caught.value.remedy


def test_distorted_depth_views_are_resampled_without_mixing_ranges():
    cam = camera("K", (0, 0, 1), distortions=BARREL)
    rectification = depth_rectification(cam)
    depth = np.where(np.arange(320) < 160, 1.0, 3.0) * np.ones((240, 1))
    resampled = rectification.image_map.apply_nearest(depth.astype(np.float32))
    assert set(np.unique(resampled[np.isfinite(resampled)])) == {1.0, 3.0}
    edge = np.isfinite(resampled[120]) & (resampled[120] == 1.0)
    u = np.flatnonzero(edge)[-1] + 0.5
    direction = cam.normalised(np.array([159.5, 120.0]))
    g = rectification.geometry
    assert abs(g.focal * direction[0] + g.c_x - u) < 1.0


def test_maps_lead_to_the_raw_pixels_that_show_the_same_directions():
    left, right = rig()
    found = stereo_rectification(left, right, least_focal=520.0)
    g, x = found.geometry, right.position_world - left.position_world
    z = left.camera_from_world.rotation[2] + right.camera_from_world.rotation[2]
    axes = np.stack([x, np.cross(z, x), np.cross(x, np.cross(z, x))])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    np.testing.assert_allclose(g.world_from_depth.rotation, axes.T, atol=1e-12)
    focal, middle = np.mean([405.0, 403.0, 398.0, 399.0]), np.array([159.5, 119.5])
    slopes = [axes @ one.rays_world(middle) for one in (left, right)]
    centres = [middle - focal * one[:2] / one[2] for one in slopes]
    scale = 520.0 / focal
    assert g.focal == pytest.approx(520.0)
    assert g.baseline == pytest.approx(np.linalg.norm(x))
    assert (g.width, g.height) == (round(scale * 320), round(scale * 240))
    enlarged = scale * (np.array([*centres[1][:1], np.mean([c[1] for c in centres])]) + 0.5) - 0.5
    assert (g.c_x, g.c_y) == pytest.approx(tuple(enlarged))
    assert g.disparity_offset == pytest.approx(scale * (centres[0][0] - centres[1][0]))
    v, u = np.mgrid[: g.height, : g.width].astype(float)
    lefts = left, found.left_map, g.c_x + g.disparity_offset
    for one, taken, c_x in (lefts, (right, found.image_map, g.c_x)):
        rays = np.stack([(u - c_x) / 520.0, (v - g.c_y) / 520.0, np.ones_like(u)], axis=-1) @ axes
        raw = one.project(one.position_world + rays)
        parts = np.stack([taken.fractions % 32, taken.fractions // 32], axis=-1)
        known = taken.positions + parts / 32
        near = np.abs(raw) < 500.0
        np.testing.assert_allclose(known[near], raw[near], atol=0.02)
        outside = ((raw < 0.0) | (raw > [319.0, 239.0])).any(axis=-1)
        assert 0.01 < outside.mean() < 0.5
        np.testing.assert_array_equal(taken.outside, outside)
        assert np.abs(taken.nearest[near] - raw[near]).max() <= 0.51


@pytest.mark.parametrize(
    ("least", "focal"),
    [(0.0, 200.0), (248.0, 200.0), (252.0, 252.0), (390.0, 390.0), (900.0, 400.0)],
)
def test_pictures_are_enlarged_by_a_quarter_at_least_and_to_twice_at_most(least, focal):
    kinds = {"focal": (200.0, 200.0)}
    left, right = camera("left", (-0.12, 0, 1), **kinds), camera("right", (0, 0, 1), **kinds)
    found = stereo_rectification(left, right, least_focal=least)
    assert found.geometry.focal == pytest.approx(focal)
    assert _is_identity(found) == (focal == 200.0)


@pytest.mark.parametrize(("off", "unchanged"), [(0.015, True), (0.025, False)])
def test_what_is_a_fiftieth_of_a_pixel_off_is_rectified_already(off, unchanged):
    left = camera("left", (-0.12, 0, 1), principal=(159.5, 119.5 + 2.0 * off))
    assert _is_identity(stereo_rectification(left, camera("right", (0, 0, 1)))) == unchanged
    alone = depth_rectification(camera("K", (0, 0, 1), focal=(400.0, 400.0 + off * 400.0 / 119.5)))
    assert (alone.image_map is None) == unchanged


@pytest.mark.parametrize(
    ("apart", "degrees", "refused"),
    [(0.0009, 0.0, True), (0.0011, 0.0, False), (0.12, 59.0, False), (0.12, 61.0, True)],
)
def test_cameras_of_a_pair_are_a_millimetre_apart_and_look_the_same_way(apart, degrees, refused):
    left = camera("L", (-apart, 0.0, 1.0))
    right = camera("R", (0.0, 0.0, 1.0), (np.radians(degrees), 0.0, 0.0))
    with pytest.raises(InputError) if refused else nullcontext():
        stereo_rectification(left, right)
