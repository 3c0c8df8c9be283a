"""Points of grids, lists and searches."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.study.points import (
    Axis,
    Point,
    Search,
    grid_points,
    parsed_axis,
    parsed_range,
)


def test_values_are_read_by_their_rows():
    assert parsed_axis("model_points=24, 40") == Axis("model_points", (24, 40))
    assert parsed_axis("fit_shape=no,yes").values == (False, True)
    assert parsed_axis("views=NS,cam_0+cam_2").values == ("NS", "cam_0+cam_2")
    assert parsed_axis("smooth=yes,no").values == (True, False)
    assert parsed_axis("frames=0:20,20:").values == ("0:20", "20:")
    assert parsed_axis("seed=0,3").values == (0, 3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("model_points", "cannot be read"),
        ("model_points=1", "from 4"),
        ("model_points=24,24", "twice"),
        ("model_pionts=3", "Did you mean model_points[?] docs"),
        ("preset=best", "accurate, thesis, fast"),
        ("seed=-1", "from 0"),
    ],
)
def test_what_cannot_be_meant_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        parsed_axis(text)


def test_a_grid_is_every_combination():
    points = grid_points([parsed_axis("model_points=24,40"), parsed_axis("views=N,S,NS")])
    assert len(points) == len(set(points)) == 6
    assert points[1] == Point((("model_points", 24), ("views", "S")))
    assert points[1].parameters == {"model_points": 24}
    assert points[1].special("views") == "S"
    assert points[1].special("preset") is None
    assert grid_points([]) == (Point(),)


RANGES = tuple(
    parsed_range(text)
    for text in (
        "iterations=1:12",
        "max_correspondence_distance=0.05:1.0:log",
        "loss_scale=0.02:0.4",
        "sampling=random,regular",
    )
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("iterations", "cannot be read"),
        ("iterations=12:1", "is not a range"),
        ("iterations=1:5:log", "whole numbers"),
        ("sampling=random", "only one value"),
        ("seed=0,1", "--seeds"),
    ],
)
def test_ranges_that_cannot_be_meant_are_refused(text, words):
    with pytest.raises(InputError, match=words):
        parsed_range(text)


def tried(trials, batch):
    search, found = Search(RANGES), []
    while len(found) < trials:
        asked = search.ask(min(batch, trials - len(found)))
        costs = [abs(point.by_name["iterations"] - 7.0) for point in asked]
        search.tell(costs)
        found += zip(asked, costs, strict=True)
    return found


@pytest.mark.parametrize("batch", [1, 3])
def test_the_same_search_tries_the_same_points_and_gets_better(batch):
    found = tried(24, batch)
    assert tried(12, batch) == found[:12]
    for point, _ in found:
        values = point.by_name
        assert list(values) == [one.name for one in RANGES]
        assert isinstance(values["iterations"], int)
        assert 1 <= values["iterations"] <= 12
        assert 0.05 <= values["max_correspondence_distance"] <= 1.0
        assert values["sampling"] in ("random", "regular")
    assert sum(cost for _, cost in found[12:]) < sum(cost for _, cost in found[:12])
