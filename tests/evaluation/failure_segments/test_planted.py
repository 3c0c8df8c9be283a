"""Planted failures in simulated recordings: how often the probable cause is the planted one."""

from __future__ import annotations

from collections import Counter

import pytest

from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from tests.evaluation.failure_segments.plants import PLANTS, planted

pytestmark = pytest.mark.slow

_EARLY = 3
"""Frames by which a failure may begin before what is planted acts."""


@pytest.fixture(scope="module")
def confusion(tmp_path_factory):
    """Counts of (planted, told) of failures found with truth that begin while something acts."""
    folder = tmp_path_factory.mktemp("planted")
    told: Counter[tuple[str, str]] = Counter()
    for name, plant in PLANTS.items():
        recording, run = planted(plant, folder / name)
        search = FailureSearch(run, recording.fps, recording.reference, recording)
        for failure in find_failures(search):
            if failure.found == "truth" and begins_within(failure, plant.planted):
                told[plant.cause, failure.verdict.cause] += 1
    return told


def begins_within(failure, frames) -> bool:
    return frames.start - _EARLY <= failure.first < frames.stop


@pytest.mark.timeout(3600)
def test_most_planted_causes_are_told(confusion, record_property):
    for pair, count in sorted(confusion.items()):
        record_property(" told as ".join(pair), count)
    right = sum(count for (cause, told), count in confusion.items() if cause == told)
    every = sum(confusion.values())
    assert every >= 12, confusion
    assert right / every >= 0.8, confusion


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("cause", sorted({plant.cause for plant in PLANTS.values()} - {"torso"}))
def test_each_cause_is_told_at_least_once(confusion, cause):
    assert confusion[cause, cause] >= 1, dict(confusion)
