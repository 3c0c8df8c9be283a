"""A reference that is late is known by the motion in the images, without any depth."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.doctor.reference import check_reference
from stereotrack_core.doctor.reference_clock import delay_of, drawings, reference_delay
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.importing.signals import motion_of
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from tests.depth.scenes import camera
from tests.doctor.test_reference import waving

FRAMES = 70
CAMERAS = {
    "A": camera("A", (0.0, -2.5, 1.2)),
    "B": camera("B", (0.5, -2.4, 1.1), (0.0, 0.2, 0.0)),
}


def posed():
    """Landmarks (F, 9, 3) of a person who waves, pauses, and waves faster."""
    pace = np.abs(np.convolve(np.random.default_rng(4).normal(size=FRAMES), np.ones(6) / 6, "same"))
    at = np.cumsum(4 * pace) % 78
    return waving()[np.abs(at.astype(int) - 39)]


@pytest.fixture(scope="module")
def filmed():
    """A recording of that by two ordinary cameras."""
    views = tuple(View(name, "mono", Stream(name, "-")) for name in CAMERAS)
    reference = LandmarkTrajectory(np.arange(FRAMES), posed())
    return Recording(Path(), "filmed", 10.0, views, CAMERAS, None, reference)


@pytest.fixture(scope="module")
def signals(filmed):
    """Motion in its images, with noise."""
    rng, found = np.random.default_rng(5), {}
    for name, one in CAMERAS.items():
        seen = motion_of(drawings(one, filmed.reference.points))
        found[name, "image"] = seen + rng.normal(0, 0.3 * seen.std(), FRAMES)
    return found


def late(filmed, frames):
    reference = filmed.reference
    moved = dataclasses.replace(reference, frame=reference.frame + frames)
    return dataclasses.replace(filmed, reference=moved)


@pytest.mark.parametrize("frames", [0, 8, -5])
def test_the_delay_is_measured(filmed, signals, frames):
    delay = reference_delay(late(filmed, frames), signals)
    assert delay.certain
    assert delay.frames == pytest.approx(frames, abs=0.5)
    found = list(check_reference(late(filmed, frames), (), delay))
    assert len(found) == (frames != 0)
    if found:
        assert f"it is {abs(frames)} frames" in found[0].what


def test_other_motion_does_not_agree():
    rng = np.random.default_rng(6)
    pairs = [(rng.normal(size=200), rng.normal(size=200)) for _ in range(3)]
    assert not delay_of(pairs).certain
