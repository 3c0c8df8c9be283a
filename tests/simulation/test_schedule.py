"""Motions that begin at given frames and take given numbers of them."""

import itertools

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.simulation.motions import Part, filled, scheduled
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.skeleton import landmarks, posed_bones

P2 = PEOPLE["P2"]


def points_of(chain):
    return np.array([landmarks(P2, posed_bones(P2, state)) for state in chain.states])


def test_parts_stand_where_they_were_put():
    parts = (Part("opening", "t-pose", 3, 5), Part("blow", "whip", 20, 10))
    chain = scheduled(P2, parts, 40)
    assert len(chain.states) == 40
    assert [(s.name, s.first, s.end) for s in chain.segments] == [
        ("opening", 3, 8),
        ("blow", 20, 30),
    ]
    points = points_of(chain)
    assert np.array_equal(points[0], points[3])
    assert np.array_equal(points[29], points[39])


def test_the_way_between_two_parts_is_smooth():
    parts = (Part("opening", "t-pose", 0, 5), Part("blow", "whip", 25, 20))
    points = points_of(scheduled(P2, parts, 45))
    assert np.abs(np.diff(points[5:25], axis=0)).max() < 0.2


def test_fewer_frames_are_a_faster_motion():
    slow = points_of(scheduled(P2, (Part("a", "whip", 0, 274),), 274))
    fast = points_of(scheduled(P2, (Part("a", "whip", 0, 30),), 30))
    assert np.abs(np.diff(fast, axis=0)).max() > 5 * np.abs(np.diff(slow, axis=0)).max()


@pytest.mark.parametrize(
    "parts",
    [
        (),
        (Part("a", "whip", 0, 30), Part("b", "whip", 29, 10)),
        (Part("a", "whip", 0, 1),),
        (Part("a", "handstand", 0, 10),),
    ],
)
def test_what_cannot_be_is_refused(parts):
    with pytest.raises(InputError):
        scheduled(P2, parts, 50)


def test_gaps_are_filled_without_touching_what_is_fixed():
    fixed = (Part("t-pose", "t-pose", 0, 12), Part("whip", "whip", 300, 40))
    parts = filled(fixed, (("walk", 90), ("point", 60)), 500, 10)
    assert [part for part in parts if part in fixed] == list(fixed)
    for before, after in itertools.pairwise(parts):
        assert 10 <= after.first - before.end <= 12
    assert {part.name for part in parts} == {"t-pose", "whip", "walk", "point"}
    assert 480 <= parts[-1].end <= 500


def test_a_gap_too_small_for_anything_stays_empty():
    fixed = (Part("a", "whip", 0, 20), Part("b", "whip", 40, 20))
    assert filled(fixed, (("walk", 90),), 60, 10) == fixed


def test_arms_are_crossed_for_fifty_frames():
    part = Part("cross-arms", "hold-arms-crossed", 0, 130)
    points = points_of(scheduled(P2, (part,), 130))
    left, right = points[:, 4], points[:, 5]  # hands
    crossed = left[:, 0] > right[:, 0]
    assert 40 <= crossed.sum() <= 70
    assert crossed[70:110].all()
