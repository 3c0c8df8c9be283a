"""Presets, the rows of all settings, and a person's own presets as files."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.errors import InputError
from stereotrack_core.parameters import value_text
from stereotrack_core.tracking.parameters import Settings, TrackingParameters
from stereotrack_core.tracking.presets import (
    BASELINES,
    PRESETS,
    UserPreset,
    named,
    preset,
    read_preset,
    write_preset,
)

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


@st.composite
def settings(draw):
    base = draw(st.sampled_from(PRESETS))
    rows = draw(st.lists(st.sampled_from(Settings.rows()), max_size=5, unique_by=lambda r: r.name))
    values = {}
    for row in rows:
        if row.type is bool:
            values[row.name] = draw(st.booleans())
        elif row.choices:
            values[row.name] = draw(st.sampled_from(row.choices))
        else:
            numbers = st.integers if row.type is int else st.floats
            low, high = row.minimum, row.maximum
            if row.type is int:
                low, high = int(low), None if high is None else int(high)
            else:
                high = 1e6 if high is None else high
            values[row.name] = draw(numbers(-1e6 if low is None else low, high))
    return base, preset(base).replaced(**values)


@given(settings(), st.text(min_size=1).map(str.strip).filter(bool))
def test_what_is_written_is_read_again(tmp_path_factory, made, name):
    base, wanted = made
    path = tmp_path_factory.mktemp("presets") / "own.toml"
    own = named(name, wanted, base)
    write_preset(path, own)
    assert read_preset(path) == own
    assert read_preset(path).settings == preset(str(path)) == wanted


def test_only_what_differs_from_the_base_is_written(tmp_path):
    own = named("quick arms", preset("fast").replaced(sigma_joint=20.0), "fast")
    assert own == UserPreset("quick arms", "fast", {"sigma_joint": 20.0})
    write_preset(tmp_path / "own.toml", own)
    text = (tmp_path / "own.toml").read_text(encoding="utf-8")
    assert text == 'name = "quick arms"\nbase = "fast"\n\n[values]\nsigma_joint = 20.0\n'


@pytest.mark.parametrize(
    ("text", "where", "said"),
    [
        ("[values]\nsigma_joints = 3.0\n", "sigma_joints", "sigma_joint"),
        ("[values]\nsigma_joint = 900.0\n", "sigma_joint", "from 0.1 deg to 180 deg|0.1 to 180"),
        ("[values]\nestimator = 'best'\n", "estimator", "one of iterated"),
        ("[values]\niterations = 2.5\n", "iterations", "whole number"),
        ("[values]\nfit_shape = 'perhaps'\n", "fit_shape", "yes or no"),
        ("base = 'exact'\n", "base", "accurate, thesis, fast"),
        ("name = 3\n", "name", "is not a text"),
        ("values = 3\n", "values", "is not a table"),
        ("sigma_joint = 3.0\n", "own.toml", "is not a key of a preset file"),
        ("[values\n", "own.toml", "not valid TOML"),
    ],
)
def test_a_wrong_file_is_refused_with_the_place(tmp_path, text, where, said):
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=said) as refused:
        preset(str(path))
    assert where in refused.value.where
    assert str(path) in refused.value.where


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        preset(str(tmp_path / "none.toml"))


def test_a_file_without_a_name_has_the_file_s(tmp_path):
    (tmp_path / "mine.toml").write_text("", encoding="utf-8")
    assert read_preset(tmp_path / "mine.toml") == UserPreset("mine", "accurate", {})


def _numbers(cell):
    """A cell of the guide's table; numbers compare as numbers."""
    try:
        return float(cell)
    except ValueError:
        return cell


def test_the_guide_states_the_values_of_presets_and_what_is_accepted():
    guide = Path(__file__).parents[2] / "docs" / "parameters.md"
    lines = [line.split(" | ") for line in guide.read_text().splitlines() if line.startswith("| `")]
    table = {cells[0].strip("| `"): [cell.strip() for cell in cells[3:]] for cells in lines}
    values = {name: preset(name).values() for name in ("accurate", "thesis", "fast")}
    for row in (*DepthParameters().rows(), *TrackingParameters().rows()):
        accepted, *stated = table[row.name]
        own = [value_text(values[name][row.name]) for name in values]
        assert [_numbers(cell) for cell in stated[:3]] == [_numbers(cell) for cell in own], row.name
        if row.minimum is not None:
            ends = [float(end) for end in re.findall(r"-?[\d.]+(?:e-?\d+)?", accepted)]
            assert ends == [end for end in (row.minimum, row.maximum) if end is not None], row.name
