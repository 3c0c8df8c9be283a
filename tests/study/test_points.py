"""Points of grids and lists."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.study.points import Axis, Point, grid_points, parsed_axis


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
