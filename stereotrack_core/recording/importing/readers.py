"""The pictures of a source by number, at a constant rate, and with 8 bits.

Of pictures with more than 8 bits one value becomes white in the whole recording, so that brightness
means the same in every picture and in both images of a stereo camera. It is the largest value of
the sensor (255, 1023, 4095, 16383 or 65535): as the files state it, else the smallest that the
pictures stay below.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import open_file
from stereotrack_core.recording import images
from stereotrack_core.recording.importing.choices import AGAIN, Choices, Source
from stereotrack_core.recording.stream_files import StreamSource, no_video
from stereotrack_core.recording.video import FrameTimes, VideoStream, open_container, video_stream

Pictures: TypeAlias = "StreamSource | EightBit | Picked"
"""Pictures of a source by number; used by one thread at a time."""

_NEAR_GREY, _FAR_GREY = 255.0, 40.0


def open_source(source: Source, kind: images.PictureKind) -> Pictures:
    """Open a source to read frames by number at its chosen rate; InputError where it cannot be."""
    if source.bits > 8 and kind in ("grey", "colour"):
        reader: Pictures = EightBit(open_stored(source), source.white, grey=kind == "grey")
    else:
        reader = open_stored(source, kind)
    if source.rate is None:
        return reader
    try:
        times = times_of(source)
    except InputError:
        reader.close()
        raise
    return resampled(reader, times, source.rate, source.begin)


def open_stored(source: Source, kind: images.PictureKind = "stored") -> Pictures:
    """Open a source to read frames as stored, 8 or 16 bits; InputError where it cannot be."""
    if source.images:
        files = dict(zip(source.numbers, source.images, strict=True))
        unit = source.unit if kind == "depth" else None
        return images.NumberedImages(files, source.pattern or "%d", kind, unit)
    chapters: list[VideoStream] = []
    for path in source.chapters or (source.path,):
        try:
            chapters.append(VideoStream(path, kind, source.track))
        except (av.FFmpegError, OSError, IndexError) as error:
            for one in chapters:
                one.close()
            raise no_video(error, str(path)) from None
    return chapters_of(chapters)


def times_of(source: Source) -> FloatArray:
    """Seconds of every frame (N,) after the first one, ascending."""
    if source.times:
        return np.array([time - source.times[0] for time in source.times])
    if source.images or not source.clock:
        return np.arange(source.frames) / (source.fps or 1.0)
    times = [_times_of_video(path, source) for path in source.chapters or (source.path,)]
    step = 1.0 / (source.fps or 1.0)
    begins = np.cumsum([0.0, *(float(one[-1]) + step for one in times)])
    return np.concatenate([one + begin for one, begin in zip(times, begins, strict=False)])


def _times_of_video(path: Path, source: Source) -> FloatArray:
    """Seconds of every frame (N,) of one file after its first one, ascending."""
    try:
        with open_container(path) as container:
            tick = float(video_stream(container, source.track).time_base)
    except (av.FFmpegError, OSError, IndexError) as error:
        raise no_video(error, str(path)) from None
    with closing(FrameTimes(path, source.track)) as index:
        stamps = np.array(index.times(), dtype=np.float64)
    if not (index.ordered and len(stamps)):
        remedy = "Convert it to MP4 with a constant frame rate, or keep its frames as they come."
        raise InputError("the times of its frames are missing or repeat", path, remedy)
    return np.asarray((stamps - stamps[0]) * tick)


class EightBit:
    """Pictures of more than 8 bits as uint8, of values up to `white` (0 stands for 65535)."""

    def __init__(self, reader: Pictures, white: int, *, grey: bool) -> None:
        self._reader, self._white, self._grey = reader, white or images.WHITEST, grey
        self.count: Callable[[], int] = reader.count
        self.close: Callable[[], None] = reader.close

    def read(self, k: int, keep: images.Keep) -> NDArray[Any]:  # noqa: ARG002 - those have other values
        """Picture of frame k."""
        picture = self._reader.read(k, lambda _number, _picture: None)
        if self._grey and picture.ndim == 3:
            picture = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        return images.brightness_of(picture, self._white)


class Picked:
    """Frames of some readers in an order of their own, which is asked for when it is needed."""

    def __init__(
        self, readers: Sequence[Pictures], order: Callable[[], Sequence[tuple[int, int]]]
    ) -> None:
        self._readers, self._order = readers, cache(order)

    def count(self) -> int:
        """Number of frames; of chapters, waits until the end of every file has been reached."""
        return len(self._order())

    def read(self, k: int, keep: images.Keep) -> NDArray[Any]:  # noqa: ARG002 - numbers differ
        """Picture of frame k."""
        if not 0 <= k < self.count():
            raise images.DamagedFrame(f"there is no frame {k}")
        reader, own = self._order()[k]
        return self._readers[reader].read(own, lambda _number, _picture: None)

    def close(self) -> None:
        """Close all files."""
        for one in self._readers:
            one.close()


def chapters_of(readers: Sequence[Pictures]) -> Pictures:
    """The frames of a video whose camera split it into several files."""
    if len(readers) == 1:
        return readers[0]
    return Picked(
        readers, lambda: [(i, k) for i, one in enumerate(readers) for k in range(one.count())]
    )


def resampled(reader: Pictures, times: FloatArray, rate: float, begin: float) -> Picked:
    """Frames at a constant rate: each is the one of a reader that is nearest in time.

    Frame j is of the instant `begin` + j / `rate` in seconds after the first frame of the source.
    """
    length = max(float(times[-1]) - begin, 0.0)
    wanted = begin + np.arange(int(length * rate + 0.5) + 1) / rate
    after = np.clip(np.searchsorted(times, wanted), 1, max(len(times) - 1, 1))
    last = len(times) - 1
    before, after = np.minimum(after - 1, last), np.minimum(after, last)
    nearer = np.abs(times[before] - wanted) <= np.abs(times[after] - wanted)
    chosen = [(0, k) for k in np.where(nearer, before, after).tolist()]
    return Picked([reader], lambda: chosen)


def first_picture(source: Source, *, as_depth: bool = True) -> ImageArray:
    """The first picture (H, W) or (H, W, 3) BGR uint8, depth as near or far, if `as_depth`."""
    depth = source.kind == "depth" and as_depth
    kind: images.PictureKind = "depth" if depth else "colour"
    try:
        if source.images or source.bits > 8:
            with closing(open_source(replace(source, rate=None), kind)) as reader:
                picture = reader.read(0, lambda _number, _picture: None)
        else:  # without an index of all of it
            with open_container(source.path) as container:
                stream = video_stream(container, source.track)
                picture = images.picture_of(next(container.decode(stream)), kind)
    except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
        raise no_video(error, str(source.path)) from None
    except images.DamagedFrame as problem:
        raise InputError(str(problem), source.path, AGAIN) from None
    return shown_depth(picture, depth_range(picture)) if depth else picture


def pictures_spread(reader: Pictures, most: int) -> Iterator[NDArray[Any]]:
    """At most so many pictures, spread over a source; damaged ones are told when written."""
    for k in images.spread(reader.count(), most):
        with suppress(images.DamagedFrame):
            yield reader.read(k, lambda _number, _picture: None)


def depth_range(counts: NDArray[Any]) -> tuple[float, float]:
    """Nearest and farthest counts of depth maps of any shape but for single ones; 0 is no value."""
    known = counts[counts > 0]
    if not known.size:
        return 0.0, 1.0
    near, far = np.percentile(known, (1, 99))
    return float(near), float(far)


def shown_depth(counts: NDArray[Any], within: tuple[float, float]) -> ImageArray:
    """Depth counts (H, W) as brightness (H, W) uint8, near bright; 0, no value, stays black."""
    near, far = within
    share = (counts.astype(np.float32) - near) / max(far - near, 1.0)
    shown = _NEAR_GREY + (_FAR_GREY - _NEAR_GREY) * np.clip(share, 0.0, 1.0)
    return np.where(counts > 0, shown, 0.0).astype(np.uint8)


_MAX_SAMPLE_VALUE = 281  # TIFF's tag
_PNG_HEADER_BYTES = 1024


def measured(source: Source) -> Source:
    """The source with its white, measured if above 8 bits; InputError if not opened."""
    if source.bits <= 8 or source.unit is not None or source.white:
        return source
    counts = np.zeros(images.WHITEST + 1, dtype=np.int64)
    with closing(open_stored(source)) as reader:
        for picture in pictures_spread(reader, images.MEASURED_PICTURES):
            counts += np.bincount(picture.ravel(), minlength=images.WHITEST + 1)
    white = images.white_of(counts, _stated(source.path) if source.images else None)
    saturated = float(counts[white:].sum() / max(int(counts.sum()), 1))
    return replace(source, white=white, saturated=saturated)


def _stated(path: Path) -> int | None:
    """The largest value that a TIFF or PNG states for its pictures of 16 bits."""
    from PIL import Image, UnidentifiedImageError

    with suppress(OSError, UnidentifiedImageError, ValueError, Image.DecompressionBombError):
        with open_file(path) as file:
            header = file.read(_PNG_HEADER_BYTES).partition(b"IDAT")[0]
        if header.startswith(b"\x89PNG"):
            bits = header.partition(b"sBIT")[2][:1]
            return 2 ** bits[0] - 1 if bits and 8 <= bits[0] <= 16 else None
        with Image.open(path) as image:
            value = getattr(image, "tag_v2", {}).get(_MAX_SAMPLE_VALUE)
        largest = max(value) if isinstance(value, tuple) else value
        return int(largest) if largest and 255 <= largest < images.WHITEST else None
    return None


def with_one_white(choices: Choices) -> Choices:
    """Choices with one white of pictures above 8 bits, and one of depth cameras' infrared ones."""
    uses = list(choices.uses)
    used = [k for k, use in enumerate(uses) if use.role not in ("depth", "unused")]
    shown = [k for k in used if uses[k].source.bits > 8]  # those that are written again with 8
    sources = {k: measured(uses[k].source) for k in shown}
    for k in shown:
        alike = [j for j in shown if (uses[j].role == "image") == (uses[k].role == "image")]
        white = max(sources[j].white for j in alike)
        uses[k] = replace(uses[k], source=replace(sources[k], white=white))
    return replace(choices, uses=tuple(uses))
