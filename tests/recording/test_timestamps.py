"""The index of a video: growing, stored, irregular."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.recording.findings import check_times
from stereotrack_core.recording.video import FrameTimes


@pytest.fixture
def times_of():
    opened = []

    def index(path):
        opened.append(FrameTimes(path))
        return opened[-1]

    yield index
    for times in opened:
        times.close()


def test_the_times_are_those_that_were_written(tmp_path, numbered_videos, times_of):
    written = [500 + 33 * i + 7 * (i % 3) for i in range(60)]
    path = numbered_videos.write(
        tmp_path / "v.mkv",
        "libx264",
        times=written.__getitem__,
        options={"g": "12", "bf": "3", "b-adapt": "0"},
    )
    times = times_of(path)
    assert times.time_of(0) == 500
    assert times.times() == written
    assert times.time_of(60) is None
    assert times.frame_at(written[17]) == 17
    assert times.frame_at(written[17] + 1) is None
    assert times.key_times(written[13]) == [written[0], written[12]]
    assert times.next_key_time(written[12]) == written[24]
    assert times.next_key_time(written[59]) is None


def test_irregular_times_are_found():
    regular = np.arange(100) / 25
    assert not list(check_times("v", regular, 25.0))
    jump = regular + (np.arange(100) > 40) * 0.12
    (finding,) = check_times("v", jump, 25.0)
    assert finding.severity == "warning"
    assert "1 of 99 steps: frame 41 comes 160 ms after frame 40 instead of 40 ms" in finding.what
    (finding,) = check_times("v", regular, 10.0)
    assert "the video states 25.00 frames per second, the recording 10" in finding.what
