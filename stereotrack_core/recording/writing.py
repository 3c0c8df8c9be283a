"""Write a recording folder: the description, what it names beside it, videos and pictures."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import asdict
from fractions import Fraction
from itertools import count
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import tomli_w

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.atomic import filling, replacing, write_file
from stereotrack_core.errors import InputError
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording import description
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.folder import DESCRIPTION, FORMAT, named_file
from stereotrack_core.recording.landmarks import write_landmarks
from stereotrack_core.recording.video import FrameTimes, open_container, video_stream


def write_recording_description(
    recording: description.Recording, *, with_calibration: bool = True
) -> None:
    """Write every file of a recording but its pictures into ``recording.folder``, made if need be.

    What the recording does not have is not written, nor ``calibration.toml`` if it lies there.
    Raises InputError where not all can be written; then the folder stays as it was.
    """
    content: dict[str, Any] = {"format": FORMAT, "name": recording.name, "fps": recording.fps}
    content["calibration"] = "calibration.toml"
    with filling(recording.folder) as folder:
        if with_calibration:
            path = folder / "calibration.toml"
            write_calibration(path, recording.cameras, guessed=recording.guessed)
        if recording.subject is not None:
            content["subject"] = "subject.toml"
            description.write_subject(folder / "subject.toml", recording.subject)
        if recording.reference is not None:
            content["reference"] = "reference.csv"
            write_landmarks(folder / "reference.csv", recording.reference)
        if recording.segments:
            content["segments"] = "segments.csv"
            description.write_segments(folder / "segments.csv", recording.segments)
        content["views"] = [_view(view) for view in recording.views]
        write_file(folder / DESCRIPTION, tomli_w.dumps(content))


def replace_calibration(folder: Path, cameras: Cameras) -> Path:
    """Replace the cameras of a recording; the calibration before is kept beside, and returned."""
    target = named_file(folder, "calibration")
    kept = keep_beside(target)
    write_calibration(target, cameras)
    return kept


def keep_beside(path: Path) -> Path:
    """Copy a file that is about to be replaced to a free name beside it, and return that.

    Such as ``calibration-before-1.toml``. Raises InputError where it cannot be read or written.
    """
    content = read_bytes(path, TABLE_BYTES)
    names = (path.with_name(f"{path.stem}-before-{k}{path.suffix}") for k in count(1))
    kept = next(one for one in names if not one.exists())
    write_file(kept, content)
    return kept


def _view(view: description.View) -> dict[str, Any]:
    content: dict[str, Any] = {"name": view.name, "kind": view.kind}
    if view.display_rotation:
        content["display_rotation"] = view.display_rotation
    for key, stream in view.streams().items():
        stated = {name: value for name, value in asdict(stream).items() if value}
        content[key] = {"frames": stream.frames} | stated
    if view.depth is not None:
        content["depth"]["unit"] = view.depth_unit
    return content


_KEY_FRAME_EVERY = 10  # frames; keeps steps backwards and jumps fast
_FULL_RANGE_FORMAT = "yuvj420p"

_RATE_DENOMINATOR = 1001  # enough to write 29.97 frames per second as 30000/1001


class VideoWriter:
    """Write grey or colour pictures as H.264 (MP4) at exact times k / fps.

    Stored as yuv420p, which every player shows, so width and height must be even; grey in full
    range, which is read back without stretching. Use as a context manager: at its end the file is
    there with all pictures, or, after an error, is what it was before. Raises InputError when the
    size, rate or file is not possible, or the drive is full.

    `path`: ends in .mp4 (or .mkv). `crf`: quality of x264; 0 is lossless (for grey exactly, for
    colour but for the colour conversion), 18 is hardly to be told from the original.
    """

    def __init__(
        self, path: Path, fps: float, width: int, height: int, colour: bool = False, crf: int = 12
    ) -> None:
        if width % 2 or height % 2 or width < 2 or height < 2:
            remedy = "Width and height must be even. Otherwise write numbered PNG images."
            raise InputError(f"a video of {width} x {height} pixels is not possible", path, remedy)
        if not 0 < fps < 10000:
            what = f"{fps:g} frames per second is not possible"
            raise InputError(what, path, "Use more than 0 and less than 10000.")
        self._shape = (height, width, 3) if colour else (height, width)
        self._count = 0
        self._time_base = 1 / Fraction(fps).limit_denominator(_RATE_DENOMINATOR)
        with ExitStack() as opening:
            temporary = opening.enter_context(replacing(path, self._holds_all))
            try:
                self._container: Any = av.open(str(temporary), "w")
            except (av.FFmpegError, ValueError) as error:
                what = f"the video cannot be written ({error})"
                raise InputError(what, path, "Use a name that ends in .mp4.") from None
            self._stream: Any = self._container.add_stream("libx264", rate=1 / self._time_base)
            self._stream.width, self._stream.height = width, height
            self._stream.pix_fmt = "yuv420p" if colour else _FULL_RANGE_FORMAT
            speed = {"preset": "fast", "bf": "0", "g": str(_KEY_FRAME_EVERY)}
            self._stream.options = {"crf": str(crf), **speed}
            self._stream.codec_context.thread_count = 1
            self._stream.codec_context.time_base = self._time_base
            self._open = opening.pop_all()

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if error is not None:
            with suppress(av.FFmpegError, OSError):  # of what is thrown away
                self._container.close()
            self._open.__exit__(kind, error, trace)
            return
        with self._open, _os_errors():
            try:
                self._container.mux(self._stream.encode(None))
            finally:
                self._container.close()

    def write(self, picture: ImageArray) -> None:
        """Add a picture, (H, W) or (H, W, 3) BGR uint8 as declared."""
        if picture.shape != self._shape or picture.dtype != np.uint8:
            raise ValueError(f"expected uint8 {self._shape}, got {picture.dtype} {picture.shape}")
        layout = "bgr24" if picture.ndim == 3 else "gray"
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=layout)
        frame = frame.reformat(format=self._stream.pix_fmt)
        frame.pts, frame.time_base = self._count, self._time_base
        with _os_errors():
            self._container.mux(self._stream.encode(frame))
        self._count += 1

    def _holds_all(self, path: Path) -> bool:
        with _os_errors(), av.open(str(path)) as written:
            pictures = sum(1 for packet in written.demux(video=0) if packet.size)
            return pictures == self._count


@contextmanager
def _os_errors() -> Iterator[None]:
    """Raise OSError for whatever the library complains of."""
    try:
        yield
    except av.FFmpegError as error:
        raise OSError(error.errno, error.strerror) from error


def remuxed(files: Sequence[Path], track: int, target: Path) -> Generator[float, None, None]:
    """Write a video track of consecutive files into one, yielding the share; else InputError."""
    stamps = [_stamps(path, track) for path in files]

    def is_complete(path: Path) -> bool:
        return len(_stamps(path, 0)) == sum(map(len, stamps))

    with replacing(target, is_complete) as temporary:
        try:
            with av.open(str(temporary), "w") as out:
                yield from _copied(files, track, stamps, out)
        except (av.FFmpegError, ValueError, TypeError, IndexError) as error:
            what = f"its packets cannot be copied ({error})"
            remedy = "Write a single video of them, with ffmpeg or the program of the camera."
            raise InputError(what, ", ".join(str(path) for path in files), remedy) from None


def _copied(
    files: Sequence[Path], track: int, stamps: Sequence[FloatArray], out: Any
) -> Generator[float, None, None]:
    written: Any = None
    encoding: bytes | None = None
    done, total, begin = 0, max(sum(map(len, stamps)), 1), 0.0
    for path, own in zip(files, stamps, strict=True):
        with open_container(path) as container:
            stream = video_stream(container, track)
            tick = float(stream.time_base)
            settings = bytes(stream.codec_context.extradata or b"")
            if stream.codec_context.name == "rawvideo":  # PyAV loses the code of its pixel format
                raise ValueError("the video is not compressed")
            if written is None:
                written, encoding = out.add_stream_from_template(stream), settings
            elif settings != encoding:
                raise ValueError("the chapters are encoded with other settings")
            shift = round(begin / tick - own[0])
            for packet in container.demux(stream):
                if not packet.size:
                    continue
                packet.pts += shift
                packet.dts = None if packet.dts is None else packet.dts + shift
                packet.stream = written
                out.mux(packet)
                done += 1
                yield min(done / total, 1.0)
            begin += tick * float(own[-1] - own[0] + np.median(np.diff(own)))


def _stamps(path: Path, track: int) -> FloatArray:
    """Time stamps of all frames (N,), in ticks."""
    with closing(FrameTimes(path, track)) as index:
        return np.array(index.times(), dtype=np.float64)


def write_png(path: Path, picture: Any) -> None:
    """Write a picture (uint8), mask (bool) or depth counts (uint16) as PNG; else InputError."""
    pixels = picture.astype(np.uint8) * 255 if picture.dtype == np.bool_ else picture
    done, content = cv2.imencode(".png", pixels)
    if not done:
        raise ValueError(f"a PNG of {picture.dtype} {picture.shape} is not possible")
    write_file(path, content.tobytes())
