"""Motion tells which stream is late."""

import re

import numpy as np
import pytest

from stereotrack_core.doctor.clocks import check_clocks, check_lags, lag_of, motion_signals
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.recordings import stereo_recording


def motion(late=0.0, seed=0, length=120):
    at = np.arange(length) - late
    bursts = sum(
        size * np.exp(-0.5 * ((at - place) / 3.0) ** 2)
        for place, size in ((15, 1.0), (40, 2.0), (52, 1.2), (85, 1.6), (101, 0.7))
    )
    return bursts + 0.05 * np.random.default_rng(seed).normal(size=length)


def test_views_that_are_synchronised_have_no_findings():
    assert not list(check_lags({name: motion(seed=k) for k, name in enumerate("NOSW")}, 30.0))


@pytest.mark.parametrize("late", [8, -5])
def test_the_view_that_is_late_or_early_is_named(late):
    views = {n: motion(late if n == "S" else 0, seed=k) for k, n in enumerate("NOSW")}
    [finding] = check_lags(views, 20.0)
    assert finding.severity == "error"
    assert finding.where == "view S"
    frames = float(re.search(r"([0-9.]+) frames", finding.what)[1])
    assert frames == pytest.approx(abs(late), abs=0.3)
    assert ("later" if late > 0 else "earlier") in finding.what
    assert f"{'larger' if late > 0 else 'smaller'} by {abs(late)}" in finding.remedy


@pytest.mark.parametrize("late", [8, -5])
def test_two_views_that_differ_are_named_and_corrected_by_nobody(late):
    [finding] = check_lags({"N": motion(), "O": motion(late, seed=1)}, 30.0)
    assert (finding.severity, finding.where, finding.correction) == ("warning", "views N, O", None)
    frames = float(re.search(r"O shows everything ([0-9.]+) frames", finding.what)[1])
    assert frames == pytest.approx(abs(late), abs=0.3)
    assert f"view {'O' if late > 0 else 'N'} larger by {abs(late)}" in finding.remedy
    assert not list(check_lags({"N": motion(), "O": motion(seed=1)}, 30.0))
    short = {"N": motion(length=90), "O": motion(late, seed=1, length=90)}
    assert not list(check_lags(short, 30.0))


def test_stillness_proves_nothing():
    views = {"N": np.zeros(60), "O": np.zeros(60), "S": motion(8, length=60)}
    assert not list(check_lags(views, 30.0))
    assert not lag_of(views["N"], views["S"]).certain


class Frames:
    """Images of a spot that jumps now and then; the left ones show it later."""

    frame_count = 60

    def __init__(self, late):
        self.late = late

    def frame_set(self, k):
        return FrameSet(k, {"A": ViewImages(image=self.image(k), left=self.image(k - self.late))})

    def image(self, k):
        picture = np.zeros((60, 80), np.uint8)
        place = np.cumsum(np.random.default_rng(3).integers(0, 2, 80) * 3)[max(k, 0)] % 60
        picture[20:40, place : place + 15] = 200
        return picture


@pytest.mark.parametrize("late", [0, 3])
def test_the_left_image_of_a_pair_may_be_late(late):
    findings = list(check_clocks(stereo_recording(), motion_signals(Frames(late))))
    assert [f.where for f in findings] == ["view A, left"] * (late > 0)
    assert all(f.severity == "error" and "larger by 3" in f.remedy for f in findings)
