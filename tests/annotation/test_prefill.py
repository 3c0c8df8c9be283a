"""Predictions come from fits and runs, and say how certain they are."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.prefilling import (
    from_fit,
    from_run,
)
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import Run
from tests.annotation.fits import fit_of
from tests.annotation.scenes import bodies, cameras

RIG = cameras()


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
    found = {one.key: one for one in from_fit(fit_of(points, [0, 5], unknown=[3]), RIG, range(9))}
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
    found = list(from_run(run_of(points), "accurate", RIG, NINE, range(9)))
    assert {one.source for one in found} == {"run accurate"}
    assert {one.frame for one in found} == {0, 1, 3}
    assert not any(one.frame == 3 and one.landmark == "left_hand" for one in found)
    assert all(one.sigma > 2 for one in found)
    assert not list(from_run(run_of(points + [0, 0, 50.0]), "accurate", RIG, NINE, range(9)))
