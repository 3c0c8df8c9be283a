"""Commands on what is selected are edits, said in words, taken back at once."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.marks import GAP, mark_keyframes
from stereotrack_core.project.selection import (
    Selection,
    clear_clicks,
    clear_flags,
    gaps_of,
    set_flags,
    set_keyframes,
)


@pytest.fixture
def annotated(project, make):
    project.apply(place_clicks(make.clicks_at(range(0, 40, 5))))
    return project


def test_clicks_are_cleared_and_come_back(annotated):
    chosen = Selection(range(5, 16), ("left_elbow", "head"))
    before = annotated.clicks.all()
    annotated.apply(clear_clicks(annotated, chosen))
    assert annotated.clicks.count() == len(before) - 24
    assert annotated.history.to_undo().words == "delete 2 landmarks in 4 cameras, frames 5 to 15"
    annotated.undo()
    assert annotated.clicks.all() == before
    with pytest.raises(InputError, match="no clicks in frames 1 – 2"):
        clear_clicks(annotated, Selection(range(1, 3)))


def test_gaps(annotated):
    annotated.apply(set_flags(annotated, Selection(range(10, 14)), GAP))
    annotated.apply(set_flags(annotated, Selection(range(14, 16)), GAP))
    annotated.apply(set_flags(annotated, Selection(range(30, 33), ("head",)), GAP))
    assert gaps_of(annotated) == (range(10, 16),)
    annotated.apply(clear_flags(annotated, Selection(range(12, 14)), GAP))
    assert gaps_of(annotated) == (range(10, 12), range(14, 16))
    annotated.apply(clear_flags(annotated, Selection(range(60)), GAP))
    assert not [flag for flag in annotated.marks.flags() if flag.kind == GAP]
    with pytest.raises(InputError, match="nothing is marked as a gap"):
        clear_flags(annotated, Selection(range(60)), GAP)


def test_keyframes_every_n(annotated):
    annotated.apply(mark_keyframes(tuple(range(0, 60, 10))))
    assert annotated.progress().words() == "0 of 6 keyframes done"
    annotated.apply(set_keyframes(annotated, Selection(range(25)), "done"))
    assert annotated.progress().words() == "3 of 6 keyframes done"
    annotated.apply(set_keyframes(annotated, Selection(range(30, 60)), "none"))
    assert annotated.progress().words() == "3 of 3 keyframes done"
    annotated.apply(set_keyframes(annotated, Selection(range(7, 8)), "done"))
    assert annotated.progress().words() == "4 of 4 keyframes done"
    with pytest.raises(InputError, match="no keyframes in frames 41 – 43"):
        set_keyframes(annotated, Selection(range(41, 44)), "done")
