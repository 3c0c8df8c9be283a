"""Which parameters each stage depends on."""

import pytest

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tuning.stages import (
    Stage,
    changed_names,
    shape_stands,
    stage_key,
    stage_of,
)
from stereotrack_core.tracking.tuning.work import what_is_recomputed


def other_value(row):
    """An accepted value that differs from the default."""
    if row.type is bool:
        return not row.default
    if row.choices:
        return next(choice for choice in row.choices if choice != row.default)
    up = row.default + (2 if row.type is int else 0.25 * max(abs(row.default), 1.0))
    return up if row.maximum is None or up <= row.maximum else row.minimum


@pytest.mark.parametrize("row", DepthParameters.rows(), ids=lambda row: row.name)
def test_a_parameter_of_depth_is_in_the_keys_from_its_stage_on(row):
    old, new = DepthParameters(), DepthParameters().replaced(**{row.name: other_value(row)})
    for stage in (Stage.MATCHING, Stage.BACKGROUND, Stage.POINTS, Stage.FUSION):
        same = stage_key(old, stage) == stage_key(new, stage)
        assert same == (stage < stage_of(row.name))


def test_every_parameter_acts_on_some_stage_and_none_of_tracking_on_clouds():
    for row in Settings.rows():
        first = stage_of(row.name)
        of_depth = row.name in DepthParameters().values()
        assert (first <= Stage.FUSION) == of_depth
    assert stage_of("sigma_joint") is Stage.TRACKING
    assert stage_of("arm_radius_factor") is Stage.SHAPE


def test_names_of_what_differs_come_in_the_order_of_declaration():
    old, new = preset("accurate"), preset("accurate").replaced(sigma_joint=20.0, pixel_step=3)
    assert changed_names(old, new) == ("pixel_step", "sigma_joint")
    assert changed_names(old, old) == ()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, "nothing"),
        ({"sigma_joint": 20.0}, "tracking only"),
        ({"outlier_distance": 50.0}, "outliers of 20 frames, the body's shape and tracking"),
        ({"background_threshold": 2.0}, "points of 20 frames, the body's shape and tracking"),
        (
            {"background_percentile": 7.0, "sigma_joint": 20.0},
            "points of 20 frames, the background, the body's shape and tracking",
        ),
        (
            {"match_window": 9},
            "matching and points of 20 frames, the background, the body's shape and tracking",
        ),
        ({"arm_radius_factor": 1.1}, "the body's shape and tracking"),
        ({"fit_shape": False}, "tracking only"),
        ({"pixel_step": 3, "fit_shape": False}, "points of 20 frames and tracking"),
    ],
)
def test_what_is_recomputed_is_said_in_words(change, words):
    old = preset("accurate")
    assert what_is_recomputed(old, old.replaced(**change), 20) == words


def test_one_frame_is_one_frame():
    old = preset("accurate")
    new = old.replaced(pixel_step=3, fit_shape=False)
    assert what_is_recomputed(old, new, 1) == "points of 1 frame and tracking"


@pytest.mark.parametrize(
    ("change", "stands"),
    [
        ({"sigma_joint": 20.0}, True),
        ({"colour_weight": 0.0}, True),
        ({"pixel_step": 3}, False),
        ({"torso_flatness": 0.7}, False),
        ({"fit_frames": 6}, False),
    ],
)
def test_a_fitted_shape_stands_while_nothing_has_changed_that_it_depends_on(change, stands):
    old = preset("accurate")
    assert shape_stands(old, old.replaced(**change)) == stands
