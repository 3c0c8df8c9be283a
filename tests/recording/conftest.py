"""Videos whose frames carry their number as a bar code that survives lossy coding."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Segment, Stream, Subject, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description

BITS = 10
STRIPE = 12
WIDTH, HEIGHT = BITS * STRIPE, 64
TIME_BASE = Fraction(1, 1000)


def bar_code(number: int) -> np.ndarray:
    """Picture (HEIGHT, WIDTH) uint8 that shows `number`."""
    bits = (number >> np.arange(BITS)) & 1
    row = np.repeat(np.where(bits, 220, 30), STRIPE).astype(np.uint8)
    return np.tile(row, (HEIGHT, 1))


def number_shown(picture: np.ndarray) -> int:
    """The number that a picture shows, by majority within each stripe."""
    grey = picture if picture.ndim == 2 else picture[..., 1]
    stripes = grey.reshape(HEIGHT, BITS, STRIPE)[8:-8, :, 3:-3].mean(axis=(0, 2))
    assert not ((stripes > 90) & (stripes < 160)).any(), stripes
    return int(((stripes > 125) << np.arange(BITS)).sum())


def evenly(i: int) -> int:
    """Milliseconds at which frame i of 25 per second is shown."""
    return 40 * i


def write_video(
    path: Path,
    codec: str,
    *,
    pixels: str = "yuv420p",
    options: dict[str, str] | None = None,
    times: Callable[[int], int] = evenly,
    frames: int = 60,
    numbers: Callable[[int], int] = lambda i: i,
    container_options: dict[str, str] | None = None,
    container_format: str | None = None,
) -> Path:
    """Encode frames that show their number at the given times in milliseconds."""
    with av.open(
        str(path), "w", format=container_format, options=container_options or {}
    ) as container:
        stream = container.add_stream(codec, rate=25)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, pixels
        stream.options = options or {}
        stream.codec_context.time_base = TIME_BASE
        stream.time_base = TIME_BASE
        for i in range(frames):
            grey = av.VideoFrame.from_ndarray(bar_code(numbers(i)), format="gray")
            frame = grey.reformat(format=pixels)
            frame.pts, frame.time_base = times(i), TIME_BASE
            for packet in stream.encode(frame):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
    return path


X264 = {"crf": "20", "g": "12", "bf": "3", "b-adapt": "0"}

KINDS: dict[str, dict] = {
    "h264-b.mp4": {"codec": "libx264", "options": X264},
    "h264-late.mp4": {"codec": "libx264", "options": X264, "times": lambda i: 700 + 40 * i},
    "h264-vfr.mkv": {
        "codec": "libx264",
        "options": X264,
        "times": lambda i: 500 + 33 * i + 7 * (i % 3) + (900 if i > 30 else 0),
    },
    "h264-open-gop.mkv": {
        "codec": "libx264",
        "options": {"x264-params": "open-gop=1:bframes=3:keyint=12:min-keyint=12:scenecut=0"},
    },
    "h264-one-key.mp4": {"codec": "libx264", "options": {**X264, "g": "600"}},
    "h264-plain.mp4": {"codec": "libx264", "options": {"g": "10", "bf": "0"}},
    "h264-grey.mp4": {"codec": "libx264", "options": X264, "pixels": "gray"},
    "h264-fragments.mp4": {
        "codec": "libx264",
        "options": X264,
        "container_options": {"movflags": "frag_keyframe+empty_moov"},
    },
    "h264.ts": {"codec": "libx264", "options": X264},
    "h264-raw.h264": {"codec": "libx264", "options": X264, "container_format": "h264"},
    "h265.mp4": {
        "codec": "libx265",
        "options": {"x265-params": "keyint=12:bframes=3:log-level=none"},
    },
    "vp9.webm": {
        "codec": "libvpx-vp9",
        "options": {"g": "15", "auto-alt-ref": "1", "lag-in-frames": "16", "cpu-used": "8"},
    },
    "mpeg4.avi": {"codec": "mpeg4", "options": {"g": "12", "qscale": "3"}},
    "mpeg4-b.avi": {"codec": "mpeg4", "options": {"g": "12", "bf": "2"}},
    "ffv1.mkv": {"codec": "ffv1", "pixels": "gray"},
    "mjpeg.avi": {"codec": "mjpeg", "pixels": "yuvj420p"},
}
"""Arguments of `write_video` by file name."""


SMALL = 8  # frames of the small recording
VIEWPOINTS = {"N": 90.0, "O": 0.0, "S": 270.0, "W": 180.0}


def looking_at_the_person(azimuth_deg: float, *, aside: float = 0.0) -> RigidTransform:
    """camera_from_world 3 m away, 1.5 m high; `aside` metres to the camera's own right."""
    azimuth = np.radians(azimuth_deg)
    outwards = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    z = -outwards
    y = np.array([0.0, 0.0, -1.0])
    x = np.cross(y, z)
    rotation = np.stack([x, y, z])
    place = 3 * outwards + [0, 0, 1.2] + aside * x
    return RigidTransform(rotation, -rotation @ place)


@pytest.fixture
def small_recording(tmp_path):
    """Folder of four stereo views of 48 x 36 pixels as numbered images, all in order."""
    rng = np.random.default_rng(5)
    matrix = np.array([[40.0, 0, 23.5], [0, 40, 17.5], [0, 0, 1]])
    cameras, views = {}, []
    for name, azimuth in VIEWPOINTS.items():
        for side, aside in (("left", -0.05), ("right", 0.05)):
            place = looking_at_the_person(azimuth, aside=aside)
            camera = Camera(f"{name}_{side}", 48, 36, matrix, np.zeros(5), False, place)
            cameras[camera.name] = camera
            (tmp_path / camera.name).mkdir()
            scene = rng.integers(60, 200, (36, 48))
            for k in range(SMALL):
                image = (scene + rng.integers(-20, 20, scene.shape)).astype(np.uint8)
                write_png(tmp_path / camera.name / f"{k:03d}.png", image)
        left, right = (
            Stream(f"{name}_{s}", f"{name}_{s}/%03d.png", background=f"{name}_{s}/000.png")
            for s in ("left", "right")
        )
        views.append(View(name, "stereo", right, left=left))
    standing = np.array(
        [
            [-0.2, 0, 1.4],
            [0.2, 0, 1.4],
            [-0.5, 0, 1.4],
            [0.5, 0, 1.4],
            [-0.8, 0, 1.4],
            [0.8, 0, 1.4],
            [0, 0, 1.6],
            [-0.15, 0, 0.9],
            [0.15, 0, 0.9],
        ]
    )
    recording = Recording(
        tmp_path,
        "small",
        10.0,
        tuple(views),
        cameras,
        subject=Subject("P", shoulder_width=0.4, torso_length=0.5),
        reference=LandmarkTrajectory(np.arange(SMALL), np.tile(standing, (SMALL, 1, 1))),
        segments=(Segment("t-pose", 0, SMALL),),
    )
    write_recording_description(recording)
    return recording


def pytest_generate_tests(metafunc):
    if "video_kind" in metafunc.fixturenames:
        metafunc.parametrize("video_kind", sorted(KINDS))


class NumberedVideos:
    """What tests need of this file."""

    write = staticmethod(write_video)
    shown = staticmethod(number_shown)
    bar_code = staticmethod(bar_code)
    width, height = WIDTH, HEIGHT

    @staticmethod
    def of_kind(folder: Path, kind: str) -> Path:
        return write_video(folder / kind, **KINDS[kind])


@pytest.fixture
def numbered_videos():
    return NumberedVideos
