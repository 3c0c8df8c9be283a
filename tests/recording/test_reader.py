"""Frame sets: ranges, offsets, damage in one view, memory, threads."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader, FrameSet, ViewImages, shows_colours
from stereotrack_core.recording.writing import VideoWriter, write_png, write_recording_description

LENGTHS = {"A": 40, "B": 33, "C": 36}
FPS = 10.0
IDENTITY = RigidTransform.identity()


@pytest.fixture
def recording(tmp_path, numbered_videos):
    """Three mono views; the video of B is shorter, C is numbered images with a gap at 7."""
    width, height = numbered_videos.width, numbered_videos.height
    matrix = np.array([[100.0, 0, 60], [0, 100, 32], [0, 0, 1]])
    flat = np.zeros(5)
    cameras = {n: Camera(n, width, height, matrix, flat, False, IDENTITY) for n in LENGTHS}
    films = {"A": "A.mp4", "B": "B.mp4", "C": "C/%d.png"}
    views = tuple(View(name, "mono", Stream(name, film)) for name, film in films.items())
    write_recording_description(Recording(tmp_path, "three", FPS, views, cameras))
    for name in "AB":
        with VideoWriter(tmp_path / f"{name}.mp4", fps=FPS, width=width, height=height) as video:
            for k in range(LENGTHS[name]):
                video.write(numbered_videos.bar_code(k))
    (tmp_path / "C").mkdir()
    for k in set(range(LENGTHS["C"])) - {7}:
        write_png(tmp_path / f"C/{k + 5}.png", numbered_videos.bar_code(k))
    return open_recording(tmp_path)


def test_the_common_range_is_used(recording):
    with FrameReader(recording, colour=False) as reader:
        assert reader.frame_count == 33
        assert reader.stream_counts() == {(name, "image"): n for name, n in LENGTHS.items()}
        for k in (-1, 33, 10**9):
            with pytest.raises(InputError, match=rf"no frame {k}.*numbered 0 to 32"):
                reader.frame_set(k)


def test_a_gap_in_one_view_leaves_the_others(recording, numbered_videos):
    with FrameReader(recording, colour=False) as reader:
        for k in (6, 7, 8, 7):
            frame_set = reader.frame_set(k)
            assert frame_set.index == k
            assert set(frame_set.views) == (set("AB") if k == 7 else set("ABC"))
            assert all(numbered_videos.shown(v.image) == k for v in frame_set.views.values())
            assert set(frame_set.problems) == (set("C") if k == 7 else set())
    with FrameReader(recording, views=["C"]) as reader:
        assert "View C, frame 7" in reader.frame_set(7).problems["C"]


def test_offsets_shift_a_stream(recording, numbered_videos):
    streams = {
        "A": Stream("A", "A.mp4", first_frame=4),
        "B": Stream("B", "B.mp4", time_offset=0.3),
        "C": Stream("C", "C/%d.png", time_offset=-0.2),
    }
    views = tuple(replace(view, image=streams[view.name]) for view in recording.views)
    with FrameReader(replace(recording, views=views), colour=False) as reader:
        assert reader.frame_count == 30
        shown = {n: numbered_videos.shown(v.image) for n, v in reader.frame_set(20).views.items()}
        assert shown == {"A": 24, "B": 23, "C": 18}
        assert set(reader.frame_set(1).problems) == {"C"}


def test_many_threads_get_their_frames(recording, numbered_videos):
    size = numbered_videos.width * numbered_videos.height
    few = {"cache_bytes": 20 * size, "read_ahead": 4}
    with FrameReader(recording, views=["A", "B"], colour=False, **few) as reader:

        def wrong(seed):
            numbers = np.random.default_rng(seed).integers(0, 33, 40)
            sets = (reader.frame_set(int(k)) for k in numbers)
            return [s.index for s in sets if numbered_videos.shown(s.views["B"].image) != s.index]

        with ThreadPoolExecutor(4) as pool:
            assert not any(pool.map(wrong, range(4)))


def test_an_index_in_the_making_gives_frames_at_once(tmp_path, numbered_videos):
    options = {"g": "12", "bf": "3"}
    path = numbered_videos.write(tmp_path / "v.mkv", "libx264", options=options, frames=900)
    camera = Camera("A", 120, 64, np.diag([100.0, 100, 1]), np.zeros(5), False, IDENTITY)
    view = View("A", "mono", Stream("A", path.name))
    with FrameReader(Recording(tmp_path, "long", 25.0, (view,), {"A": camera})) as reader:
        assert numbered_videos.shown(reader.frame_set(0).views["A"].image) == 0
        assert abs(reader.frame_count_so_far()[0] - 900) < 10
        assert numbered_videos.shown(reader.frame_set(899).views["A"].image) == 899
        assert reader.frame_count == 900
        assert reader.frame_count_so_far() == (900, True)
        with pytest.raises(InputError, match="no frame 900"):
            reader.frame_set(900)


def test_one_view_with_a_coloured_thing_is_enough_to_show_colours():
    grey = np.random.default_rng(5).integers(0, 256, (60, 80), dtype=np.uint8)
    rounding = np.random.default_rng(6).integers(0, 3, (60, 80, 3))
    stored = np.clip(grey[..., None].astype(int) + rounding, 0, 255).astype(np.uint8)
    coloured = np.repeat(grey[..., None], 3, axis=2)
    coloured[20:30, 20:40, 2] = 255 - coloured[20:30, 20:40, 2]
    for pictures, shown in (((), False), ((stored, grey), False), ((grey, coloured), True)):
        views = {str(k): ViewImages(picture) for k, picture in enumerate(pictures)}
        assert shows_colours(FrameSet(0, views)) == shown
