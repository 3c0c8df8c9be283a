"""Ten minutes are opened without reading them to the end, and need no more memory."""

from __future__ import annotations

import shutil
import threading

import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.video import FrameTimes
from stereotrack_core.recording.writing import write_recording_description

TEN_MINUTES = 15_000  # frames at 25 per second
NUMBERS = 1024  # that the bar code can show
STREAMS = 8
BEGINNING = 64
"""Frames of each video whose times may be read before its first picture is shown."""

PATIENCE_S = 300.0


@pytest.fixture
def held(monkeypatch):
    """Lets videos be indexed up to a frame at their beginning; the event lets them go on."""
    go_on, settle = threading.Event(), FrameTimes._settle

    def wait_and_settle(times: FrameTimes, time: int) -> None:
        if times.count_so_far() == BEGINNING:
            assert go_on.wait(PATIENCE_S), "the first frame set waits for the end of the videos"
        settle(times, time)

    monkeypatch.setattr(FrameTimes, "_settle", wait_and_settle)
    yield go_on
    go_on.set()


@pytest.mark.slow
@pytest.mark.parametrize("container", ["mkv", "mp4"])
def test_the_first_frame_set_of_ten_minutes_comes_before_the_rest_is_read(
    tmp_path, numbered_videos, container, held
):
    video = numbered_videos.write(
        tmp_path / f"0.{container}",
        "libx264",
        options={"g": "50", "bf": "2", "preset": "ultrafast"},
        frames=TEN_MINUTES,
        numbers=lambda i: i % NUMBERS,
    )
    for i in range(1, STREAMS):
        shutil.copy(video, tmp_path / f"{i}.{container}")
    matrix = np.array([[100.0, 0, 60], [0, 100, 32], [0, 0, 1]])
    place = RigidTransform.identity()
    cameras = {
        str(i): Camera(str(i), 120, 64, matrix, np.zeros(5), False, place) for i in range(STREAMS)
    }
    views = tuple(View(n, "mono", Stream(n, f"{n}.{container}")) for n in cameras)
    write_recording_description(Recording(tmp_path, "long", 25.0, views, cameras))
    limit = 40 * 120 * 64
    with FrameReader(open_recording(tmp_path), colour=False, cache_bytes=limit) as reader:
        first = reader.frame_set(0)
        assert not reader.frame_count_so_far()[1]
        held.set()
        assert {numbered_videos.shown(v.image) for v in first.views.values()} == {0}
        assert reader.frame_count == TEN_MINUTES
        for k in (14_999, 3, 7_777, *range(9_000, 9_040)):
            shown = reader.frame_set(k).views["5"].image
            assert numbered_videos.shown(shown) == k % NUMBERS
            assert reader.cached_bytes <= limit
