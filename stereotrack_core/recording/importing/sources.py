"""Look at videos and images that are no recording yet: what each of them is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
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
from stereotrack_core.recording.importing.chapters import (
    begins_at_end,
    chapter_of,
    is_next_file,
)
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
from stereotrack_core.recording.video import (
    FrameTimes,
    has_clock,
    open_container,
    video_stream,
    video_tracks,
)

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
    """The video, its first chapter, or the first image."""
    kind: SourceKind
    width: int
    height: int
    """Size in pixels, as stored."""
    frames: int
    """Number of frames; for a video as far as its header states it."""
    fps: float | None = None
    """Frames per second; None where the files do not state it."""
    clock: bool = True
    """Whether a video states the times of its frames; a raw stream does not."""
    chapters: tuple[Path, ...] = ()
    """The files of a video that the camera split, in their order; none of other videos."""
    track: int = 0
    """Which video track of the file it is."""
    tracks: int = 1
    """Number of video tracks in the file."""
    bits: int = 8
    """Bits of a stored value: 16 of depth maps and of pictures with more than 8 bits."""
    white: int = 0
    """Stored value that becomes white in a picture of 8 bits; 0 until it is measured."""
    saturated: float = 0.0
    """Share of the pixels of the measured pictures that are as bright as white, or brighter."""
    created: float | None = None
    """Time in seconds since 1970 that a video states, even of whole seconds."""
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
        chapters = f" in {len(self.chapters)} chapters" if self.chapters else ""
        return f"{self.width} x {self.height}, {self.frames} frames{rate}{chapters}"


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
            sources += [_images(group)] if is_image(group[0]) else _tracks(group[0])
        except InputError as problem:
            problems.append(problem)
    sources, about_chapters = joined(sources)
    notes += about_chapters
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
    kind, size, unit, bits = _what_is(first)
    check_sizes(files, size)
    numbering = numbering_of(files)
    return Source(
        name=stem_of(first) or first.parent.name,
        path=first, kind=kind, width=size[0], height=size[1], frames=numbering.numbers[-1] + 1,
        images=files, pattern="" if unit else numbering.pattern, numbers=numbering.numbers,
        lowest=None if numbering.times else numbering.lowest, unit=unit, bits=bits,
        **_timing(numbering),
    )  # fmt: skip


def _what_is(image: Path) -> tuple[SourceKind, tuple[int, int], float | None, int]:
    """Whether an image is a depth map, its size, the unit of floating metres, and its bits."""
    try:
        picture = read_image(image, "stored")
        height, width = picture.shape[:2]
        bits = 8 * picture.dtype.itemsize
        kind: SourceKind = "depth" if bits > 8 and picture.ndim == 2 else "images"
        return kind, (width, height), None, bits
    except DamagedFrame as problem:
        complaint = str(problem)
    try:
        height, width = read_metres(image).shape
    except DamagedFrame:
        raise InputError(complaint, where=str(image), remedy=AGAIN) from None
    return "depth", (width, height), METRIC_UNIT, 16


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
        focal=topic.focal, bits=topic.bits,
    )  # fmt: skip


def _tracks(path: Path) -> list[Source]:
    """The video tracks of a file; each has a name of its own if there are several."""
    check_file(path)
    try:
        with open_container(path) as container:
            titles = [_title_of(one) for one in video_tracks(container)]
        sources = [_video(path, track) for track in range(len(titles))]
    except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
        raise no_video(path, error) from None
    if not sources:
        raise no_video(path, IndexError())
    if len(sources) == 1:
        return sources
    return [
        replace(one, name=f"{path.stem}_{title or _usual_title(one)}", tracks=len(titles))
        for one, title in zip(sources, titles, strict=True)
    ]


def _title_of(stream: Any) -> str:
    title = stream.metadata.get("title") or stream.metadata.get("handler_name") or ""
    return "" if title.lower().endswith("handler") else title.strip().lower().replace(" ", "_")


def _usual_title(source: Source) -> str:
    return "depth" if source.kind == "depth" else f"track{source.track + 1}"


def _video(path: Path, track: int) -> Source:
    with open_container(path) as container:
        stream = video_stream(container, track)
        context, clock = stream.codec_context, has_clock(container)
        rate = stream.average_rate or stream.guessed_rate
        frame = next(container.decode(stream))
        depth = frame.format.name.startswith("gray16")
        turned = -round(float(getattr(frame, "rotation", 0) or 0) / 90.0) * 90 % 360
        seconds = None if container.duration is None else container.duration / av.time_base
        fps = float(rate) if rate and clock else None
        frames = stream.frames or round((seconds or 0.0) * (fps or 0.0))
        created, sound = _created(container, stream), bool(container.streams.audio)
        fps, uneven, pause = _steadiness(path, stream, track, fps, clock=clock)
    return Source(
        name=path.stem, path=path, kind="depth" if depth else "video",
        width=int(context.width), height=int(context.height),
        frames=int(frames) or _counted(path, track), fps=fps, clock=clock, track=track,
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


def _counted(path: Path, track: int) -> int:
    """Number of frames of a video whose header does not tell it."""
    index = FrameTimes(path, track)
    try:
        return index.count()
    finally:
        index.close()


def joined(sources: Sequence[Source]) -> tuple[list[Source], list[str]]:
    """The sources with consecutive chapters of a video as one, and notes about chapters."""
    result: list[Source] = []
    notes = []
    for one in sources:
        place = next((k for k, other in enumerate(result) if _follows(other, one)), None)
        if place is not None:
            result[place] = _continued(result[place], one)
            continue
        result.append(one)
        named = chapter_of(one.path)
        if named is not None and named[1] > 1:
            notes.append(
                f"{one.path.name} is chapter {named[1]} of a video whose chapter before is not "
                "there, or does not fit: it is a source of its own"
            )
    for one in result:
        if one.chapters:
            names = ", ".join(path.name for path in one.chapters)
            notes.append(f"{names} follow each other: they are joined as {one.name}, "
                         f"{one.frames} frames")  # fmt: skip
    return result, notes


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


def _follows(before: Source, after: Source) -> bool:
    """Whether a video goes on where another one, or its last chapter, ends."""
    alike = before.kind == after.kind and before.size == after.size and before.track == after.track
    if before.images or after.images or not alike or before.topic or after.topic:
        return False
    last = before.chapters[-1] if before.chapters else before.path
    parts = [chapter_of(path) for path in (last, after.path)]
    if parts[0] is not None and parts[1] is not None:
        consecutive = parts[0] == (parts[1][0], parts[1][1] - 1)
        return consecutive and last.parent == after.path.parent
    if before.fps is None or after.fps is None or abs(before.fps / after.fps - 1) > _AS_USUAL:
        return False
    length = before.frames / before.fps
    return is_next_file(last, after.path) and begins_at_end(before.created, length, after.created)


def _continued(first: Source, following: Source) -> Source:
    return replace(
        first, chapters=(*(first.chapters or (first.path,)), following.path),
        frames=first.frames + following.frames, sound=first.sound and following.sound,
        uneven=max(first.uneven, following.uneven), pause=max(first.pause, following.pause),
    )  # fmt: skip


def _created(container: Any, stream: Any) -> float | None:
    """When a video was taken, in seconds since 1970: with fractions where one is stated."""
    found = []
    for metadata in (stream.metadata, container.metadata):
        text = metadata.get("com.apple.quicktime.creationdate") or metadata.get("creation_time")
        with suppress(ValueError):
            found.append(datetime.fromisoformat(text or "").timestamp())
    found = [created for created in found if created > 0]
    return next((created for created in found if created % 1.0), next(iter(found), None))


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
