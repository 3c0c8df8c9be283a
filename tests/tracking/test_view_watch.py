"""Views that contradict the others are left out, and used again once they agree."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking import view_watch
from stereotrack_core.tracking.view_watch import ViewWatch, views_left_out
from tests.tracking.scenes import POSES
from tests.tracking.views import cloud_of_body

BODY, POSE = body_model(AVERAGE), POSES["t"]
FRAMES = range(0, 90, 3)
KNOCKED = Pose(POSE.position + [0.0, 0.07, 0.05], POSE.rotations)
"""Where a camera that was turned sees the body."""


@pytest.fixture(scope="module")
def sound():
    return with_points(cloud_of_body(BODY, POSE))


@pytest.fixture(scope="module")
def knocked():
    return with_points(cloud_of_body(BODY, KNOCKED, "W"))


def with_points(cloud):
    """The same cloud with a point in every hundredth pixel of the person."""
    points, view = [], []
    for k, name in enumerate(cloud.view_names):
        g, z = cloud.depths[name].geometry, cloud.depths[name].range_z
        row, column = (index[::100] for index in np.nonzero(cloud.depths[name].person))
        rays = np.stack([(column - g.c_x) / g.focal, (row - g.c_y) / g.focal, np.ones(len(row))], 1)
        points.append(g.world_from_depth.apply(rays * z[row, column, None]))
        view.append(np.full(len(row), k))
    pixels = np.zeros((sum(map(len, points)), 2), dtype=np.int64)
    where = {"points": np.concatenate(points), "view": np.concatenate(view), "pixels": pixels}
    return dataclasses.replace(cloud, **where)


def with_view(cloud, other):
    """The cloud with one view's measurements from another cloud."""
    (name,), k = other.view_names, cloud.view_names.index(other.view_names[0])
    points = np.concatenate([cloud.points[cloud.view != k], other.points])
    view = np.r_[cloud.view[cloud.view != k], np.full(len(other.points), k)]
    pixels = np.zeros((len(view), 2), dtype=np.int64)
    depths = {**cloud.depths, name: other.depths[name]}
    return dataclasses.replace(cloud, points=points, view=view, pixels=pixels, depths=depths)


def watched(cloud, watch=None, frames=FRAMES):
    watch = watch or ViewWatch()
    for frame in frames:
        watch = watch.updated(dataclasses.replace(cloud, frame=frame), BODY, POSE)
    return watch


def test_views_that_agree_are_all_used(sound):
    watch = watched(sound)
    assert watch.left_out == ""
    assert watch.doubts == {}
    assert watch.trusted(sound) is sound


def test_a_view_whose_camera_was_knocked_is_left_out_until_it_agrees(sound, knocked):
    wrong = with_view(sound, knocked)
    watch = watched(wrong, watched(sound))
    assert watch.left_out == "W"
    trusted = watch.trusted(wrong)
    assert set(trusted.depths) == {"N", "E", "S"}
    assert len(trusted.points) == np.count_nonzero(wrong.view != wrong.view_names.index("W"))
    assert watched(sound, watch).left_out == ""


def test_it_is_said_which_view_and_by_how_much(sound, knocked):
    doubts = watched(with_view(sound, knocked)).doubts
    assert views_left_out(doubts) == ("W",)
    assert "mm beside the body" in doubts["W"]
    assert views_left_out({"N": "View N provides no depth: its left image is dark."}) == ()


def test_of_two_views_neither_is_known_to_be_right():
    both = with_points(cloud_of_body(BODY, POSE, "NW"))
    wrong = with_view(both, with_points(cloud_of_body(BODY, KNOCKED, "W")))
    assert watched(wrong).left_out == ""


def test_a_body_that_is_too_wide_everywhere_is_no_view_s_fault():
    wide = BODY.cones["outline"] + 0.03
    assert watched(with_points(cloud_of_body(BODY, POSE, wider=wide))).left_out == ""


@pytest.mark.parametrize(
    ("own", "others", "before", "left_out"),
    [
        pytest.param((0.035, 0.3), (0.02, 0.3), "", "N", id="contours off"),
        pytest.param((0.031, 0.3), (0.02, 0.3), "", "", id="contours off by less than 1.6"),
        pytest.param((0.026, 0.3), (0.015, 0.3), "", "", id="contours as of undisturbed views"),
        pytest.param((np.nan, 0.45), (np.nan, 0.25), "", "N", id="points unexplained"),
        pytest.param((np.nan, 0.40), (np.nan, 0.20), "", "", id="points as of undisturbed views"),
        pytest.param((0.020, 0.90), (0.020, 0.25), "", "", id="points of passers-by"),
        pytest.param((0.026, 0.3), (0.02, 0.3), "N", "N", id="not yet in agreement"),
        pytest.param((0.024, 0.3), (0.02, 0.3), "N", "", id="in agreement again"),
    ],
)
def test_a_view_is_left_out_by_its_ratio_and_by_a_least_deviation(own, others, before, left_out):
    watch = ViewWatch(tuple("NES"), judged=9, left_out=before)
    assert watch._left_out(tuple("NES"), np.array([own, others, others])) == left_out


def test_what_a_view_deviates_by_is_said_in_millimetres_and_percent():
    signs = np.array([[0.041, 0.5], [0.018, 0.2], [0.022, 0.3]])
    said = ViewWatch(tuple("NES"), signs, 9, "N").doubts["N"]
    assert "its contours lie 41 mm beside the body (20 mm in the others)" in said
    assert "50 % of its points are not explained (25 %)" in said


def test_signs_of_a_view_are_averages_over_time_that_forget_slowly(monkeypatch, sound):
    now = iter([0.02] * 4 + [0.03] * 4)
    monkeypatch.setattr(view_watch, "_signs", lambda *_: (next(now), 0.2))
    np.testing.assert_allclose(watched(sound, frames=range(6)).signs[:, 0], 0.7 * 0.02 + 0.3 * 0.03)
