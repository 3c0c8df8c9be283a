"""Contents of a video file: its tracks, their number of frames, rate and start."""

import re
from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import av
import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import check_file
from stereotrack_core.recording.importing.choices import Source
from stereotrack_core.recording.stream_files import is_video, no_video
from stereotrack_core.recording.video import FrameTimes, open_container, video_stream, video_tracks

_RAW_STREAMS = frozenset(
    {"av1", "avs2", "avs3", "cavsvideo", "dirac", "evc", "h261", "h263", "h264", "hevc", "m4v"}
    | {"mjpeg", "mjpeg_2000", "mpegvideo", "obu", "rawvideo", "vc1", "vvc"}
)
"""FFmpeg's names of streams without a container."""


_MOST_PACKETS = 5000  # of a video without an index, to see whether its frame rate is constant
_USUAL_RATES = (5, 6, 10, 12, 12.5, 15, 20, 24, 25, 29.97, 30, 48, 50, 59.94, 60, 90, 100, 120)
_AS_USUAL = 0.01  # of a rate
MOST_UNEVEN = 0.75  # frames by which a stream may be uneven without being resampled


def rate_of(times: FloatArray) -> tuple[float, float, float]:
    """Frames per second of times (N,) by the usual step, unevenness (frames), pause (s)."""
    steps = np.diff(times)
    usual = float(np.median(steps))
    rate = 1.0 / usual if usual > 0 else 1.0
    nearest = min(_USUAL_RATES, key=lambda one: abs(rate / one - 1.0))
    rate = float(nearest) if abs(rate / nearest - 1.0) < _AS_USUAL else rate
    return rate, unevenness(times, rate), float(steps.max())


def unevenness(times: FloatArray, rate: float) -> float:
    """Largest distance of times (N,) in seconds from places at a rate, in frames."""
    return float(np.abs((times - times[0]) * rate - np.arange(len(times))).max())


def tracks_of(path: Path) -> list[Source]:
    """The video tracks of a file; each has a name of its own if there are several."""
    check_file(path)
    try:
        with open_container(path) as container:
            metadata = [one.metadata for one in video_tracks(container)]
        sources = [_video(path, track) for track in range(len(metadata))]
    except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
        raise no_video(error, str(path)) from None
    if not sources:
        raise no_video(IndexError(), str(path))
    if len(sources) == 1:
        return sources
    named = []
    for one, own in zip(sources, metadata, strict=True):
        title = (own.get("title") or own.get("handler_name") or "").strip()
        if not title or title.lower().endswith("handler"):
            title = "depth" if one.kind == "depth" else f"track{one.track + 1}"
        title = title.lower().replace(" ", "_")
        named.append(replace(one, name=f"{path.stem}_{title}", tracks=len(sources)))
    return named


def _video(path: Path, track: int) -> Source:
    with open_container(path) as container:
        stream = video_stream(container, track)
        # for raw streams, FFmpeg assumes 25 frames per second
        context, clock = stream.codec_context, container.format.name not in _RAW_STREAMS
        rate = stream.average_rate or stream.guessed_rate
        frame = next(container.decode(stream))
        depth = frame.format.name.startswith("gray16")
        turned = -round(float(getattr(frame, "rotation", 0) or 0) / 90.0) * 90 % 360
        seconds = None if container.duration is None else container.duration / av.time_base
        fps = float(rate) if rate and clock else None
        frames = stream.frames or round((seconds or 0.0) * (fps or 0.0))
        created, sound = _created(container, stream), bool(container.streams.audio)
        fps, uneven, pause = _steadiness(path, stream, track, fps, clock=clock)
    if not frames:
        with closing(FrameTimes(path, track)) as index:
            frames = index.count()
    return Source(
        name=path.stem, path=path, kind="depth" if depth else "video",
        width=int(context.width), height=int(context.height),
        frames=int(frames), fps=fps, clock=clock, track=track,
        bits=16 if depth else 8, created=created,
        start=created if created and created % 1.0 else None,
        sound=sound, turned=turned, uneven=uneven, pause=pause,
    )  # fmt: skip


def _steadiness(
    path: Path, stream: Any, track: int, fps: float | None, *, clock: bool
) -> tuple[float | None, float, float]:
    """Frames per second, how far from even they are in frames, and the longest pause in seconds.

    By the container's index, else by its first packets. The rate of an uneven video is that of its
    usual step, not the average that the container states.
    """
    stamps = [e.timestamp for e in getattr(stream, "index_entries", ()) if not e.is_discard]
    if not 2 < stream.frames == len(stamps):
        with open_container(path) as container:
            packets = container.demux(video_stream(container, track))
            some = (packet for packet, _ in zip(packets, range(_MOST_PACKETS), strict=False))
            stamps = [one.pts for one in some if one.pts is not None and not one.is_discard]
    times = np.sort(np.array(stamps, dtype=np.float64)) * float(stream.time_base or 0)
    if len(times) < 3 or times[-1] <= times[0] or not clock:
        return fps, 0.0, 0.0
    if fps is None:
        return rate_of(times)
    uneven = unevenness(times, fps)
    if uneven > MOST_UNEVEN:
        return rate_of(times)
    return fps, uneven, float(np.diff(times).max())


def chapters_from(path: Path) -> tuple[Path, ...]:
    """A video and the files beside it in which the camera went on with it, in their order."""
    own = chapter_of(path)
    beside = [
        one
        for one in sorted(path.parent.iterdir())
        if is_video(one)
        and one.name > path.name
        and (is_next_file(path, one) if own is None else (chapter_of(one) or own)[0] == own[0])
    ]
    found: list[Source] = []
    for one in (path, *beside):
        with suppress(av.FFmpegError, OSError, IndexError, StopIteration, InputError):
            check_file(one)
            found.append(_video(one, 0))
    whole = next((one for one in joined(found)[0] if one.path == path), None)
    return (whole.chapters if whole is not None else ()) or (path,)


def _created(container: Any, stream: Any) -> float | None:
    """When a video was taken, in seconds since 1970: with fractions where one is stated."""
    found = []
    for metadata in (stream.metadata, container.metadata):
        text = metadata.get("com.apple.quicktime.creationdate") or metadata.get("creation_time")
        with suppress(ValueError):
            found.append(datetime.fromisoformat(text or "").timestamp())
    found = [created for created in found if created > 0]
    return next((created for created in found if created % 1.0), next(iter(found), None))


# Videos that a camera splits while it records. GoPro states it in the names; other cameras (DJI,
# Canon, Panasonic, AVCHD) number their files, and times of creation tell what follows what.
_GOPRO = re.compile(r"(G[HXSL])(\d{2})(\d{4})", re.IGNORECASE)  # GX010042: chapter 1 of video 42
_OLD_GOPRO = re.compile(r"(?:GOPR|GP(\d{2}))(\d{4})", re.IGNORECASE)  # GOPR0042, GP010042, ...
_SAME_INSTANT_S = 1.5  # times of creation are whole seconds, rounded either way


def chapter_of(path: Path) -> tuple[str, int] | None:
    """The video that a file of a GoPro belongs to, and its chapter from 1; None for other names."""
    stem = path.stem
    if match := _GOPRO.fullmatch(stem):
        return f"{match[1].upper()}{match[3]}", int(match[2])
    if match := _OLD_GOPRO.fullmatch(stem):  # before HERO6
        return f"GOPR{match[2]}", int(match[1] or 0) + 1
    return None


def is_next_file(before: Path, after: Path) -> bool:
    """Whether two files lie beside each other with names that differ in their numbers only."""
    alike = [re.sub(r"\d+", "0", path.name.casefold()) for path in (before, after)]
    return before.parent == after.parent and alike[0] == alike[1] and before.name < after.name


def joined(sources: Sequence[Source]) -> tuple[list[Source], list[str]]:
    """The sources with consecutive chapters of a video as one, and notes about chapters."""
    result: list[Source] = []
    notes = []
    for one in sources:
        place = next((k for k, other in enumerate(result) if _follows(other, one)), None)
        if place is not None:
            first = result[place]
            result[place] = replace(
                first, chapters=(*(first.chapters or (first.path,)), one.path),
                frames=first.frames + one.frames, sound=first.sound and one.sound,
                uneven=max(first.uneven, one.uneven), pause=max(first.pause, one.pause),
            )  # fmt: skip
            continue
        result.append(one)
        named = chapter_of(one.path)
        if named is not None and named[1] > 1:
            notes.append(
                f"{one.path.name} is chapter {named[1]} of a video whose chapter before is not "
                "there, or does not fit: it is a separate source"
            )
    for one in result:
        if one.chapters:
            names = ", ".join(path.name for path in one.chapters)
            notes.append(f"{names} follow each other: they are joined as {one.name}, "
                         f"{one.frames} frames")  # fmt: skip
    return result, notes


def _follows(before: Source, after: Source) -> bool:
    """Whether a video goes on where another one, or its last chapter, ends."""
    alike = before.kind == after.kind and before.size == after.size and before.track == after.track
    if before.images or after.images or not alike:
        return False
    last = before.chapters[-1] if before.chapters else before.path
    parts = [chapter_of(path) for path in (last, after.path)]
    if parts[0] is not None and parts[1] is not None:
        consecutive = parts[0] == (parts[1][0], parts[1][1] - 1)
        return consecutive and last.parent == after.path.parent
    if before.fps is None or after.fps is None or abs(before.fps / after.fps - 1) > _AS_USUAL:
        return False
    seconds = before.frames / before.fps
    if before.created is None or after.created is None or seconds <= _SAME_INSTANT_S:
        return False
    begins_at_end = abs(before.created + seconds - after.created) <= _SAME_INSTANT_S
    return begins_at_end and is_next_file(last, after.path)
