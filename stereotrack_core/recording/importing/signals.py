"""Signals of a source over time, one number per frame or millisecond."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from typing import Any

import av
import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.reading import reason
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.importing.readers import open_source
from stereotrack_core.recording.importing.source import Source
from stereotrack_core.recording.video import open_container, video_stream

SOUND_RATE = 1000.0  # values per second of :func:`loudness`
_WIDTH, _HEIGHT = 80, 60  # pixels to which images are reduced
_SAMPLES = 16_000  # per second, of the sound
_PER_VALUE = int(_SAMPLES / SOUND_RATE)
_SLOW = 15.0  # frames
_STILL = 2.0  # levels of 255; smaller changes of a pixel are noise

IsCancelled = Callable[[], bool]


@dataclass(frozen=True, eq=False)
class Signal:
    """Values at equal steps of time."""

    values: FloatArray  # (N,)
    begin: float = 0.0  # seconds of the first value after the first frame of the source


def brightness(source: Source, cancelled: IsCancelled) -> Signal:
    """Rise of the mean brightness from the frame before (F,); 0 where it falls."""
    means = np.array([float(picture.mean()) for picture in _pictures(source, cancelled)])
    return Signal(np.concatenate([[0.0], np.maximum(np.diff(means), 0.0)]))


def motion(source: Source, cancelled: IsCancelled) -> Signal:
    """How much faster pixels change than in the frames around; see :func:`motion_of`."""
    return Signal(motion_of(_pictures(source, cancelled)))


def motion_of(pictures: Iterable[FloatArray]) -> FloatArray:
    """How much faster pixels change than in the frames around (F,), of :func:`reduced` pictures.

    The square root of their mean change from the frame before, without what varies slowly: phases
    of rest and motion look alike to each other wherever they are laid.
    """
    from scipy.ndimage import gaussian_filter1d

    values, before = [0.0], None
    for picture in pictures:
        if before is not None:
            change = np.abs(picture - before)
            values.append(float(np.sqrt(np.maximum(change - _STILL, 0.0).mean())))
        before = picture
    values[0] = values[1] if len(values) > 1 else 0.0
    slow = gaussian_filter1d(values, _SLOW)
    return np.asarray(np.array(values) - slow)


def loudness(source: Source, cancelled: IsCancelled) -> Signal:
    """Rise of the sound's loudness (N,), one value a millisecond; InputError without sound."""
    if not source.sound:
        what = f"{source.name} has no sound"
        raise InputError(what, where=str(source.path), remedy="Use another method, such as motion.")
    try:
        with open_container(source.path) as container:
            stream = video_stream(container)
            shown = float((stream.start_time or 0) * stream.time_base)
        samples, heard = _sound(source, cancelled)
    except (av.FFmpegError, OSError, IndexError) as error:
        what = f"its sound cannot be read ({reason(error)})"
        remedy = "Use another method, such as motion."
        raise InputError(what, where=str(source.path), remedy=remedy) from None
    count = len(samples) // _PER_VALUE
    loud = np.abs(samples[: count * _PER_VALUE]).reshape(count, _PER_VALUE).mean(axis=1)
    rise = np.maximum(np.diff(loud, prepend=loud[:1]), 0.0)
    return Signal(rise, heard - shown)


def _sound(source: Source, cancelled: IsCancelled) -> tuple[FloatArray, float]:
    """Samples of one channel, and the time of the first in seconds."""
    resampler = av.AudioResampler("flt", "mono", _SAMPLES)
    parts: list[Any] = []
    begin: float | None = None
    with open_container(source.path) as container:
        for frame in container.decode(audio=0):
            if cancelled():
                raise Cancelled
            if begin is None:
                begin = float((frame.pts or 0) * frame.time_base)
            parts += [one.to_ndarray().ravel() for one in resampler.resample(frame)]
    parts += [one.to_ndarray().ravel() for one in resampler.resample(None)]
    return np.concatenate(parts).astype(np.float64), begin or 0.0


def _pictures(source: Source, cancelled: IsCancelled) -> Iterator[FloatArray]:
    """All pictures in grey, reduced (H, W) float32; a damaged one counts as the one before."""
    depth = source.kind == "depth"
    before: Any = np.zeros((_HEIGHT, _WIDTH), np.float32)
    with closing(open_source(source, "depth" if depth else "grey")) as reader:
        for k in range(reader.count()):
            if cancelled():
                raise Cancelled
            with suppress(DamagedFrame):
                picture: Any = reader.read(k, lambda _number, _picture: None)
                before = reduced(picture.astype(np.float32) / (64.0 if depth else 1.0))
            yield before


def reduced(picture: Any) -> FloatArray:
    """A grey picture reduced to (H, W) float32, as :func:`motion_of` compares them."""
    return np.asarray(
        cv2.resize(
            picture.astype(np.float32, copy=False), (_WIDTH, _HEIGHT), interpolation=cv2.INTER_AREA
        )
    )
