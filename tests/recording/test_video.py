"""Forward, backward and random access give the same pictures for every codec and container."""

from __future__ import annotations

import random

import numpy as np
import pytest

from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.video import VideoStream

FRAMES = 60


def forget(number, picture):
    """For readers that do not want the pictures on the way."""


@pytest.fixture
def opened(tmp_path, numbered_videos):
    streams = []

    def open_kind(kind):
        streams.append(VideoStream(numbered_videos.of_kind(tmp_path, kind), "grey"))
        return streams[-1]

    yield open_kind
    for stream in streams:
        stream.close()


def test_every_order_of_access_gives_the_frame_of_that_number(video_kind, opened, numbered_videos):
    stream = opened(video_kind)
    on_the_way = {}
    shuffled = random.Random(3).sample(range(FRAMES), FRAMES)
    pictures = {}
    for k in [*range(FRAMES), *reversed(range(FRAMES)), *shuffled, 0, FRAMES - 1, 0]:
        picture = stream.read(k, on_the_way.__setitem__)
        assert numbered_videos.shown(picture) == k
        assert np.array_equal(picture, pictures.setdefault(k, picture))
    assert stream.count() == FRAMES
    assert stream.count_so_far() == (FRAMES, True)
    for k, picture in on_the_way.items():
        assert np.array_equal(picture, pictures[k])


def test_a_frame_behind_the_end_is_refused(video_kind, opened):
    with pytest.raises(DamagedFrame, match="ends before frame 60"):
        opened(video_kind).read(FRAMES, forget)


@pytest.mark.parametrize("kind", ["h264-b.mp4", "ffv1.mkv", "mpeg4.avi"])
def test_metadata_in_an_old_encoding_do_not_keep_a_video_shut(kind, tmp_path, numbered_videos):
    path = numbered_videos.of_kind(tmp_path, kind)
    content = path.read_bytes()
    assert b"Lavf" in content  # the program that wrote the file, one of its metadata
    path.write_bytes(content.replace(b"Lavf", "Lävf".encode("latin-1")))
    stream = VideoStream(path, "grey")
    assert numbered_videos.shown(stream.read(7, forget)) == 7
    stream.close()
