"""Look at videos and images that are no recording yet: what each of them is."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import groupby
from pathlib import Path
from typing import Any, Literal, TypeAlias

import av
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import check_file, readable, reason
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.images import (
    DamagedFrame,
    NumberedImages,
    PictureKind,
    numbered_files,
    picture_of,
    read_image,
)
from stereotrack_core.recording.stream_files import IMAGE_SUFFIXES, StreamSource
from stereotrack_core.recording.video import VideoStream, open_container, video_stream

SourceKind: TypeAlias = Literal["video", "images", "depth"]

VIDEO_SUFFIXES = frozenset(
    {*(".mp4", ".mov", ".avi", ".mkv", ".m4v", ".webm", ".mts", ".m2ts", ".ts", ".mpg"),
     *(".mpeg", ".wmv", ".3gp", ".h264", ".h265")}
)  # fmt: skip

_FEWEST_IMAGES = 2
"""A single image beside videos is a background or a photo of the room, not a stream."""

_LAST_NUMBER = re.compile(r"(\d+)(?=\D*$)")
_MOST_SOURCES = 100
_NEAR_GREY, _FAR_GREY = 255.0, 40.0


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
    for group in _groups(paths):
        if len(sources) >= _MOST_SOURCES:
            break
        try:
            found = _images(group) if _is_image(group[0]) else _video(group[0])
        except InputError as problem:
            problems.append(problem)
            continue
        sources.append(found)
    if not sources:
        if problems:
            raise problems[0]
        raise InputError(
            "no videos and no numbered images were found",
            where=", ".join(str(path) for path in paths),
            remedy="Name video files, or a folder with videos or with folders of images.",
        )
    return Found(_named(sources), tuple(problems), _common_folder(paths))


def is_media(path: Path) -> bool:
    """Whether a file looks like a video or an image."""
    return path.suffix.lower() in VIDEO_SUFFIXES | IMAGE_SUFFIXES


def is_unmade(path: Path) -> bool:
    """Whether a path holds videos or images of which a recording could be made."""
    if path.is_dir():
        return not (path / DESCRIPTION).exists() and holds_media(path)
    return path.is_file() and is_media(path)


def holds_media(folder: Path) -> bool:
    """Whether a folder, or one of its folders, holds videos or several images by their names."""
    return next(_groups([folder]), None) is not None


def open_source(source: Source, kind: PictureKind) -> StreamSource:
    """Open a source to read its frames by number.

    Raises InputError where it cannot be opened.
    """
    if source.images:
        return NumberedImages(dict(enumerate(source.images)), "%d", kind)
    try:
        return VideoStream(source.path, kind)
    except (av.FFmpegError, OSError, IndexError) as error:
        raise _no_video(source.path, error) from None


def first_picture(source: Source) -> ImageArray:
    """The first picture (H, W) or (H, W, 3) BGR uint8, to be shown; depth as brightness.

    Raises InputError where it cannot be decoded.
    """
    kind: PictureKind = "depth" if source.kind == "depth" else "colour"
    try:
        if source.images:
            picture = read_image(source.path, kind)
        else:
            with open_container(source.path) as container:
                picture = picture_of(next(container.decode(video_stream(container))), kind)
    except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
        raise _no_video(source.path, error) from None
    except DamagedFrame as problem:
        raise InputError(str(problem), where=str(source.path), remedy=_AGAIN) from None
    if source.kind != "depth":
        return picture
    return shown_depth(picture, depth_range(picture))


def depth_range(counts: NDArray[Any]) -> tuple[float, float]:
    """Nearest and farthest counts of a depth map (H, W), but for single ones; 0 is no value."""
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


# ---- which files belong together


def _groups(paths: Iterable[Path]) -> Iterator[tuple[Path, ...]]:
    """Videos alone, and images of the same folder whose names differ in their last number."""
    given = [path for path in paths if path.is_file()]
    yield from _of_files(given)
    for folder in (path for path in paths if path.is_dir()):
        yield from _of_files(_entries(folder))
        for inner in _entries(folder):
            if inner.is_dir() and not inner.name.startswith("."):
                yield from _of_files(_entries(inner))


def _of_files(files: Iterable[Path]) -> Iterator[tuple[Path, ...]]:
    files = [one for one in files if not one.name.startswith(".") and one.is_file()]
    for path in sorted(one for one in files if one.suffix.lower() in VIDEO_SUFFIXES):
        yield (path,)
    images = sorted((one for one in files if _is_image(one)), key=_place)
    for _, several in groupby(images, _place):
        group = tuple(sorted(several, key=_number))
        if len(group) >= _FEWEST_IMAGES:
            yield group


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        raise InputError(
            f"the folder cannot be read ({reason(error)})",
            where=str(folder),
            remedy="Check its permissions.",
        ) from None


def _is_image(path: Path) -> bool:
    return path.suffix.lower() in IMAGE_SUFFIXES


def _place(path: Path) -> tuple[str, str, str]:
    """Folder and name without the last number: the same for all images of a stream."""
    before, _, after = _LAST_NUMBER.sub("\0", path.stem).partition("\0")
    return str(path.parent), before, after + path.suffix


def _number(path: Path) -> int:
    found = _LAST_NUMBER.search(path.stem)
    return int(found.group()) if found else -1


# ---- one source


_AGAIN = "Use another copy of the file."


def _images(files: tuple[Path, ...]) -> Source:
    first = files[0]
    try:
        picture = read_image(first, "depth")
        kind: SourceKind = "depth" if picture.dtype == np.uint16 else "images"
    except DamagedFrame:
        kind = "images"  # of several channels
    try:
        height, width = read_image(first, "colour").shape[:2]
    except DamagedFrame as problem:
        raise InputError(str(problem), where=str(first), remedy=_AGAIN) from None
    pattern = _pattern_of(files)
    return Source(
        name=_place(first)[1].strip("_-. ") or first.parent.name,
        path=first, kind=kind, width=width, height=height, frames=len(files),
        images=files, pattern=pattern,
    )  # fmt: skip


def _pattern_of(files: tuple[Path, ...]) -> str:
    """The printf pattern of exactly these files without a gap; empty where there is none."""
    first = files[0]
    digits = _LAST_NUMBER.search(first.stem)
    if digits is None or _number(files[-1]) - _number(first) != len(files) - 1:
        return ""
    width = len(digits.group())
    for form in ("%d",) if width == 1 else (f"%0{width}d", "%d"):
        pattern = f"{first.stem[: digits.start()]}{form}{first.stem[digits.end() :]}{first.suffix}"
        try:
            if set(numbered_files(first.parent, pattern).values()) == set(files):
                return pattern
        except (ValueError, OSError):
            continue
    return ""


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
            return Source(
                name=path.stem, path=path, kind="depth" if depth else "video",
                width=int(context.width), height=int(context.height), frames=int(counted),
                fps=fps, start=_start(container, stream),
                sound=bool(container.streams.audio), turned=turned,
            )  # fmt: skip
    except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
        raise _no_video(path, error) from None


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


def _no_video(path: Path, error: Exception) -> InputError:
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
