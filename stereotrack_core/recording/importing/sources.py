"""Look at videos and images that are no recording yet: what each of them is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

import av
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.limited_process import read_apart
from stereotrack_core.reading import check_file, readable, reason
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.images import DamagedFrame, Keep, read_image, read_metres
from stereotrack_core.recording.importing.image_groups import (
    Numbering,
    check_sizes,
    groups_of,
    is_image,
    is_video,
    numbering_of,
    single_images,
    stem_of,
)
from stereotrack_core.recording.importing.ros.bag import (
    Topic,
    bags_in,
    is_bag_file,
    read_topics,
)
from stereotrack_core.recording.importing.ros.images import METRIC_UNIT
from stereotrack_core.recording.video import open_container, video_stream

SourceKind: TypeAlias = Literal["video", "images", "depth"]

_MOST_SOURCES = 100
_MOST_PACKETS = 5000  # of a video without an index, to see whether its frame rate is constant
_USUAL_RATES = (5, 6, 10, 12, 12.5, 15, 20, 24, 25, 29.97, 30, 48, 50, 59.94, 60, 90, 100, 120)
_AS_USUAL = 0.01  # of a rate
MOST_UNEVEN = 0.75
"""Frames by which a stream may be uneven without being resampled."""


class Pictures(Protocol):
    """Pictures of a source by number; used by one thread at a time."""

    def count(self) -> int:
        """Number of frames."""

    def read(self, k: int, keep: Keep) -> NDArray[Any]:
        """Picture of frame k; DamagedFrame where there is none."""

    def close(self) -> None:
        """Close what is open."""


@dataclass(frozen=True)
class Source:
    """One video, or the numbered images of one folder."""

    name: str
    """What it is called here; unique among all that were found."""
    path: Path
    """The video, or the first image."""
    kind: SourceKind
    width: int
    height: int
    """Size in pixels, as stored."""
    frames: int
    """Number of frames; for a video as far as its header states it."""
    fps: float | None = None
    """Frames per second; None where the files do not state it."""
    start: float | None = None
    """Time of the first frame in seconds since 1970, where the file states it."""
    sound: bool = False
    turned: int = 0
    """Degrees clockwise to look upright: 0, 90, 180 or 270."""
    images: tuple[Path, ...] = ()
    """Image files in their order; none for a video."""
    pattern: str = ""
    """printf pattern that the images' names fit; empty where the format cannot express them."""
    numbers: tuple[int, ...] = ()
    """Frame of each image, from 0; a number that is left out has no image."""
    lowest: int | None = None
    """The number in the first image's name, where numbers count frames."""
    times: tuple[float, ...] = ()
    """Seconds since 1970 of each frame, where names or messages state them."""
    uneven: float = 0.0
    """Largest distance of a frame from its place at a constant rate, in frames."""
    pause: float = 0.0
    """Longest time between two frames in seconds; 0 where it is not known."""
    unit: float | None = None
    """Metres per count, where the depth maps state it."""
    topic: str = ""
    """Topic of the images in a ROS bag."""
    places: tuple[int, ...] = ()
    """Where each frame lies in a ROS bag, in nanoseconds."""
    camera: Camera | None = None
    """The camera as a ROS bag states it."""
    focal: float | None = None
    """Focal length in pixels, where a ROS bag states it."""
    rate: float | None = None
    """Frames per second at which frames are picked by their times; None: all are taken."""
    begin: float = 0.0
    """Seconds after the first frame at which picking begins."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.width, self.height

    def says(self) -> str:
        """Size, length and rate in words."""
        rate = "" if self.fps is None else f", {self.fps:.4g} fps"
        return f"{self.width} x {self.height}, {self.frames} frames{rate}"


@dataclass(frozen=True)
class Found:
    """What was found in folders and files that somebody named."""

    sources: tuple[Source, ...]
    problems: tuple[InputError, ...] = ()
    """What could not be read."""
    backgrounds: tuple[Path, ...] = ()
    """Single images beside the streams, some of which may show the empty scene."""
    notes: tuple[str, ...] = ()
    """What has to be known about them, in clauses."""
    folder: Path | None = None
    """The folder that was named, where it was one alone, else the one that all files lie in."""

    @property
    def fps(self) -> float | None:
        """Frames per second that most of the sources state."""
        rates = [round(one.fps, 3) for one in self.sources if one.fps is not None]
        return max(sorted(rates), key=rates.count) if rates else None


def look_at(paths: Sequence[Path]) -> Found:
    """Describe the videos and images in folders and files; nothing is written.

    Raises InputError where nothing is named, a path does not exist, or nothing usable is found.
    """
    paths = [Path(path) for path in paths]
    for path in paths:
        if not path.exists():
            raise InputError("there is no such file or folder", where=str(path),
                             remedy="Correct the path.")  # fmt: skip
    sources: list[Source] = []
    problems: list[InputError] = []
    notes: list[str] = []
    bags = bags_in(paths)
    for bag in bags:
        found = read_apart(read_topics, bag, AGAIN)  # its parts may unfold to any size
        sources += [_of_topic(topic, bag) for topic in found.topics]
        notes += found.notes
    others = [path for path in paths if path not in bags]
    for group in groups_of(others):
        if len(sources) >= _MOST_SOURCES:
            break
        try:
            sources.append(_images(group) if is_image(group[0]) else _video(group[0]))
        except InputError as problem:
            problems.append(problem)
    if not sources:
        if problems:
            raise problems[0]
        single = len(list(single_images(others)))
        raise InputError(
            f"no videos and no numbered images were found, but {counted(single, 'single image')}"
            if single
            else "no videos and no numbered images were found",
            where=", ".join(str(path) for path in paths),
            remedy="Number images in their order, such as 0001.png."
            if single > 1
            else "Name video files, a ROS bag, or a folder with videos or folders of images.",
        )
    backgrounds = tuple(single_images(others))
    folder = None if bags else _common_folder(paths)  # a bag has no folder of its own
    return Found(_named(sources), tuple(problems), backgrounds, tuple(notes), folder)


def is_media(path: Path) -> bool:
    """Whether a file looks like a video, an image or a ROS bag."""
    return is_video(path) or is_image(path) or is_bag_file(path)


def is_unmade(path: Path) -> bool:
    """Whether a path holds videos or images of which a recording could be made."""
    if path.is_dir():
        return not (path / DESCRIPTION).exists() and (holds_media(path) or bool(bags_in([path])))
    return path.is_file() and is_media(path)


def holds_media(folder: Path) -> bool:
    """Whether a folder, or one of its folders, holds videos or several images by their names."""
    return next(groups_of([folder]), None) is not None


# ---- one source


AGAIN = "Use another copy of the file."


def _images(files: tuple[Path, ...]) -> Source:
    first = files[0]
    kind, size, unit = _what_is(first)
    check_sizes(files, size)
    numbering = numbering_of(files)
    return Source(
        name=stem_of(first) or first.parent.name,
        path=first, kind=kind, width=size[0], height=size[1], frames=numbering.numbers[-1] + 1,
        images=files, pattern="" if unit else numbering.pattern, numbers=numbering.numbers,
        lowest=None if numbering.times else numbering.lowest, unit=unit,
        **_timing(numbering),
    )  # fmt: skip


def _what_is(image: Path) -> tuple[SourceKind, tuple[int, int], float | None]:
    """Whether an image is a depth map, its width and height, and the unit of floating metres."""
    kind: SourceKind = "images"
    try:
        if read_image(image, "depth").dtype == np.uint16:
            kind = "depth"
    except DamagedFrame:
        pass  # of several channels
    try:
        height, width = read_image(image, "colour").shape[:2]
        return kind, (width, height), None
    except DamagedFrame as problem:
        complaint = str(problem)
    try:
        height, width = read_metres(image).shape
    except DamagedFrame:
        raise InputError(complaint, where=str(image), remedy=AGAIN) from None
    return "depth", (width, height), METRIC_UNIT


def _timing(numbering: Numbering) -> dict[str, Any]:
    if not numbering.times:
        return {}
    rate, uneven, pause = rate_of(np.array(numbering.times))
    start = numbering.times[0]
    return {
        "times": numbering.times, "start": start, "fps": rate, "uneven": uneven, "pause": pause,
    }  # fmt: skip


def rate_of(times: FloatArray) -> tuple[float, float, float]:
    """Frames per second of time stamps (N,), how far from even they are, and the longest pause.

    The rate is that of the usual step, as a usual rate where it is near to one; the distance is in
    frames, the pause in seconds.
    """
    steps = np.diff(times)
    usual = float(np.median(steps))
    rate = 1.0 / usual if usual > 0 else 1.0
    nearest = min(_USUAL_RATES, key=lambda one: abs(rate / one - 1.0))
    rate = float(nearest) if abs(rate / nearest - 1.0) < _AS_USUAL else rate
    return rate, unevenness(times, rate), float(steps.max())


def unevenness(times: FloatArray, rate: float) -> float:
    """Largest distance of times (N,) in seconds from places at a rate, in frames."""
    return float(np.abs((times - times[0]) * rate - np.arange(len(times))).max())


def _of_topic(topic: Topic, bag: Path) -> Source:
    rate, uneven, pause = rate_of(np.array(topic.times))
    return Source(
        name=topic.short, path=bag, kind="depth" if topic.depth else "images",
        width=topic.width, height=topic.height, frames=len(topic.times), fps=rate,
        start=topic.times[0], times=topic.times, uneven=uneven, pause=pause, unit=topic.unit,
        topic=topic.name, places=topic.places, camera=topic.camera,
        focal=topic.focal,
    )  # fmt: skip


def _video(path: Path) -> Source:
    check_file(path)
    try:
        with open_container(path) as container:
            stream = video_stream(container)
            context, rate = stream.codec_context, stream.average_rate
            frame = next(container.decode(stream))
            depth = frame.format.name.startswith("gray16")
            turned = -round(float(getattr(frame, "rotation", 0) or 0) / 90.0) * 90 % 360
            seconds = None if container.duration is None else container.duration / av.time_base
            fps = None if not rate else float(rate)
            counted = stream.frames or round((seconds or 0.0) * (fps or 0.0))
            start, sound = _start(container, stream), bool(container.streams.audio)
            fps, uneven, pause = _steadiness(path, stream, fps)
            return Source(
                name=path.stem, path=path, kind="depth" if depth else "video",
                width=int(context.width), height=int(context.height), frames=int(counted),
                fps=fps, start=start, sound=sound, turned=turned, uneven=uneven, pause=pause,
            )  # fmt: skip
    except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
        raise no_video(path, error) from None


def _steadiness(path: Path, stream: Any, fps: float | None) -> tuple[float | None, float, float]:
    """Frames per second, how far from even they are in frames, and the longest pause in seconds.

    By the container's index, else by its first packets. The rate of an uneven video is that of its
    usual step, not the average that the container states.
    """
    stamps = [e.timestamp for e in getattr(stream, "index_entries", ()) if not e.is_discard]
    if not 2 < stream.frames == len(stamps):
        with open_container(path) as container:
            packets = container.demux(video_stream(container))
            some = (packet for packet, _ in zip(packets, range(_MOST_PACKETS), strict=False))
            stamps = [one.pts for one in some if one.pts is not None and not one.is_discard]
    times = np.sort(np.array(stamps, dtype=np.float64)) * float(stream.time_base or 0)
    if fps is None or len(times) < 3 or times[-1] <= times[0]:
        return fps, 0.0, 0.0
    uneven = unevenness(times, fps)
    if uneven > MOST_UNEVEN:
        return rate_of(times)
    return fps, uneven, float(np.diff(times).max())


def _start(container: Any, stream: Any) -> float | None:
    """When the first frame was taken; None where only whole seconds are stated, or nothing."""
    for metadata in (stream.metadata, container.metadata):
        text = metadata.get("com.apple.quicktime.creationdate") or metadata.get("creation_time")
        if not text:
            continue
        try:
            start = datetime.fromisoformat(text).timestamp()
        except ValueError:
            continue
        if start > 0 and start % 1.0:
            return start
    return None


def no_video(path: Path, error: Exception) -> InputError:
    """What to say about a file that is no video."""
    empty = isinstance(error, IndexError | StopIteration)
    return InputError(
        f"it cannot be opened as a video ({'it contains no image' if empty else reason(error)})",
        where=str(path),
        remedy=readable(error, "Convert it to a common format such as MP4."),
    )


def _named(sources: Sequence[Source]) -> tuple[Source, ...]:
    """The sources in their order, with names that tell them apart and that files can have."""
    taken: set[str] = set()
    named = []
    for one in sources:
        plain = re.sub(r"[^\w.-]+", "_", one.name).strip("._-") or "camera"
        shared = sum(other.name == one.name for other in sources) > 1
        stem = f"{one.path.parent.name}_{plain}" if shared and one.path.parent.name else plain
        stem = re.sub(r"[^\w.-]+", "_", stem)
        name, number = stem, 2
        while name.casefold() in taken:
            name, number = f"{stem}_{number}", number + 1
        taken.add(name.casefold())
        named.append(replace(one, name=name))
    return tuple(named)


def _common_folder(paths: Sequence[Path]) -> Path | None:
    if len(paths) == 1 and paths[0].is_dir():
        return paths[0]
    parents = {path.resolve().parent for path in paths}
    return parents.pop() if len(parents) == 1 and all(path.is_file() for path in paths) else None
