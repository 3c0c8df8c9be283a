"""What is written is read back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Segment, Stream, Subject, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.images import counts_of
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader, metres_of
from stereotrack_core.recording.writing import VideoWriter, write_png, write_recording_description


def camera(name, width=120, height=64, fisheye=False, shift=0.0):
    return Camera(
        name,
        width,
        height,
        np.array([[100.0, 0.5, 60.25], [0, 101, 31.5], [0, 0, 1]]),
        np.array([0.1, -0.2, 0.003, 0.004]),
        fisheye,
        RigidTransform(rotation_from_vector(np.array([0.1, 0.2, 0.3])), np.array([shift, 1, 2.0])),
    )


def recording_of(folder, views, cameras, **optional):
    return Recording(folder, "small", 12.5, tuple(views), {c.name: c for c in cameras}, **optional)


@pytest.fixture
def written(tmp_path, numbered_videos):
    """A folder with a stereo, a depth and a mono view, and what was put into it."""
    folder = tmp_path / "small"
    points = np.full((3, 9, 3), np.nan)
    points[0, 0] = 1.25, -2.5, 0.123456
    points[2, 3:5] = 0.5
    views = (
        View("N", "stereo", Stream("N_right", "N_right.mp4"), left=Stream("N_left", "N_left.mp4")),
        View(
            "O",
            "depth",
            Stream("O", "O/%04d.png", background="empty.png"),
            depth=Stream("O", "O_depth/%04d.png"),
            depth_unit=0.0005,
            mask=Stream("", "O_mask/%04d.png"),
        ),
        View("S", "mono", Stream("S", "S.mp4", first_frame=2), display_rotation=90),
    )
    recording = recording_of(
        folder,
        views,
        [camera("N_left"), camera("N_right", shift=-0.1), camera("O"), camera("S", fisheye=True)],
        subject=Subject("P", shoulder_width=0.4, hand_length=0.18),
        reference=LandmarkTrajectory(np.array([0, 1, 7]), points),
        segments=(Segment("walk, slowly", 0, 3), Segment("punch", 3, 5)),
    )
    write_recording_description(recording)
    for name in ("O", "O_depth", "O_mask"):
        (folder / name).mkdir()
    for name, count in (("N_left", 6), ("N_right", 6), ("S", 8)):
        path, size = folder / f"{name}.mp4", {"width": 120, "height": 64}
        with VideoWriter(path, fps=12.5, colour=name == "S", **size) as video:
            for k in range(count):
                picture = numbered_videos.bar_code(k)
                video.write(picture if name != "S" else np.repeat(picture[..., None], 3, axis=2))
    counts = np.arange(64 * 120, dtype=np.uint16).reshape(64, 120)
    for k in range(6):
        write_png(folder / f"O/{k + 3:04d}.png", numbered_videos.bar_code(k))
        write_png(folder / f"O_depth/{k + 3:04d}.png", counts + np.uint16(k))
        write_png(folder / f"O_mask/{k + 3:04d}.png", counts % 2 == 0)
    write_png(folder / "empty.png", numbered_videos.bar_code(99))
    return recording


def test_the_description_comes_back(written):
    found = open_recording(written.folder)
    assert (found.name, found.fps, found.views) == (written.name, written.fps, written.views)
    assert (found.subject, found.segments) == (written.subject, written.segments)
    assert np.array_equal(found.reference.frame, written.reference.frame)
    points = (one.reference.points for one in (found, written))
    assert np.allclose(*points, rtol=0, atol=1e-6, equal_nan=True)
    for name, made in written.cameras.items():
        read = found.cameras[name]
        assert (read.width, read.height, read.fisheye) == (made.width, made.height, made.fisheye)
        assert np.array_equal(read.matrix, made.matrix)
        assert np.array_equal(read.distortions, made.distortions)
        places = (one.camera_from_world.matrix() for one in (read, made))
        assert np.allclose(*places, rtol=0, atol=1e-15)


def test_the_pictures_come_back(written, numbered_videos):
    with FrameReader(open_recording(written.folder)) as reader:
        assert reader.frame_count == 6
        for k in (0, 5, 2):
            frame_set = reader.frame_set(k)
            assert not frame_set.problems
            stereo, depth, mono = (frame_set.views[name] for name in "NOS")
            assert numbered_videos.shown(stereo.image) == numbered_videos.shown(stereo.left) == k
            assert numbered_videos.shown(mono.image) == k + 2
            assert mono.image.shape == (64, 120, 3)
            assert depth.image.shape == (64, 120)
            assert np.array_equal(depth.image, numbered_videos.bar_code(k))
            counts = np.arange(64 * 120).reshape(64, 120) + k
            expected = np.where(counts == 0, np.nan, counts * 0.0005)
            assert depth.depth.dtype == np.float32
            assert np.allclose(depth.depth, expected, rtol=1e-6, equal_nan=True)
            assert np.array_equal(depth.mask, np.arange(64 * 120).reshape(64, 120) % 2 == 0)
        left, image = reader.background("O")
        assert left is None
        assert np.array_equal(image, numbered_videos.bar_code(99))
        assert reader.background("N") is None


def test_lossless_grey_video_comes_back_bit_by_bit(tmp_path):
    pictures = np.random.default_rng(0).integers(0, 256, (5, 48, 64), dtype=np.uint8)
    with VideoWriter(tmp_path / "v.mp4", fps=29.97, width=64, height=48, crf=0) as video:
        for picture in pictures:
            video.write(picture)
    view = View("V", "mono", Stream("V", "v.mp4"))
    recording = recording_of(tmp_path, [view], [camera("V", 64, 48)])
    write_recording_description(recording)
    for colour in (True, False):
        with FrameReader(open_recording(tmp_path), colour=colour) as reader:
            for k, picture in enumerate(pictures):
                image = reader.frame_set(k).views["V"].image
                assert image.ndim == (3 if colour else 2)
                assert np.array_equal(image[..., 1] if colour else image, picture)


def test_a_video_of_odd_size_is_refused(tmp_path):
    with pytest.raises(InputError, match="even"):
        VideoWriter(tmp_path / "v.mp4", fps=10, width=63, height=48)


@given(hnp.arrays(np.uint16, (3, 4)), st.sampled_from([0.001, 0.0005, 0.0001, 1 / 3000]))
def test_depth_counts_come_back(counts, unit):
    assert np.array_equal(counts_of(metres_of(counts, unit), unit), counts)
