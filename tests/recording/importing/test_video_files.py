"""Videos without a stated rate, in several chapters, or with several tracks."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from fractions import Fraction

import av
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import problems_of
from stereotrack_core.recording.importing.making import make_recording
from stereotrack_core.recording.importing.proposing import propose
from stereotrack_core.recording.importing.readers import first_picture, open_source, times_of
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.importing.synchronise import at_one_rate
from tests.recording.importing.clips import FRAMES, HEIGHT, WIDTH, chosen, clip, frames_of, numbered

RAW = {"h264": "libx264", "hevc": "libx265", "mjpeg": "mjpeg"}


def raw_stream(path, codec, frames=FRAMES):
    """A stream without a container."""
    layout = "yuvj420p" if codec == "mjpeg" else "yuv420p"
    with av.open(str(path), "w", format={"libx264": "h264", "libx265": "hevc"}.get(codec)) as out:
        stream = out.add_stream(codec, rate=30)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, layout
        if codec == "libx265":
            stream.options = {"x265-params": "log-level=none"}
        for k in range(frames):
            frame = av.VideoFrame.from_ndarray(numbered(k), format="gray").reformat(format=layout)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


@pytest.mark.parametrize("suffix", RAW)
def test_a_stream_without_a_rate_is_asked_for_it(tmp_path, suffix):
    raw_stream(tmp_path / f"pi.{suffix}", RAW[suffix])
    choices = at_one_rate(chosen(tmp_path))
    assert (choices.uses[0].source.frames, choices.fps) == (FRAMES, None)
    assert "do not state their frame rate" in next(problems_of(choices)).what


def test_a_stream_without_a_rate_that_is_shorter_is_asked_for_it(tmp_path):
    raw_stream(tmp_path / "pi.h264", "libx264", frames=6)
    clip(tmp_path / "usb.mp4", lambda _k: numbered(0), frames=24, fps=20.0)
    choices = chosen(tmp_path)
    with pytest.raises(InputError, match=r"its 6 frames last 0\.3 s, usb 1\.2 s"):
        at_one_rate(choices)
    uses = [replace(use, source=replace(use.source, fps=use.source.fps or 5.0))
            for use in choices.uses]  # fmt: skip
    choices = at_one_rate(replace(choices, uses=tuple(uses)))
    assert [use.source.rate for use in choices.uses] == [20.0, None]
    reader = open_source(choices.uses[0].source, "grey")
    assert reader.count() == 21  # from the first frame to the last one
    reader.close()


def chapters(folder, names, frames=5, picture=numbered):
    for number, name in enumerate(names):
        first = number * frames
        clip(folder / name, lambda k, first=first: picture(first + k), frames=frames)


@pytest.mark.parametrize("starts", ["GX01 GX02", "GH01 GH02", "GOPR GP01"])
def test_chapters_of_a_camera_become_one_stream(tmp_path, starts):
    names = [f"{start}0042.MP4" for start in starts.split()]
    chapters(tmp_path / "in", names)
    found = look_at([tmp_path / "in"])
    (source,) = found.sources
    assert (source.name, source.frames) == (names[0][:-4], 10)
    assert ", ".join(names) in found.notes[0]
    assert np.allclose(times_of(source), np.arange(10) / 25, atol=1e-3)
    recording = make_recording(at_one_rate(propose(found)), tmp_path / "out")
    shown = frames_of(recording)
    assert len(shown) == 10
    for k, views in enumerate(shown):
        assert np.array_equal(views[source.name].image, numbered(k))  # not encoded again


def dated(path, created, frames=50):
    """A video of 25 frames a second with a time of creation of whole seconds."""
    path.parent.mkdir(exist_ok=True)
    with av.open(str(path), "w") as out:
        out.metadata["creation_time"] = created.isoformat(timespec="seconds")
        stream = out.add_stream("libx264", rate=Fraction(25), options={"bf": "0"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        frame = av.VideoFrame.from_ndarray(numbered(0), format="gray").reformat(format="yuv420p")
        for k in range(frames):
            frame.pts = k
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


def test_files_that_begin_when_the_one_before_ends_are_joined(tmp_path):
    begin = datetime(2024, 5, 1, 10, 0, 0, tzinfo=UTC)
    dated(tmp_path / "DJI_0001.MP4", begin)
    dated(tmp_path / "DJI_0002.MP4", begin + timedelta(seconds=2))
    dated(tmp_path / "DJI_0003.MP4", begin + timedelta(seconds=60))
    found = look_at([tmp_path])
    assert {one.name: one.frames for one in found.sources} == {"DJI_0001": 100, "DJI_0003": 50}


def several_tracks(path, frames=4):
    """Colour, depth and infrared in one file, as a Kinect's recorder writes them."""
    with av.open(str(path), "w", options={"allow_raw_vfw": "1"}) as out:
        streams = []
        for title, codec, layout, size in (
            ("COLOR", "mjpeg", "yuvj420p", (WIDTH, HEIGHT)),
            ("DEPTH", "rawvideo", "gray16be", (32, 24)),
            ("IR", "rawvideo", "gray16be", (32, 24)),
        ):
            stream = out.add_stream(codec, rate=30)
            (stream.width, stream.height), stream.pix_fmt = size, layout
            stream.metadata["title"] = title
            streams.append(stream)
        for k in range(frames):
            colour = av.VideoFrame.from_ndarray(numbered(k), format="gray")
            pictures = [colour.reformat(format="yuvj420p")]
            for value in (2000 + k, 300 + k):
                values = np.full((24, 32), value, np.uint16)
                frame = av.VideoFrame.from_ndarray(values, format="gray16le")
                pictures.append(frame.reformat(format="gray16be"))
            for stream, frame in zip(streams, pictures, strict=True):
                frame.pts = k
                out.mux(stream.encode(frame))
        for stream in streams:
            out.mux(stream.encode(None))
    # the FOURCC of the Kinect's recorder, which PyAV cannot set
    header = b"\x01\x00\x10\x00", b"\x00\x06\x00\x00"
    path.write_bytes(path.read_bytes().replace(bytes(4).join(header), b"b16g".join(header)))


def test_every_track_of_a_file_is_a_source(tmp_path):
    (tmp_path / "in").mkdir()
    several_tracks(tmp_path / "in" / "walk.mkv")
    found = look_at([tmp_path / "in"])
    assert [(one.name, one.kind, one.size) for one in found.sources] == [
        ("walk_color", "video", (WIDTH, HEIGHT)),
        ("walk_depth", "depth", (32, 24)),
        ("walk_ir", "depth", (32, 24)),
    ]
    sizes = [first_picture(one).shape[:2] for one in found.sources]
    assert sizes == [(HEIGHT, WIDTH), (24, 32), (24, 32)]
    choices = propose(found)
    assert {use.source.name: (use.role, use.view) for use in choices.uses} == {
        "walk_color": ("mono", "walk_color"),
        "walk_depth": ("depth", "walk"),
        "walk_ir": ("image", "walk"),
    }
    *_, shown = frames = frames_of(make_recording(choices, tmp_path / "out"))
    assert len(frames) == 4
    assert np.allclose(shown["walk"].depth, 2.003)
    assert shown["walk"].image.max() == round(255 * 303 / 1023)
    assert shown["walk_color"].image.mean() == pytest.approx(numbered(3).mean(), abs=3)
