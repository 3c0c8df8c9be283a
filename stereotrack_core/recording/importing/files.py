"""The files of a recording that is made: which stay, and how others are copied or written."""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import ImageArray
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.reading import open_file
from stereotrack_core.recording.images import WHITEST, DamagedFrame, brightness_of, read_image
from stereotrack_core.recording.importing import readers
from stereotrack_core.recording.importing.choices import Use, cameras_of, size_of
from stereotrack_core.recording.importing.sources import look_at
from stereotrack_core.recording.stream_files import is_image
from stereotrack_core.recording.writing import VideoWriter, remuxed, write_png

_CHUNK = 4 * 1024 * 1024  # bytes
_CONTAINERS = (".mp4", ".mov", ".mkv")
_DEPTH_MAPS = 8  # whose nearest and farthest counts are those of a source


@dataclass(frozen=True)
class StreamFiles:
    """A stream of the new recording: the files that it names, and how they come there."""

    use: Use
    camera: str
    part: str  # key of the stream in ``recording.toml``
    frames: str  # video or pattern, relative to the folder
    how: Literal["stay", "copy", "remux", "convert"]
    """``remux``: the packets of a track, or of all chapters, are copied into a new file."""
    half: int | None = None  # half of the images that it shows; None for the whole
    pictured: bool = False  # whether it is a picture of the depth map, for want of another image
    empty: bool = False  # whether it is the background of the stream rather than its frames


def files_of(uses: Sequence[Use], folder: Path) -> tuple[StreamFiles, ...]:
    """Streams of the sources in a folder, one or two each, and their backgrounds."""
    streams = [one for use in uses for one in _files_of(use, uses, folder)]
    empty = [_background(s, folder) for s in streams if s.use.background and s.part != "depth"]
    return (*streams, *empty)


def _background(one: StreamFiles, folder: Path) -> StreamFiles:
    """The background of a stream: where it lies, or written as what the stream becomes."""
    path = one.use.background
    assert path is not None  # noqa: S101 - it is asked for those that have one
    if one.half is not None or one.use.mirrored or one.use.source.bits > 8:
        return replace(one, frames=f"{one.camera}_empty.png", how="convert", empty=True)
    inside = _inside(path, folder)
    if inside and "%" not in inside:
        return replace(one, frames=inside, how="stay", empty=True)
    return replace(one, frames=f"{one.camera}_background{path.suffix}", how="copy", empty=True)


def _inside(path: Path, folder: Path) -> str:
    """The path from a folder that a file lies in; empty where it does not."""
    root, place = folder.resolve(), path.parent.resolve()
    if not (place.is_relative_to(root) and path.resolve().is_relative_to(root)):
        return ""
    return (place.relative_to(root) / path.name).as_posix()


def _files_of(use: Use, uses: Sequence[Use], folder: Path) -> Iterator[StreamFiles]:
    cameras = cameras_of(use)
    if use.role.startswith("side"):
        for half, camera in enumerate(cameras):
            part = camera.removeprefix(f"{use.view}_")
            name = _new_name(use, camera, size_of(use), folder)
            yield StreamFiles(use, camera, part, name, "convert", half)
        return
    camera = cameras[0]
    if use.role == "mask":
        yield _whole(use, "", "mask", f"{camera}_mask", folder)
        return
    if use.role != "depth":
        yield _whole(use, camera, "image" if use.role == "mono" else use.role, camera, folder)
        return
    yield _whole(use, camera, "depth", f"{camera}_depth", folder)
    if not any(other.role == "image" and other.view == use.view for other in uses):
        frames = f"{camera}_image/%06d.png"
        yield StreamFiles(use, camera, "image", frames, "convert", pictured=True)


def _whole(use: Use, camera: str, part: str, name: str, folder: Path) -> StreamFiles:
    source = use.source
    written = use.mirrored or source.rate is not None or (part != "depth" and source.bits > 8)
    inside = _inside(source.path, folder)
    in_parts = source.chapters or source.track or (source.tracks > 1 and not inside)
    if not written and in_parts and source.kind == "video":
        suffix = source.path.suffix.lower()
        suffix = suffix if suffix in _CONTAINERS else ".mkv"
        return StreamFiles(use, camera, part, _free_name(name, suffix, folder), "remux")
    if written or source.chapters or source.track or (source.images and not source.pattern):
        return StreamFiles(use, camera, part, _new_name(use, name, source.size, folder), "convert")
    if inside and "%" not in inside:
        frames = (PurePosixPath(inside).parent / (source.pattern or source.path.name)).as_posix()
        return StreamFiles(use, camera, part, frames, "stay")
    suffix = source.path.suffix
    frames = f"{name}/%06d{suffix}" if source.images else f"{name}{suffix}"
    return StreamFiles(use, camera, part, frames, "copy")


def _new_name(use: Use, name: str, size: tuple[int, int], folder: Path) -> str:
    """A free name of a video where one can be written, else of numbered images, for any size."""
    if use.source.kind == "video" and size[0] % 2 == 0 and size[1] % 2 == 0:
        return _free_name(name, ".mp4", folder)
    return f"{_free_name(name, '', folder)}/%06d.png"


def _free_name(name: str, suffix: str, folder: Path) -> str:
    taken = (folder / f"{name}{suffix}").exists()
    return f"{name}_converted{suffix}" if taken else f"{name}{suffix}"


def bring(one: StreamFiles, workplace: Path, fps: float) -> Generator[float, None, None]:
    """Bring a stream's files into the new folder, yielding the share; else InputError."""
    source, target = one.use.source, workplace / one.frames
    if one.how != "stay":
        target.parent.mkdir(exist_ok=True)
    if one.empty and one.use.background is not None:
        if one.how == "convert":
            write_png(target, _changed(one, empty_scene(one.use.background, source.white)))
        elif one.how == "copy":
            yield from _copied(one.use.background, target)
    elif one.how == "convert":
        yield from _converted(one, target, fps)
    elif one.how == "remux":
        try:
            yield from remuxed(source.chapters or (source.path,), source.track, target)
        except InputError:  # such as chapters that are encoded in different ways
            yield from _converted(one, target, fps)
    elif one.how == "copy" and source.images:
        for number, path in zip(source.numbers, source.images, strict=True):
            for _ in _copied(path, workplace / (one.frames % number)):
                pass
            yield (number + 1) / source.frames
    elif one.how == "copy":
        yield from _copied(source.path, target)


def _copied(path: Path, target: Path) -> Iterator[float]:
    size = path.stat().st_size
    with (
        open_file(path) as file,
        replacing(target, lambda written: written.stat().st_size == size) as temporary,
        temporary.open("wb") as out,
    ):
        while chunk := file.read(_CHUNK):
            out.write(chunk)
            yield min(out.tell() / max(size, 1), 1.0)


def _converted(one: StreamFiles, target: Path, fps: float) -> Iterator[float]:
    """Write a source's pictures again as what the stream needs; a damaged one ends the work."""
    source = one.use.source
    depth = one.pictured or one.part == "depth"
    reader = readers.open_source(source, "depth" if depth else "colour")
    try:
        count = reader.count()
        if target.suffix in _CONTAINERS:
            yield from _as_video(one, reader, target, fps, count)
            return
        there = range(count) if source.rate is not None else source.numbers or range(count)
        some = list(readers.pictures_spread(reader, _DEPTH_MAPS)) if one.pictured else []
        within = readers.depth_range(np.stack(some)) if some else (0.0, 1.0)
        for k in there:
            picture = _changed(one, _picture(reader, k, source.path))
            if one.pictured:
                picture = readers.shown_depth(picture, within)
            write_png(target.with_name(target.name % k), picture)
            yield (k + 1) / count
    finally:
        reader.close()


def _as_video(
    one: StreamFiles, reader: readers.Pictures, target: Path, fps: float, count: int
) -> Iterator[float]:
    width, height = size_of(one.use)
    first = _picture(reader, 0, one.use.source.path)
    with VideoWriter(target, fps=fps, width=width, height=height, colour=first.ndim == 3) as video:
        for k in range(count):
            video.write(_changed(one, _picture(reader, k, one.use.source.path)))
            yield (k + 1) / count


def _picture(reader: readers.Pictures, k: int, path: Path) -> NDArray[Any]:
    try:
        return reader.read(k, lambda _number, _picture: None)
    except DamagedFrame as problem:
        what = f"frame {k} cannot be decoded ({problem})"
        raise InputError(what, path, "Repair the file, or use another copy of it.") from None


def _changed(one: StreamFiles, picture: NDArray[Any]) -> NDArray[Any]:
    """The half that is wanted, not mirrored (H, W) or (H, W, 3)."""
    if one.half is not None:
        width = picture.shape[1] // 2
        picture = picture[:, one.half * width : (one.half + 1) * width]
    return np.ascontiguousarray(picture[:, ::-1] if one.use.mirrored else picture)


_FRAMES_OF_A_VIDEO = 15


def check_background(use: Use) -> None:
    """Refuse a background that cannot be read, or whose size is not that of the source."""
    path = use.background
    if path is None:
        return
    if not path.is_file():
        raise InputError("there is no such file", path, "Correct the path.")
    picture = _still(path) if is_image(path) else readers.first_picture(look_at([path]).sources[0])
    height, width = picture.shape[:2]
    if (width, height) != use.source.size:
        own = use.source.size
        sizes = f"{width} x {height} pixels, its images have {own[0]} x {own[1]}"
        remedy = "Use a picture of the empty scene by the same camera, or none."
        raise InputError(f"the background of {use.source.name} has {sizes}", path, remedy)


def empty_scene(path: Path, white: int = 0) -> ImageArray:
    """The picture (H, W) or (H, W, 3) of a file; of a video, the median of frames of all of it.

    `white`: value that becomes white where more than 8 bits are stored; 0 is the largest possible.
    """
    if is_image(path):
        return _still(path, white)
    video = replace(look_at([path]).sources[0], white=white)
    with closing(readers.open_source(video, "colour")) as reader:
        pictures = list(readers.pictures_spread(reader, _FRAMES_OF_A_VIDEO))
    if not pictures:
        raise _unreadable(path, DamagedFrame("none of its frames can be decoded"))
    return np.asarray(np.median(pictures, axis=0).round(), dtype=np.uint8)


def _still(path: Path, white: int = 0) -> ImageArray:
    try:
        picture = read_image(path, "stored")
    except DamagedFrame as problem:
        raise _unreadable(path, problem) from None
    return brightness_of(picture, white or WHITEST) if picture.dtype == np.uint16 else picture


def _unreadable(path: Path, problem: DamagedFrame) -> InputError:
    return InputError(str(problem), path, "Use another picture, or none.")
