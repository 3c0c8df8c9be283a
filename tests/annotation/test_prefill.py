"""Predictions come from fits, runs, neighbours and following, and say how certain they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.follow import Followed, FollowedClick
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.prefilling import (
    from_fit,
    from_following,
    from_neighbours,
    from_run,
)
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import Run
from tests.annotation.fits import fit_of
from tests.annotation.scenes import bodies, cameras

RIG = cameras()


def click(frame, x, y=50.0, **facts):
    return Click(frame, "N", "left_elbow", (x, y), **facts)


def run_of(points):
    frames = len(points)
    return Run(
        frame=np.arange(frames),
        landmarks=points,
        x=np.zeros((frames, 1)),
        P=np.zeros((frames, 1, 1)),
        state_names=("torso_x",),
        tracked=np.isfinite(points).any(axis=(1, 2)),
        unexplained_fraction=np.zeros(frames),
        residual=np.zeros(frames),
        innovation=np.zeros(frames),
        limb_sigma_deg=np.full((frames, 6), 5.0),
        limb_lost=np.zeros((frames, 6)),
        seconds=np.zeros((frames, 0)),
        stage_names=(),
        meta={},
    )


def test_fit_is_projected_into_every_image_that_shows_it():
    points = bodies(6)
    found = {one.key: one for one in from_fit(fit_of(points, [0, 5], unknown=[3]), RIG)}
    assert {key.frame for key in found} == {0, 1, 2, 4, 5}
    for name, camera in RIG.items():
        for place, landmark in enumerate(NINE.names):
            expected = camera.project(points[2, place])
            assert found[ClickKey(2, name, landmark)].position == pytest.approx(tuple(expected))
    known = [one for one in found.values() if one.key.landmark == "left_hand"]
    at_click = np.mean([one.sigma for one in known if one.frame in (0, 5)])
    between = np.mean([one.sigma for one in known if one.frame in (2, 4)])
    assert 1.0 < at_click < 4.0 < between  # 10 mm at about 2.8 m and 520 px, and what is unsure


def test_run_is_projected_where_it_is_tracked():
    points = bodies(4)
    points[2] = np.nan
    points[3, LANDMARKS.index("left_hand")] = np.nan
    found = list(from_run(run_of(points), "accurate", RIG))
    assert {one.source for one in found} == {"run accurate"}
    assert {one.frame for one in found} == {0, 1, 3}
    assert not any(one.frame == 3 and one.landmark == "left_hand" for one in found)
    assert all(one.sigma > 2 for one in found)
    assert not list(from_run(run_of(points + [0, 0, 50.0]), "accurate", RIG))


def test_neighbours_are_joined_straight():
    found = list(from_neighbours([click(4, 30.0), click(0, 10.0)], sigma=2.0))
    assert [(one.frame, one.position) for one in found] == [
        (1, (15.0, 50.0)),
        (2, (20.0, 50.0)),
        (3, (25.0, 50.0)),
    ]
    assert found[1].sigma > found[0].sigma > 2.0
    assert {one.source for one in found} == {"neighbours"}


def test_nothing_is_filled_in_over_gaps_long_stretches_and_what_is_outside():
    ends = [click(0, 10.0), click(6, 40.0)]
    assert len(list(from_neighbours(ends))) == 5
    assert not list(from_neighbours(ends, gaps=[range(3, 4)]))
    assert len(list(from_neighbours(ends, gaps=[range(6, 9)]))) == 5
    assert not list(from_neighbours(ends, longest=4))
    outside = Click(3, "N", "left_elbow", None, Visibility.OUTSIDE)
    assert not list(from_neighbours([*ends, outside]))
    assert len(list(from_neighbours([*ends, replace(outside, deleted=True)]))) == 5


def followed(from_click, frames, pixels, spread, reliable):
    count = len(frames)
    return FollowedClick(
        from_click,
        np.array(frames),
        Followed(
            np.array(pixels), np.ones(count), np.zeros(count), np.array(spread), reliable, "end"
        ),
    )


def test_following_counts_as_far_as_it_is_reliable():
    one = followed(click(0, 10.0), [0, 1, 2], [[10, 50], [12, 50], [90, 90]], [0, 1, 2], 2)
    found = list(from_following([one], sigma=2.0))
    assert [one.frame for one in found] == [1]
    assert found[0].position == pytest.approx((12.0, 50.0))
    assert found[0].sigma == pytest.approx(np.sqrt(5.0))


def test_following_from_both_sides_is_averaged_unless_it_contradicts():
    ahead = followed(
        click(0, 10.0), [0, 1, 2, 3], [[10, 50], [12, 50], [14, 50], [60, 50]], [0, 1, 2, 3], 4
    )
    back = followed(
        click(4, 18.0), [4, 3, 2, 1], [[18, 50], [16, 50], [15, 50], [12, 50]], [0, 1, 2, 3], 4
    )
    found = {one.frame: one for one in from_following([ahead, back], sigma=1.0)}
    assert set(found) == {1, 2}
    assert found[2].position[0] == pytest.approx(14.5)
    assert found[2].sigma == pytest.approx(np.sqrt(5.0 / 2))
