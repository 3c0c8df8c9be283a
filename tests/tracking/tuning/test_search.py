"""Parameters are found by what a person calls the matter."""

import pytest

from stereotrack_core.parameters import ParameterRow
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.search import TOPICS, finds

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


def test_two_letters_stand_for_no_topic_and_nonsense_for_nothing():
    assert "arms_apart" not in found("cr")
    assert found("zzz") == set()
    assert found("") == set(ROWS)
