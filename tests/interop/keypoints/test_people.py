"""One person keeps one number over all frames, stated or followed by place."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from stereotrack_core.interop.keypoints.people import Who, identified
from stereotrack_core.recording.keypoints import changes_of_surest, keypoints_of, of_one_person

NAMES = ("nose", "left_hip", "right_hip")


def rows(people, *, named=False):
    """Rows of `people`: for each frame places (x, y) and confidences in the detector's order."""
    found = []
    for frame, picture in people.items():
        for place, (name, x, y, sure) in enumerate(picture):
            who = Who(place, name if named else "")
            for k, point in enumerate(NAMES):
                found.append((frame, "N", point, x + 5.0 * k, y + 40.0 * k, sure, "d", who))
    return found


def crossing(frames=30):
    """Two people who walk past each other, listed in an order of chance."""
    rng = np.random.default_rng(3)
    people = {}
    for k in range(frames):
        both = [("A", 100.0 + 8 * k, 200.0, 0.8), ("B", 340.0 - 8 * k, 260.0, 0.75)]
        both = [(name, x, y, sure + rng.uniform(-0.1, 0.1)) for name, x, y, sure in both]
        people[k] = both if rng.random() < 0.5 else both[::-1]
    return people


@pytest.mark.parametrize("named", [True, False])
def test_people_who_cross_keep_their_numbers(named):
    people = crossing()
    found, names = identified(rows(people, named=named))
    assert set(names.values()) == ({"A", "B"} if named else set())
    keypoints = keypoints_of(found)
    kept = of_one_person(keypoints)
    own = kept[kept.keypoint == "nose"]
    assert own.frame.tolist() == list(range(30))
    assert own.place[:, 0].tolist() == [100.0 + 8 * k for k in range(30)]
    surest = [max(one, key=lambda person: person[3])[0] for one in people.values()]
    changes = sum(a != b for a, b in pairwise(surest))
    assert changes > 5
    assert changes_of_surest(keypoints) == changes


def test_who_leaves_and_comes_back_is_the_same_and_a_passer_by_another():
    people = {k: [("A", 100.0, 200.0, 0.5)] for k in (*range(10), *range(30, 40))}
    for k in range(3, 8):
        people[k] = [("B", 500.0, 200.0, 0.9), *people[k]]
    kept = of_one_person(keypoints_of(identified(rows(people))[0]))
    assert set(kept.frame.tolist()) == set(people)
    assert kept.place[:, 0].max() < 200.0
