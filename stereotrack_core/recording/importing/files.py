"""The files of a recording that is made: which stay, and how others are copied or written."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.reading import open_file
from stereotrack_core.recording.images import DamagedFrame
from stereotrack_core.recording.importing.choices import Use, cameras_of, size_of
from stereotrack_core.recording.importing.sources import depth_range, open_source, shown_depth
from stereotrack_core.recording.stream_files import StreamSource
from stereotrack_core.recording.writing import VideoWriter, write_png

_CHUNK = 4 * 1024 * 1024  # bytes


@dataclass(frozen=True)
class StreamFiles:
    """A stream of the new recording: the files that it names, and how they come there."""

    use: Use
    camera: str
    part: str
    """Key of the stream in ``recording.toml``."""
    frames: str
    """Video or pattern, relative to the folder."""
    how: Literal["stay", "copy", "convert"]
    half: int | None = None
    """Which half of the images it is; None for the whole."""
    pictured: bool = False
    """Whether it is a picture of the depth map, for a depth camera without another image."""


def files_of(uses: Sequence[Use], folder: Path) -> tuple[StreamFiles, ...]:
    """What the sources become in a folder: one stream each, or two."""
    return tuple(one for use in uses for one in _files_of(use, uses, folder))


def _files_of(use: Use, uses: Sequence[Use], folder: Path) -> Iterator[StreamFiles]:
    cameras = cameras_of(use)
    if use.role.startswith("side"):
        for half, camera in enumerate(cameras):
            part = camera.removeprefix(f"{use.view}_")
            yield StreamFiles(
                use, camera, part, _new_name(use, camera, *size_of(use)), "convert", half
            )
        return
    camera = cameras[0]
    if use.role != "depth":
        yield _whole(use, camera, "image" if use.role == "mono" else use.role, camera, folder)
        return
    yield _whole(use, camera, "depth", f"{camera}_depth", folder)
    if not any(other.role == "image" and other.view == use.view for other in uses):
        frames = f"{camera}_image/%06d.png"
        yield StreamFiles(use, camera, "image", frames, "convert", pictured=True)


def _whole(use: Use, camera: str, part: str, name: str, folder: Path) -> StreamFiles:
    source = use.source
    if use.mirrored or (source.images and not source.pattern):
        return StreamFiles(use, camera, part, _new_name(use, name, *source.size), "convert")
    root, place = folder.resolve(), source.path.parent.resolve()
    inside = place.is_relative_to(root) and source.path.resolve().is_relative_to(root)
    own_name = source.pattern or source.path.name
    nameable = "%" not in str(place) and (source.images or "%" not in own_name)
    if inside and nameable:
        frames = (place.relative_to(root) / own_name).as_posix()
        return StreamFiles(use, camera, part, frames, "stay")
    suffix = source.path.suffix
    frames = f"{name}/%06d{suffix}" if source.images else f"{name}{suffix}"
    return StreamFiles(use, camera, part, frames, "copy")


def _new_name(use: Use, name: str, width: int, height: int) -> str:
    """A video where one can be written, else numbered images, which hold any size and depth."""
    as_video = use.source.kind == "video" and width % 2 == 0 and height % 2 == 0
    return f"{name}.mp4" if as_video else f"{name}/%06d.png"


def bring(one: StreamFiles, workplace: Path, fps: float) -> Generator[float, None, None]:
    """Bring the files of a stream into the new folder; yields the share that is done.

    Raises InputError where a source cannot be read, or the drive is full.
    """
    source, target = one.use.source, workplace / one.frames
    if one.how != "stay":
        target.parent.mkdir(exist_ok=True)
    if one.how == "convert":
        yield from _converted(one, target, fps)
    elif one.how == "copy" and source.images:
        for number, path in enumerate(source.images):
            for _ in _copied(path, workplace / (one.frames % number)):
                pass
            yield (number + 1) / len(source.images)
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
    """Write the pictures of a source again: one half of them, turned back, or depth as a picture.

    They are decoded one after the other; a damaged one ends the work, so that no frame is lost
    without a word.
    """
    source = one.use.source
    depth = source.kind == "depth"
    reader = open_source(source, "depth" if depth else "colour")
    try:
        count, within = reader.count(), (0.0, 1.0)
        if source.kind == "video" and target.suffix == ".mp4":
            yield from _as_video(one, reader, target, fps, count)
            return
        for k in range(count):
            picture = _changed(one, _picture(reader, k, source.path))
            if one.pictured:
                within = within if k else depth_range(picture)
                picture = shown_depth(picture, within)
            write_png(target.with_name(target.name % k), picture)
            yield (k + 1) / count
    finally:
        reader.close()


def _as_video(
    one: StreamFiles, reader: StreamSource, target: Path, fps: float, count: int
) -> Iterator[float]:
    width, height = size_of(one.use)
    first = _picture(reader, 0, one.use.source.path)
    with VideoWriter(target, fps=fps, width=width, height=height, colour=first.ndim == 3) as video:
        for k in range(count):
            video.write(_changed(one, _picture(reader, k, one.use.source.path)))
            yield (k + 1) / count


def _picture(reader: StreamSource, k: int, path: Path) -> NDArray[Any]:
    try:
        return reader.read(k, lambda _number, _picture: None)
    except DamagedFrame as problem:
        raise InputError(
            f"frame {k} cannot be decoded ({problem})",
            where=str(path),
            remedy="Repair the file, or use another copy of it.",
        ) from None


def _changed(one: StreamFiles, picture: NDArray[Any]) -> NDArray[Any]:
    """The half that is wanted, not mirrored (H, W) or (H, W, 3)."""
    if one.half is not None:
        width = picture.shape[1] // 2
        picture = picture[:, one.half * width : (one.half + 1) * width]
    return np.ascontiguousarray(picture[:, ::-1] if one.use.mirrored else picture)
