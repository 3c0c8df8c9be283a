"""Disparities that do not reach the person are told, with the ranges that are and should be."""

import pytest

from stereotrack_core.depth.reach import check_reach, is_changed, reach_of
from stereotrack_core.depth.volume import WorkingSpace
from tests.depth.recordings import stereo_recording
from tests.depth.test_volume import USUAL, names, passing

SCALE = 400 * 0.12
"""Focal length times base line: pixels of disparity at 1 m."""


def space(low, high, near=1.0, far=3.0):
    """What is searched from one disparity to another, and the ranges at which the person is."""
    reached = SCALE / high, SCALE / low if low else float("inf")
    corner = (0.0, 0.0, 0.0)
    return WorkingSpace(
        "z", corner, corner, "", {"N": (low, high)}, {"N": reached}, {"N": (near, far)}
    )


@pytest.mark.parametrize(("low", "high"), [(0, 64), (1, 48), (15, 47), (16, 47)])
def test_what_reaches_the_person_is_not_told(low, high):
    assert not list(check_reach(space(low, high)))


def test_too_few_disparities_begin_too_far_away():
    [found] = check_reach(space(1, 32))
    assert (found.severity, found.where) == ("warning", "view N, disparities")
    assert "of 1 to 32 px show what is 1.50 to 48.00 m, but" in found.what
    assert "from 1.00 to 3.00 m" in found.what
    assert "Set disparity_count to 48 or more." in found.remedy
    assert not list(check_reach(space(1, 48)))


def test_a_minimum_that_leaves_out_what_is_far():
    [found] = check_reach(space(20, 83))
    assert found.severity == "warning"
    assert "Set disparity_minimum to 16 or less." in found.remedy


@pytest.mark.parametrize(("low", "high"), [(1, 15), (60, 123)])
def test_where_nothing_is_reached_it_is_an_error(low, high):
    assert [one.severity for one in check_reach(space(low, high))] == ["error"]


def test_what_is_searched_of_a_recording():
    recording = stereo_recording()
    few = USUAL.replaced(disparity_count=16)
    found = reach_of(recording, few, passing(recording), names(recording))
    assert found
    assert "Set disparity_count to 32 or more." in found[0].remedy
    assert is_changed(few)
    assert not is_changed(USUAL.replaced(volume_x=3.0))
