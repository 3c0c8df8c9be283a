"""Landmarks in space although some clicks are wrong."""

from __future__ import annotations

import numpy as np

from stereotrack_core.annotation.fit.context import triangulated
from stereotrack_core.annotation.fit.residuals import undistorted_clicks
from stereotrack_core.annotation.landmark_set import NINE
from tests.annotation.fit.scenes import CAMERAS, clicked, moved_click, places


def points_of(clicks):
    return triangulated(undistorted_clicks(clicks, CAMERAS, NINE.names), 9)


def test_exact_clicks_give_exact_points():
    found = points_of(clicked(0, np.random.default_rng(0), sigma=1e-9))
    np.testing.assert_allclose(found, places(0), atol=1e-6)


def test_one_wrong_click_of_four_changes_nothing():
    clicks = list(clicked(0, np.random.default_rng(0), sigma=1e-9))
    for i in range(9):
        clicks[i] = moved_click(clicks[i], [60.0, -40.0])
    np.testing.assert_allclose(points_of(clicks), places(0), atol=1e-6)


def test_one_camera_gives_no_point():
    clicks = clicked(0, np.random.default_rng(0), seen_by=("N",))
    assert np.isnan(points_of(clicks)).all()


def test_what_is_not_clicked_is_not_known():
    clicks = clicked(0, np.random.default_rng(0), sigma=1e-9, names=("head",))
    known = np.isfinite(points_of(clicks)).all(axis=1)
    assert [name for name, yes in zip(NINE.names, known, strict=True) if yes] == ["head"]


def test_no_clicks_give_no_points():
    assert np.isnan(points_of(())).all()
