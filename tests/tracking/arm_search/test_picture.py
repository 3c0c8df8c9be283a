"""What views should see of a body, against rays that are cast one by one."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.body.surface import cone_table
from stereotrack_core.tracking.arm_search.picture import (
    disagreements,
    outline_table,
    seen_pictures,
)
from tests.oracle.raycast import cast
from tests.tracking.scenes import POSES, pose_with_arms
from tests.tracking.views import HEIGHT, WIDTH, cloud_of_body, cloud_seen, solids

BODY = body_model(AVERAGE)
LIKENESS = 0.5, 0.1
OF_ARM = [np.isin(BODY.cones.part, [UPPER_ARMS[side], FOREARMS[side]]) for side in (0, 1)]


@pytest.fixture(scope="module")
def clouds():
    return {name: cloud_of_body(BODY, pose) for name, pose in POSES.items()}


def _moved(pose, by):
    return Pose(pose.position + np.asarray(by, dtype=float), pose.rotations)


def _unlike(pictures, pose, likeness=LIKENESS):
    """Pixels of all views that speak against a pose."""
    frames = BODY.frames(pose)
    chosen = ~(OF_ARM[0] | OF_ARM[1]), *OF_ARM
    tables = [outline_table(BODY.cones[which], frames) for which in chosen]
    return sum(unlike(likeness, seen, *(seen.drawn(t) for t in tables)) for seen in pictures)


def unlike(likeness, seen, rest, left, right):
    """Pixels in which one body does not look as measured."""
    return seen.unlike_pairs(rest, left[None], right[None], *likeness)[0, 0]


def _pixels_drawn(pictures, pose):
    table = outline_table(BODY.cones, BODY.frames(pose))
    return sum(np.count_nonzero(seen.drawn(table)) for seen in pictures)


def _cast_like(seen, bodies, geometry):
    """Exact ranges of the pixels of a picture that is thinned out."""
    ranges = cast(
        bodies, geometry.focal, geometry.c_x, geometry.c_y, geometry.world_from_depth, WIDTH, HEIGHT
    )
    rows = (seen.top + seen.step * np.arange(seen.measured.shape[0])).astype(int)
    columns = (seen.left + seen.step * np.arange(seen.measured.shape[1])).astype(int)
    return ranges[np.ix_(rows, columns)]


@given(
    angle=st.floats(-0.6, 0.6),
    height=st.floats(0.9, 1.5),
    aside=st.floats(-0.4, 0.4),
    r1=st.floats(0.04, 0.15),
    taper=st.floats(0.7, 1.3),
    flatness=st.floats(0.6, 1.0),
)
@settings(max_examples=40)
def test_the_middle_of_a_cone_is_drawn_where_rays_hit_it(angle, height, aside, r1, taper, flatness):
    """A cone across the line of sight: the taper and the slant alone are neglected."""
    turn = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    origin = np.array([aside, 0.0, height])
    cones = dataclasses.replace(
        BODY.cones[:1],
        r1=np.array([r1]),
        r2=np.array([r1 * taper]),
        height=np.array([0.4]),
        flatness=np.array([flatness]),
    )
    placed = dataclasses.replace(
        placed_cones(BODY, BODY.frames(POSES["t"]))[:1],
        rotations=turn[None],
        origins=origin[None],
        cones=cones,
    )
    bodies = solids(placed)
    cloud = cloud_seen(bodies, "N")
    (seen,) = seen_pictures(cloud, 2)
    drawn = seen.drawn(cone_table(placed))
    exact = _cast_like(seen, bodies, cloud.depths["N"].geometry)
    middle = _near_axis(seen, placed, 0.5 * min(r1, r1 * taper) * flatness)
    assert middle.sum() > 4
    assert np.isfinite(exact[middle]).all()
    assert (drawn[middle] > 0.0).all()
    assert abs(1.0 / drawn[middle] - exact[middle]).max() < 0.003 + 0.07 * r1 * max(1.0, taper)


def _near_axis(seen, placed, within):
    """Pixels (h, w) within some metres of the middle half of the one cone's axis."""
    ends = placed.origins[0] + np.outer(
        [0.25, 0.75], placed.cones.height * placed.rotations[0, :, 2]
    )
    R, t = seen.camera_from_world[:, :3], seen.camera_from_world[:, 3]
    there = ends @ R.T + t
    image = seen.pinhole[0] * there[:, :2] / there[:, 2:] + seen.pinhole[1:]
    h, w = seen.measured.shape
    v, u = np.mgrid[:h, :w] * seen.step
    at = np.stack([u + seen.left, v + seen.top], axis=-1)
    along = image[1] - image[0]
    share = np.clip((at - image[0]) @ along / (along @ along), 0.0, 1.0)
    off = np.linalg.norm(at - image[0] - share[..., None] * along, axis=-1)
    inside = (share > 0.0) & (share < 1.0)
    return inside & (off < within * seen.pinhole[0] / there[:, 2].mean())


@pytest.mark.parametrize("name", POSES)
def test_a_body_is_drawn_where_rays_hit_it(clouds, name):
    frames = BODY.frames(POSES[name])
    for seen, depth in zip(
        seen_pictures(clouds[name], 3), clouds[name].depths.values(), strict=True
    ):
        drawn = seen.drawn(outline_table(BODY.cones, frames))
        bodies = solids(placed_cones(BODY, frames), BODY.cones.outline)
        exact = _cast_like(seen, bodies, depth.geometry)
        both = (drawn > 0.0) & np.isfinite(exact)
        either = (drawn > 0.0) | np.isfinite(exact)
        assert both.sum() > 0.85 * either.sum()
        off = abs(1.0 / drawn[both] - exact[both])
        assert np.median(off) < 0.01
        assert np.quantile(off, 0.85) < 0.05


def test_nearer_cones_hide_farther_ones(clouds):
    (seen, *_) = seen_pictures(clouds["reaching"], 3)
    frames = BODY.frames(POSES["reaching"])
    each = [
        seen.drawn(outline_table(BODY.cones[c : c + 1], frames)) for c in range(len(BODY.cones))
    ]
    together = seen.drawn(outline_table(BODY.cones, frames))
    np.testing.assert_array_equal(together, np.max(each, axis=0))


def test_cones_behind_the_camera_are_not_drawn(clouds):
    for seen in seen_pictures(clouds["t"], 3):
        behind = _moved(POSES["t"], 2.0 * (seen.eye - POSES["t"].position))
        assert not seen.drawn(outline_table(BODY.cones, BODY.frames(behind))).any()


def test_a_table_is_as_thick_as_the_outline_and_never_vanishes():
    frames = BODY.frames(POSES["t"])
    plain = cone_table(placed_cones(BODY, frames))
    table = outline_table(BODY.cones, frames)
    np.testing.assert_allclose(table[:, 12:14], plain[:, 12:14] + BODY.cones.outline[:, :1])
    thin = dataclasses.replace(BODY.cones, outline=BODY.cones.outline - 1.0)
    table = outline_table(thin, frames)
    np.testing.assert_array_equal(table[:, 12:14], 0.01)


@pytest.mark.parametrize("name", POSES)
def test_the_true_pose_looks_as_measured(clouds, name):
    pictures = seen_pictures(clouds[name], 3)
    assert _unlike(pictures, POSES[name]) < 0.2 * _pixels_drawn(pictures, POSES[name])


@given(name=st.sampled_from(sorted(POSES)), angle=st.floats(0.0, 2.0 * np.pi))
@settings(max_examples=20)
def test_who_stands_elsewhere_looks_different_the_more_the_farther(clouds, name, angle):
    pictures, way = seen_pictures(clouds[name], 3), np.array([np.cos(angle), np.sin(angle), 0.0])
    costs = [_unlike(pictures, _moved(POSES[name], r * way)) for r in (0.0, 0.06, 0.15, 0.4)]
    assert costs == sorted(costs)
    assert costs[-1] > 3.0 * costs[0]


def test_an_arm_elsewhere_looks_different(clouds):
    pictures = seen_pictures(clouds["t"], 3)
    costs = [
        _unlike(pictures, pose_with_arms([1, 0, -up], [1, 0.05, -up], [-1, 0, 0], [-1, 0.05, 0]))
        for up in (0.0, 0.15, 0.4, 1.0)
    ]
    assert costs == sorted(costs)
    assert costs[2] > 1.5 * costs[0]


def _disagreement(rest, left, right, *as_seen):
    pixels = np.empty((1, 1))
    disagreements(rest, left[None], right[None], *as_seen, pixels)
    return pixels[0, 0]


def _pixel(model, measured, person, *, sigma=0.5, unknown=0.1, scale=100.0):
    nothing = np.zeros((1, 1), dtype=np.float32)
    return _disagreement(
        np.full((1, 1), model, dtype=np.float32),
        nothing,
        nothing,
        np.full((1, 1), measured, dtype=np.float32),
        np.full((1, 1), person, dtype=np.int8),
        scale,
        sigma**2,
        unknown,
    )


@pytest.mark.parametrize(
    ("model", "measured", "person", "expected"),
    [
        (0.0, 0.0, 0, 0.0),  # nobody is drawn, nobody is there
        (0.0, 0.4, 1, 1.0),  # somebody is there who is not drawn
        (0.0, 0.0, 1, 1.0),
        (0.4, 0.0, 0, 1.0),  # drawn before the empty scene
        (0.4, 0.2, 0, 1.0),
        (0.4, 0.4, 1, 0.0),  # as measured
        (0.4, 0.0, 1, 0.1),  # the range is not known
        (0.4, 0.405, 1, 0.5),  # half a pixel of disparity counts half
        (0.4, 0.2, 1, 20.0**2 / (20.0**2 + 0.25)),
    ],
)
def test_what_a_pixel_counts(model, measured, person, expected):
    assert _pixel(model, measured, person) == pytest.approx(expected, abs=1e-4)


@given(st.floats(0.2, 1.0), st.floats(0.2, 1.0))
def test_a_pixel_counts_between_nothing_and_one_either_way(a, b):
    assert 0.0 <= _pixel(a, b, 1) <= 1.0
    assert _pixel(a, b, 1) == pytest.approx(_pixel(b, a, 1), abs=1e-5)


def test_the_nearest_of_trunk_and_arms_is_what_a_view_sees():
    far, near = (np.full((2, 2), value, dtype=np.float32) for value in (0.3, 0.5))
    person = np.ones((2, 2), dtype=np.int8)
    for order in ((near, far, far), (far, near, far), (far, far, near)):
        assert _disagreement(*order, near, person, 100.0, 0.25, 0.1) == 0.0
        assert _disagreement(*order, far, person, 100.0, 0.25, 0.1) > 3.9


def test_pixels_without_a_range_count_a_little(clouds):
    depths = {
        name: dataclasses.replace(depth, range_z=np.full_like(depth.range_z, np.nan))
        for name, depth in clouds["t"].depths.items()
    }
    pictures = seen_pictures(dataclasses.replace(clouds["t"], depths=depths), 3)
    assert not any(seen.measured.any() for seen in pictures)
    none, some = (_unlike(pictures, POSES["t"], (0.5, share)) for share in (0.0, 0.1))
    common = sum(
        np.count_nonzero(
            (seen.drawn(outline_table(BODY.cones, BODY.frames(POSES["t"]))) > 0) & (seen.person > 0)
        )
        for seen in pictures
    )
    assert some - none == pytest.approx(0.1 * common)


def test_views_without_anybody_are_left_out(clouds):
    empty = cloud_seen([], "N").depths["N"]
    depths = {**clouds["t"].depths, "E": empty}
    assert len(seen_pictures(dataclasses.replace(clouds["t"], depths=depths), 3)) == 3
    assert seen_pictures(cloud_seen([]), 3) == ()
    specks = empty.foreground.copy()
    specks[::40, ::40] = True
    speckled = dataclasses.replace(empty, foreground=specks, outline=specks)
    assert seen_pictures(dataclasses.replace(clouds["t"], depths={"N": speckled}), 3) == ()


def test_without_outlines_the_foreground_is_the_person(clouds):
    depth = clouds["t"].depths["N"]
    known = dataclasses.replace(depth, foreground=np.zeros_like(depth.foreground))
    unknown = dataclasses.replace(depth, outline=None)
    (a,), (b,) = (
        seen_pictures(dataclasses.replace(clouds["t"], depths={"N": d}), 3)
        for d in (known, unknown)
    )
    np.testing.assert_array_equal(a.person, b.person)


@pytest.mark.parametrize("step", [1, 2, 5])
def test_pictures_are_the_images_thinned_out(clouds, step):
    depth = clouds["pointing"].depths["E"]
    seen = seen_pictures(dataclasses.replace(clouds["pointing"], depths={"E": depth}), step)[0]
    rows = int(seen.top) + step * np.arange(seen.measured.shape[0])
    columns = int(seen.left) + step * np.arange(seen.measured.shape[1])
    at = np.ix_(rows, columns)
    np.testing.assert_array_equal(seen.person, depth.outline[at])
    np.testing.assert_allclose(seen.measured, 1.0 / depth.range_z[at], rtol=1e-6)
    assert seen.person.sum() * step**2 == pytest.approx(depth.outline.sum(), rel=0.1)


def test_a_pixel_shows_more_of_what_is_farther(clouds):
    for step in (1, 3):
        seen = seen_pictures(clouds["t"], step)[0]
        axis = seen.camera_from_world[2, :3]
        for depth in (2.0, 4.0):
            assert seen.area(seen.eye + depth * axis) == pytest.approx((step * depth / 400.0) ** 2)


def test_disparities_of_depth_cameras_are_as_fine_as_of_a_stereo_camera(clouds):
    depth = clouds["t"].depths["N"]
    still = dataclasses.replace(depth, geometry=dataclasses.replace(depth.geometry, baseline=0.0))
    (stereo,), (camera,) = (
        seen_pictures(dataclasses.replace(clouds["t"], depths={"N": d}), 3) for d in (depth, still)
    )
    assert stereo.scale == 100.0
    assert camera.scale == 75.0
