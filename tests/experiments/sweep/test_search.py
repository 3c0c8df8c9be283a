"""Searches that propose the same again."""

import math
import sys

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.points import Range, Search, parsed_range

RANGES = tuple(
    parsed_range(text)
    for text in (
        "iterations=1:12",
        "max_correspondence_distance=0.05:1.0:log",
        "first_loss_scale=0.02:0.4",
        "sampling=random,regular",
        "data_points=100:900:int",
    )
)


def badness(point):
    values = point.by_name
    return abs(values["iterations"] - 7) + 10 * abs(
        math.log(values["max_correspondence_distance"] / 0.2)
    )


def tried(trials, batch, seed=0):
    search, points = Search(RANGES, seed), []
    while len(points) < trials:
        asked = search.ask(min(batch, trials - len(points)))
        search.tell([badness(point) for point in asked])
        points += asked
    return points


def test_ranges_are_read():
    assert RANGES[0] == Range("iterations", 1.0, 12.0, "int")
    assert RANGES[1] == Range("max_correspondence_distance", 0.05, 1.0, "log")
    assert RANGES[3] == Range("sampling", choices=("random", "regular"))
    assert parsed_range("fit_shape=yes,no").choices == (True, False)
    assert parsed_range("views=N,NS").choices == ("N", "NS")
    assert parsed_range("frames=0:20,20:40").choices == ("0:20", "20:40")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("iterations", "cannot be read"),
        ("iterations=12:1", "is not a range"),
        ("iterations=0:5", "from 1"),
        ("iterations=1:5:log", "whole numbers"),
        ("iterations=1:5: log", "whole numbers"),
        ("sigma_rotation=1.2:1.8:int", "only one value"),
        ("clearance=0:0.1:log", "above 0"),
        ("max_correspondence_distance=0.1:0.2:cubic", "cannot be read"),
        ("sampling=random", "only one value"),
        ("nothing=1:2", "unknown parameter"),
        ("seed=0,1", "--seeds"),
    ],
)
def test_what_cannot_be_meant_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        parsed_range(text)


@pytest.mark.parametrize("batch", [1, 3])
def test_the_same_search_tries_the_same_points(batch):
    points = tried(25, batch)
    assert tried(25, batch) == points
    assert tried(12, batch) == points[:12]
    assert tried(12, batch, seed=1) != points[:12]
    for point in points:
        values = point.by_name
        assert list(values) == [one.name for one in RANGES]
        assert isinstance(values["iterations"], int)
        assert 1 <= values["iterations"] <= 12
        assert 0.05 <= values["max_correspondence_distance"] <= 1.0
        assert values["sampling"] in ("random", "regular")


def test_a_search_finds_better_points_than_it_begins_with():
    points = tried(60, 1)
    assert min(map(badness, points[30:])) < min(map(badness, points[:10]))


def test_points_that_failed_teach_nothing_and_stop_nothing():
    search = Search(RANGES[:1], 0)
    for value in (math.nan, 2.0, math.inf, 1.0):
        search.ask(1)
        search.tell([value])
    assert len(search.ask(2)) == 2


def test_a_missing_library_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(InputError, match=r"stereotrack\[search\]"):
        Search(RANGES, 0)


def test_a_name_is_given_once():
    with pytest.raises(InputError, match="twice"):
        Search((RANGES[0], RANGES[0]), 0)


def test_whole_numbers_stay_within_a_range_that_begins_between_two():
    class Trial:
        def suggest_int(self, name, low, high):
            return {"sigma_rotation": (low, high)}[name][0]

    assert parsed_range("sigma_rotation=0.5:3.5:int").suggested(Trial()) == 1.0
