"""What views should see of a body, against rays that are cast one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud, DepthGeometry, ViewDepth
from stereotrack_core.tracking.arm_search.picture import outline_cones, seen_pictures
from tests.oracle.raycast import cast
from tests.tracking.scenes import POSES, moved
from tests.tracking.views import HEIGHT, WIDTH, cloud_of_body, looking, solids

BODY = body_model(AVERAGE)
OF_ARM = [np.isin(BODY.cones["part"], [UPPER_ARMS[side], FOREARMS[side]]) for side in (0, 1)]


@pytest.fixture(scope="module")
def clouds():
    return {name: cloud_of_body(BODY, pose) for name, pose in POSES.items()}


def _unlike(pictures, pose):
    """Pixels of all views that speak against a pose."""
    frames = BODY.frames(pose)
    chosen = ~(OF_ARM[0] | OF_ARM[1]), *OF_ARM
    rest, left, right = (outline_cones(BODY, frames)[which] for which in chosen)
    return sum(seen.unlike(rest, left[None], right[None], 0.5)[0, 0] for seen in pictures)


def _pixels_drawn(pictures, pose):
    table = outline_cones(BODY, BODY.frames(pose))
    return sum(np.count_nonzero(seen.drawn(table)[0]) for seen in pictures)


def _cast_like(seen, bodies, geometry):
    """Exact ranges of the pixels of a picture that is thinned out."""
    ranges = cast(
        bodies, geometry.focal, geometry.c_x, geometry.c_y, geometry.world_from_depth, WIDTH, HEIGHT
    )
    rows = (seen.top + seen.step * np.arange(seen.measured.shape[0])).astype(int)
    columns = (seen.left + seen.step * np.arange(seen.measured.shape[1])).astype(int)
    return ranges[np.ix_(rows, columns)]


@pytest.mark.parametrize("name", POSES)
def test_a_body_is_drawn_where_rays_hit_it(clouds, name):
    frames = BODY.frames(POSES[name])
    for seen, depth in zip(
        seen_pictures(clouds[name], 3), clouds[name].depths.values(), strict=True
    ):
        drawn, _ = seen.drawn(outline_cones(BODY, frames))
        bodies = solids(placed_cones(BODY, frames), BODY.cones["outline"])
        exact = _cast_like(seen, bodies, depth.geometry)
        both = (drawn > 0.0) & np.isfinite(exact)
        either = (drawn > 0.0) | np.isfinite(exact)
        assert both.sum() > 0.85 * either.sum()
        off = abs(1.0 / drawn[both] - exact[both])
        assert np.median(off) < 0.01
        assert np.quantile(off, 0.85) < 0.05


@pytest.mark.parametrize("name", POSES)
def test_the_true_pose_looks_as_measured(clouds, name):
    pictures = seen_pictures(clouds[name], 3)
    assert _unlike(pictures, POSES[name]) < 0.2 * _pixels_drawn(pictures, POSES[name])


@given(name=st.sampled_from(sorted(POSES)), angle=st.floats(0.0, 2.0 * np.pi))
@settings(max_examples=20)
def test_who_stands_elsewhere_looks_different_the_more_the_farther(clouds, name, angle):
    pictures, way = seen_pictures(clouds[name], 3), np.array([np.cos(angle), np.sin(angle), 0.0])
    costs = [_unlike(pictures, moved(POSES[name], r * way)) for r in (0.0, 0.06, 0.15, 0.4)]
    assert costs[:3] == sorted(costs[:3])  # beyond a body's width it may as well stand anywhere
    assert costs[-1] > 3.0 * costs[0]


def _images(cones, seen):
    """Ends (2, 2), radii, inverse ranges and bulges (2,) in the picture; None behind the camera."""
    for cone in cones:
        turn, flat = cone["rotation"], cone["flatness"]
        ends = cone["origin"] + np.outer([0.0, cone["height"]], turn[:, 2])
        local = ends @ seen.camera_from_world[:, :3].T + seen.camera_from_world[:, 3]
        z, r = local[:, 2], np.array([cone["r1"], cone["r2"]])
        if z.min() < 0.3:
            yield None
            continue
        w = ((seen.eye - ends) @ turn)[:, :2]
        x, y = (w / np.linalg.norm(w, axis=1, keepdims=True)).T
        focal, centre = seen.pinhole[0], seen.pinhole[1:]
        pixels = focal * local[:, :2] / z[:, None] + centre
        yield pixels, focal * r * np.hypot(y, flat * x) / z, 1.0 / z, r * np.hypot(x, flat * y)


def _drawn(cones, seen):
    """Inverse ranges (C, h, w) of all cones; 0 beside them."""
    rows, columns = np.indices(seen.measured.shape)
    pixel = np.stack([seen.left + seen.step * columns, seen.top + seen.step * rows], axis=-1)
    found = np.zeros((len(cones), *seen.measured.shape))
    for c, image in enumerate(_images(cones, seen)):
        if image is None:
            continue
        (a, b), *ends = image
        t = np.clip((pixel - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        radius, inverse, bulge = (one[0] + t * (one[1] - one[0]) for one in ends)
        across = np.linalg.norm(pixel - a - t[..., None] * (b - a), axis=-1) / radius
        front = 1.0 / inverse - bulge * np.sqrt(np.maximum(1.0 - across**2, 0.0))
        found[c] = np.where(across < 1.0, 1.0 / front, 0.0)
    return found


def _pixel_costs(drawn, seen, sigma):
    e = seen.scale * (drawn - seen.measured)
    known = np.where(seen.measured > 0.0, e**2 / (e**2 + sigma**2), 0.1)
    return np.where(drawn == 0.0, seen.person, np.where(seen.person == 0, 1.0, known))


def _near(eye, rng):
    """A picture of noise that a camera near the body takes, each third pixel."""
    ranges = np.linalg.norm(np.subtract(eye, (0.0, 0.0, 1.2))) * rng.uniform(0.8, 1.3, (240, 320))
    ranges[rng.random(ranges.shape) < 0.2] = np.nan
    person = rng.random(ranges.shape) < 0.6
    geometry = DepthGeometry(230.0, 150.0, 130.0, 0.2, 0.0, 320, 240, looking(eye))
    depth = ViewDepth(geometry, ranges.astype(np.float32), person, person, person)
    depth.__dict__["extent"] = (40, 30, 270, 210)
    none = np.zeros(0, np.int64)
    cloud = Cloud(0, np.zeros((0, 3)), none, np.zeros((0, 2), np.int64), ("a",), {"a": depth})
    return depth, seen_pictures(cloud, 3)[0]


@pytest.mark.parametrize(("name", "eye"), [("pointing", (0.4, 1.8, 1.5)), ("t", (0.3, 0.5, 1.4))])
def test_pictures_are_drawn_and_compared_as_plain_numpy_does(name, eye, rng):
    depth, seen = _near(eye, rng)
    box = np.s_[5:234:3, 15:294:3]
    np.testing.assert_allclose(seen.measured, np.nan_to_num(1.0 / depth.range_z[box]), rtol=1e-6)
    np.testing.assert_array_equal(seen.person, depth.person[box])
    assert (seen.left, seen.top, seen.step, seen.scale) == (15.0, 5.0, 3.0, 230.0 * 0.2)
    z = seen.camera_from_world[2] @ [0.1, 0.2, 1.3, 1.0]
    assert seen.area(np.array([0.1, 0.2, 1.3])) == pytest.approx((3.0 * z / 230.0) ** 2)
    poses = [POSES[name], *(moved(POSES[name], rng.normal(0.0, 0.05, 3)) for _ in range(2))]
    frames = [BODY.frames(pose) for pose in poses]
    placed = [placed_cones(BODY, each) for each in frames]
    cones = np.stack([outline_cones(BODY, each) for each in frames])
    for end in ("r1", "r2"):
        thick = np.maximum(np.stack(placed)[end] + BODY.cones["outline"][:, 0], 0.01)
        np.testing.assert_allclose(cones[end], thick)
    drawn = [_drawn(each, seen) for each in cones]
    picture, owner = seen.drawn(cones[0])
    np.testing.assert_allclose(picture, drawn[0].max(axis=0), rtol=1e-5)
    front = np.where(picture > 0.0, BODY.cones["part"][drawn[0].argmax(axis=0)], -1)
    assert np.count_nonzero(owner != front) <= 2, "but for parts that are equally near"
    rest = ~(OF_ARM[0] | OF_ARM[1])
    found = seen.unlike(cones[0][rest], cones[:, OF_ARM[0]], cones[:, OF_ARM[1]], 1.5)
    for k, one in enumerate(drawn):
        for m, other in enumerate(drawn):
            parts = drawn[0][rest], one[OF_ARM[0]], other[OF_ARM[1]]
            together = np.concatenate(parts).max(axis=0)
            expected = _pixel_costs(together, seen, 1.5).sum()
            assert found[k, m] == pytest.approx(expected, rel=1e-5)
