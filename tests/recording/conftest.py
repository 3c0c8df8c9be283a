"""Videos whose frames carry their number as a bar code that survives lossy coding."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from tests.recording.small import written_recording

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
    options_of_all = container_options or {}
    with av.open(str(path), "w", format=container_format, options=options_of_all) as container:
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
    "h264-b.mp4": {},
    "h264-late.mp4": {"times": lambda i: 700 + 40 * i},
    "h264-vfr.mkv": {"times": lambda i: 500 + 33 * i + 7 * (i % 3) + (900 if i > 30 else 0)},
    "h264-open-gop.mkv": {
        "options": {"x264-params": "open-gop=1:bframes=3:keyint=12:min-keyint=12:scenecut=0"}
    },
    "h264-one-key.mp4": {"options": {**X264, "g": "600"}},
    "h264-plain.mp4": {"options": {"g": "10", "bf": "0"}},
    "h264-grey.mp4": {"pixels": "gray"},
    "h264-fragments.mp4": {"container_options": {"movflags": "frag_keyframe+empty_moov"}},
    "h264.ts": {},
    "h264-raw.h264": {"container_format": "h264"},
    "h265.mp4": {
        "codec": "libx265", "options": {"x265-params": "keyint=12:bframes=3:log-level=none"},
    },
    "vp9.webm": {
        "codec": "libvpx-vp9",
        "options": {"g": "15", "auto-alt-ref": "1", "lag-in-frames": "16", "cpu-used": "8"},
    },
    "mpeg4.avi": {"codec": "mpeg4", "options": {"g": "12", "qscale": "3"}},
    "mpeg4-b.avi": {"codec": "mpeg4", "options": {"g": "12", "bf": "2"}},
    "ffv1.mkv": {"codec": "ffv1", "pixels": "gray", "options": {}},
    "mjpeg.avi": {"codec": "mjpeg", "pixels": "yuvj420p", "options": {}},
}  # fmt: skip
"""Arguments of `write_video` by file name, where they are other than those of H.264."""


@pytest.fixture
def small_recording(tmp_path):
    """Folder of four stereo views of 48 x 36 pixels as numbered images, all in order."""
    return written_recording(tmp_path)


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
        return write_video(folder / kind, **{"codec": "libx264", "options": X264, **KINDS[kind]})


@pytest.fixture
def numbered_videos():
    return NumberedVideos
