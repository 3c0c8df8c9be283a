"""Clicks and measured points as residuals, through real lenses."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.annotation.fit.residuals import (
    ClickResidual,
    undistorted_clicks,
)
from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.pose import PartFrames
from tests.annotation.fit.scenes import BODY, CAMERAS, clicked, places, pose

FISHEYE = dataclasses.replace(
    CAMERAS["N"], fisheye=True, distortions=np.array([0.05, -0.01, 0.002, 0.0])
)
RIGS = {"distorted": CAMERAS, "fisheye": {**CAMERAS, "N": FISHEYE}}


def stacked(frames):
    return PartFrames(frames.rotations[None], frames.origins[None])


@pytest.mark.parametrize("rig", RIGS)
def test_near_a_click_differences_are_raw_pixels(rig):
    cameras = RIGS[rig]
    freedom = Freedom(NINE, BODY, with_depth=False)
    points, rng = places(0), np.random.default_rng(0)
    clicks = [
        dataclasses.replace(one, position=tuple(cameras[one.camera].project(points[i % 9]) + off))
        for i, one in enumerate(clicked(0, rng))
        for off in [rng.normal(0, 1.0, 2)]
    ]
    found = undistorted_clicks(clicks, cameras, NINE.names)
    row = ClickResidual(found, freedom, freedom.local, np.ones(72))
    away = row.measured - row.predicted(stacked(BODY.frames(pose(0))))[0]
    truly = [
        np.array(one.position) - cameras[one.camera].project(points[i % 9])
        for i, one in enumerate(clicks)
    ]
    np.testing.assert_allclose(away.reshape(-1, 2), truly, atol=0.02)


@given(st.integers(0, 2**16))
def test_clicks_move_as_their_derivatives_say(seed):
    freedom = Freedom(NINE, BODY, with_depth=False)
    rng = np.random.default_rng(seed)
    clicks = undistorted_clicks(clicked(0, rng), CAMERAS, NINE.names)
    state = freedom.displaced(freedom.still(pose(0)), 0.03 * rng.normal(size=freedom.columns.n))

    def row(at: FitState) -> ClickResidual:
        return ClickResidual(clicks, freedom, freedom.own_place(at.offsets), np.ones(72))

    def drawn(at: FitState) -> np.ndarray:
        return row(at).predicted(stacked(freedom.body_at(at.offsets).frames(at.pose)))[0]

    frames = freedom.body_at(state.offsets).frames(state.pose)
    J = row(state).jacobian(frames)
    step = 1e-6
    for column in rng.choice(freedom.columns.n, 8, replace=False):
        delta = np.zeros(freedom.columns.n)
        delta[column] = step
        change = drawn(freedom.displaced(state, delta)) - drawn(freedom.displaced(state, -delta))
        np.testing.assert_allclose(J[:, column], change / (2 * step), rtol=1e-4, atol=1e-3)
