"""Values of one parameter, and parameters that a person finds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterRow
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.search import TOPICS, finds
from stereotrack_core.tracking.tuning.series import all_values, spread_values, usual_range

ROWS = {row.name: row for row in Settings.rows()}
NUMBERS = [row for row in Settings.rows() if row.type in (int, float)]


def test_even_steps_and_even_factors():
    row = ROWS["sigma_joint"]
    assert spread_values(row, 5, 20, 4) == (5.0, 10.0, 15.0, 20.0)
    assert spread_values(row, 5, 40, 4, by_factors=True) == (5.0, 10.0, 20.0, 40.0)


def test_words_and_switches_are_tried_in_full():
    assert all_values(ROWS["fit_shape"]) == (False, True)
    assert all_values(ROWS["matcher"]) == ("bm", "sgbm")
    assert all_values(ROWS["sigma_joint"]) == ()


@pytest.mark.parametrize(
    ("low", "high", "count", "factors", "said"),
    [
        (5, 500, 4, False, "500.0 is not.*from 0.1 to 180 deg"),
        (20, 5, 4, False, "is not a range"),
        (float("nan"), 5, 4, False, "is not a range"),
        (5, 20, 1, False, "cannot be tried"),
        (5, 20, 100, False, "cannot be tried"),
    ],
)
def test_what_makes_no_sense_is_refused(low, high, count, factors, said):
    with pytest.raises(InputError, match=said) as refused:
        spread_values(ROWS["sigma_joint"], low, high, count, by_factors=factors)
    assert refused.value.where == "sigma_joint"


@given(st.sampled_from(NUMBERS), st.integers(2, 12), st.booleans())
def test_the_usual_range_is_accepted_and_holds_the_value(row, count, factors):
    low, high = usual_range(row, row.default)
    assert low <= row.default <= high
    if low < high and (low > 0 or not factors):
        values = spread_values(row, low, high, count, by_factors=factors)
        assert list(values) == sorted(values)
        np.testing.assert_allclose(values[0], low, rtol=0.01)
        np.testing.assert_allclose(values[-1], high, rtol=0.01)


ROWS: dict[str, ParameterRow] = {row.name: row for row in Settings.rows()}


def found(words):
    return {name for name, row in ROWS.items() if finds(row, words)}


@pytest.mark.parametrize(
    ("words", "some", "none"),
    [
        ("cross", {"arms_apart", "clearance", "search_arms"}, {"matcher", "volume_x"}),
        ("Lost", {"search_arms", "prior_inflation_above"}, {"torso_flatness"}),
        ("speed", {"iterations", "data_points", "sigma_joint"}, {"volume_x"}),
        ("noise", {"sigma_measurement", "outlier_distance"}, {"legs"}),
        ("jitter", {"sigma_joint", "data_points"}, {"matcher"}),
        ("smooth", {"longest_bridge", "sigma_joint"}, {"matcher"}),
        ("jitter joint", {"sigma_joint"}, {"data_points", "sigma_position"}),
        ("sigma joint", {"sigma_joint"}, {"sigma_position"}),
        ("search_arms", {"search_arms"}, {"arms_apart"}),
    ],
)
def test_a_person_finds_what_is_meant(words, some, none):
    assert some <= found(words)
    assert not none & found(words)


def test_every_topic_names_parameters_that_there_are_and_none_twice():
    for topic, names in TOPICS.items():
        assert set(names) <= set(ROWS), topic
        assert len(set(names)) == len(names), topic
        for word in topic:
            assert set(names) <= found(word)
