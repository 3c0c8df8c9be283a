"""Copies of a video without decoding it: one of its tracks, or its chapters one after another."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import av
import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.recording.video import FrameTimes, open_container, video_stream


def remuxed(files: Sequence[Path], track: int, target: Path) -> Generator[float, None, None]:
    """Write a video track of files that follow each other into one file; yields the share done.

    Raises InputError if the files have different encodings or are not compressed, or the copy lacks
    frames.
    """
    stamps = [_stamps(path, track) for path in files]

    def is_complete(path: Path) -> bool:
        return len(_stamps(path, 0)) == sum(map(len, stamps))

    with replacing(target, is_complete) as temporary:
        try:
            with av.open(str(temporary), "w") as out:
                yield from _copied(files, track, stamps, out)
        except (av.FFmpegError, ValueError, TypeError, IndexError) as error:
            raise InputError(
                f"its packets cannot be copied ({error})",
                where=", ".join(str(path) for path in files),
                remedy="Write a single video of them, with ffmpeg or the program of the camera.",
            ) from None


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
    index = FrameTimes(path, track)
    try:
        return np.array(index.times(), dtype=np.float64)
    finally:
        index.close()
