"""Presets and the rows of all settings."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import BASELINES, PRESETS, preset

THESIS = {
    "matching": "model_to_data",
    "iterations": 4,
    "model_points": 64,
    "sampling": "random",
    "sigma_measurement": 0.02,
    "sigma_position": 0.1,
    "sigma_rotation": 20.0,
    "sigma_joint": 40.0,
    "clearance": 0.15,
    "proportions": "individual",
    "legs": False,
    "girdle": False,
    "search_arms": False,
    "background_mode": "average",
    "matcher": "bm",
    "match_left_right": -1,
    "outlier_repeat": True,
    "edge_images": False,
    "speckle_size": 60,
    "pixel_step": 2,
}
"""Section 4.2.1, the method of the thesis, and ours where it leaves something open, at the end."""


def test_the_presets_are_there():
    assert PRESETS[:3] == ("accurate", "thesis", "fast")
    assert PRESETS[3:] == BASELINES
    assert preset("accurate") == Settings()
    assert preset("fast").values() != preset("accurate").values()


@pytest.mark.parametrize("name", THESIS)
def test_the_thesis_has_its_values(name):
    assert preset("thesis").values()[name] == THESIS[name]


@pytest.mark.parametrize("group", ["depth", "body", "tracking"])
def test_the_thesis_has_what_the_rows_state_and_the_defaults_elsewhere(group):
    settings = preset("thesis")
    rows, values = getattr(settings, group).rows(), getattr(settings, group).values()
    assert any(row.thesis is not None for row in rows)
    stated = {row.name: row.default if row.thesis is None else row.thesis for row in rows}
    assert values == stated


def test_an_unknown_preset_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match="accurate, thesis, fast"):
        preset("exact")


def test_an_unknown_parameter_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match="model_points"):
        Settings().replaced(model_point=3)


@pytest.mark.parametrize("row", Settings.rows(), ids=lambda row: row.name)
def test_every_row_explains_itself_and_accepts_its_own_values(row):
    assert row.help[:1].isupper()
    assert row.help.endswith(".")
    assert row.group
    assert row.type in (bool, int, float, str)
    assert row.checked(row.default) == row.default
    assert type(row.checked(row.default)) is row.type
    if row.thesis is not None:
        assert row.checked(row.thesis) == row.thesis
    if row.type is str:
        assert row.default in row.choices
        with pytest.raises(InputError):
            row.checked("something else")
    for limit, beyond in ((row.minimum, -1), (row.maximum, 1)):
        if limit is not None:
            assert row.checked(limit) == limit
            with pytest.raises(InputError):
                row.checked(limit + beyond)


def test_names_are_unique_over_all_groups():
    names = [row.name for row in Settings.rows()]
    assert len(names) == len(set(names)) == len(Settings().values())


def test_a_name_changes_one_value_in_whatever_group_it_is():
    changed = Settings().replaced(low_pass=1.5, torso_flatness=0.7, iterations=3)
    assert changed.depth.low_pass == 1.5
    assert changed.body.torso_flatness == 0.7
    assert changed.tracking.iterations == 3
    assert changed.replaced(**Settings().values()) == Settings()
