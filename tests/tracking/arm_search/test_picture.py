"""What views should see of a body, against rays that are cast one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.tracking.arm_search.picture import outline_cones, seen_pictures
from tests.oracle.raycast import cast
from tests.tracking.scenes import POSES, moved
from tests.tracking.views import HEIGHT, WIDTH, cloud_of_body, solids

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


def test_a_body_looks_the_same_if_camera_and_body_are_moved_together(clouds):
    placed, by = outline_cones(BODY, BODY.frames(POSES["t"])), np.array([5.0, -4.0, 3.0])
    for seen in seen_pictures(clouds["t"], 3):
        to_camera = seen.camera_from_world.copy()
        to_camera[:, 3] -= to_camera[:, :3] @ by
        elsewhere = placed.copy()
        elsewhere["origin"] += by
        there = seen._replace(eye=seen.eye + by, camera_from_world=to_camera)
        (here, _), (drawn, _) = seen.drawn(placed), there.drawn(elsewhere)
        assert ((here > 0.0) != (drawn > 0.0)).sum() <= 2, "but for the last bit of an edge"
        assert np.median(np.abs(here - drawn)[here > 0.0]) < 1e-6
