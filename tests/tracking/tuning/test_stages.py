"""Which parameters each stage depends on."""

import pytest

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tuning.stages import Stage, changes_in_words, stage_key, stage_of


def other_value(row):
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


@pytest.mark.parametrize(
    ("change", "stands"),
    [
        ({"sigma_joint": 20.0}, True),
        ({"colour_weight": 0.0}, True),
        ({"pixel_step": 3}, False),
        ({"torso_flatness": 0.7}, False),
        ({"fit_shape": False}, False),
    ],
)
def test_a_fitted_shape_stands_while_nothing_has_changed_that_it_depends_on(change, stands):
    old = preset("accurate")
    keys = (stage_key(one, Stage.SHAPE) for one in (old, old.replaced(**change)))
    assert (len(set(keys)) == 1) == stands


def test_what_differs_is_said_in_words_with_units():
    old = preset("fast")
    assert changes_in_words(old, old) == ""
    one = old.replaced(sigma_joint=25.0)
    assert changes_in_words(old, one) == "sigma joint 25 deg"
    more = one.replaced(matching="model_to_data", fit_shape=True, data_points=300)
    assert changes_in_words(one, more) == "matching model to data, data points 300"
    most = more.replaced(matcher="sgbm", legs=False)
    assert changes_in_words(old, most) == "matcher sgbm, legs no and 3 more"
    newest = changes_in_words(old, most, ("data_points",))
    assert newest == "data points 300, matcher sgbm and 3 more"
