"""The pictures that are searched for the board, and what was seen of it in them."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.detection import Recognition, recognised
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.recording.folder import DESCRIPTION, open_recording
from stereotrack_core.recording.images import DamagedFrame, NumberedImages, spread
from stereotrack_core.recording.importing.readers import Pictures as StreamPictures
from stereotrack_core.recording.importing.readers import chapters_of
from stereotrack_core.recording.importing.video_sources import chapters_from
from stereotrack_core.recording.stream_files import IMAGE_SUFFIXES, VIDEO_SUFFIXES, open_stream
from stereotrack_core.work import NO_WORK, Work


@dataclass(frozen=True)
class LeftOut:
    """A picture that is not used; `reason` is a clause."""

    camera: str
    frame: int
    picture: str  # name of the file, or the number of the video's frame
    reason: str


@dataclass(frozen=True, eq=False)
class Sightings:
    """The board in the pictures (F,) of a camera: raw pixels (F, n, 2), NaN where unseen."""

    camera: str
    size: tuple[int, int]  # width and height in pixels
    frames: IntArray
    pixels: FloatArray
    pictures: tuple[str, ...]
    left_out: tuple[LeftOut, ...] = ()
    searched: int = 0  # number of pictures in which the board was looked for

    def __len__(self) -> int:
        return len(self.frames)

    def only(self, rows: IntArray) -> Sightings:
        """Those in some rows."""
        names = tuple(self.pictures[i] for i in rows)
        return replace(self, frames=self.frames[rows], pixels=self.pixels[rows], pictures=names)

    def without(self, rows: Iterable[int], reasons: Iterable[str]) -> Sightings:
        """All but some rows, which are left out for reasons."""
        why = dict(zip(rows, reasons, strict=True))
        own = ((int(self.frames[i]), self.pictures[i], reason) for i, reason in why.items())
        gone = tuple(LeftOut(self.camera, *one) for one in own)
        kept = np.array([i for i in range(len(self)) if i not in why], dtype=np.int64)
        return replace(self.only(kept), left_out=self.left_out + gone)

    def without_frames(self, frames: Iterable[int]) -> Sightings:
        """All but some frames, as a person has chosen."""
        rows = np.flatnonzero(np.isin(self.frames, list(frames)))
        return self.without(rows.tolist(), ["left out by hand"] * len(rows))


NO_PICTURES = ("depth", "mask")  # streams of a view
_SAMPLE = 8  # pictures by which the board is recognised
_DIGITS = re.compile(r"(\d+)")


@dataclass(frozen=True, eq=False)
class Pictures:
    """Grey pictures of one camera by number; frame k of all cameras is the same instant."""

    camera: str
    source: StreamPictures
    first: int = 0
    files: tuple[str, ...] = ()

    def count(self) -> int:
        """Number of pictures; waits until the end of a video has been reached."""
        return max(self.source.count() - self.first, 0)

    def name(self, k: int) -> str:
        """File name of picture k, or the number of its frame."""
        return self.files[k] if self.files else f"frame {k}"

    def read(self, k: int) -> ImageArray:
        """Picture k (H, W); raises :class:`DamagedFrame` where it cannot be read."""
        picture = self.source.read(k + self.first, lambda _number, _picture: None)
        return np.ascontiguousarray(picture)

    def close(self) -> None:
        """Close what is open."""
        self.source.close()


def pictures_of_glob(pattern: str, camera: str, where: str) -> Pictures:
    """The files of a pattern, a folder of them, or one video. Raises InputError."""
    path = Path(pattern)
    if path.is_dir() or (path.suffix.lower() in VIDEO_SUFFIXES and path.is_file()):
        return _pictures_at(path, camera, where)
    found = [Path(one) for one in glob.glob(os.path.expanduser(pattern))]
    files = [one for one in found if one.suffix.lower() in IMAGE_SUFFIXES and one.is_file()]
    if len(found) == 1 and found[0].suffix.lower() in VIDEO_SUFFIXES:
        return _pictures_at(found[0], camera, where)
    if not files:
        remedy = "Give a pattern in quotes such as 'left/*.png', a folder, or one video."
        raise InputError(f"no image fits {pattern!r}", where, remedy)
    return _of_files(camera, files)


def pictures_of_recording(folder: Path, camera: str) -> Pictures:
    """The pictures of a recording's camera. Raises InputError."""
    for view in open_recording(folder).views:
        for key, stream in view.streams().items():
            if key not in NO_PICTURES and stream.camera == camera:
                where = f"{folder / DESCRIPTION}, view {view.name}, {key}"
                source = open_stream(folder, stream.frames, "grey", where)
                return Pictures(camera, source, stream.first_frame)
    what, remedy = f"the recording has no camera {camera!r}", "Name it as in recording.toml."
    raise InputError(what, folder, remedy)


def places_in(folder: Path) -> dict[str, Path]:
    """The video (first chapter), or folder of images, by camera. Raises InputError."""
    found: dict[str, Path] = {}
    chapters: set[Path] = set()
    for path in sorted(folder.iterdir()):
        is_video = path.suffix.lower() in VIDEO_SUFFIXES
        if path.name.startswith(".") or not (path.is_dir() or is_video):
            continue
        if path in chapters or (path.is_dir() and not _images_in(path)):
            continue
        if is_video:
            chapters.update(chapters_from(path))
        name = path.stem if is_video else path.name
        if name in found:
            what = f"there are two sources for camera {name}"
            raise InputError(what, folder, "Leave one video or one folder for each camera.")
        found[name] = path
    if not found:
        what = "it contains neither a recording nor videos or folders of images"
        remedy = "Put one video or one folder of images per camera into it, named as the camera."
        raise InputError(what, folder, remedy)
    return found


def _pictures_at(path: Path, camera: str, where: str) -> Pictures:
    if path.is_dir():
        if not (files := _images_in(path)):
            raise InputError(f"the folder {path.name!r} contains no images", where, "Add them.")
        return _of_files(camera, files)
    videos = [open_stream(one.parent, one.name, "grey", where) for one in chapters_from(path)]
    return Pictures(camera, chapters_of(videos))


def _images_in(folder: Path) -> list[Path]:
    files = [one for one in folder.iterdir() if one.suffix.lower() in IMAGE_SUFFIXES]
    return [one for one in files if one.is_file() and not one.name.startswith(".")]


def _of_files(camera: str, files: Sequence[Path]) -> Pictures:
    """Image files by name, numbers in them by value."""

    def key(path: Path) -> list[tuple[int, int, str]]:
        parts = _DIGITS.split(path.name)
        return [(1, int(one), "") if one.isdigit() else (0, 0, one) for one in parts]

    ordered = sorted(files, key=key)
    images = NumberedImages(dict(enumerate(ordered)), "%d", "grey")
    return Pictures(camera, images, files=tuple(one.name for one in ordered))


def check_same_length(sources: Sequence[Pictures]) -> int:
    """The number of instants that all sources show. Raises InputError for files."""
    counts = {one.camera: one.count() for one in sources}
    if all(one.files for one in sources) and len(set(counts.values())) > 1:
        words = ", ".join(f"{name} {count}" for name, count in counts.items())
        what = f"the cameras have different numbers of pictures ({words})"
        same = "Picture k of all cameras must show the same instant"
        remedy = f"{same}: remove those that the other cameras do not have."
        raise InputError(what, "pictures", remedy)
    return min(counts.values(), default=0)


def recognised_in(pictures: Pictures, named: Board, work: Work = NO_WORK) -> Recognition:
    """The board as some pictures, spread over all of them, show it."""
    images = []
    for k in spread(pictures.count(), _SAMPLE):
        with suppress(DamagedFrame):
            images.append(pictures.read(k))
    return recognised(images, named, work)


def find_in_pictures(
    pictures: Pictures, recognition: Recognition, frames: Sequence[int], work: Work = NO_WORK
) -> Sightings:
    """The board in pictures of a camera; others are left out for reasons. Raises InputError."""
    found: dict[int, FloatArray] = {}
    left_out: list[LeftOut] = []
    size: tuple[int, int] | None = None
    for number, k in enumerate(frames):
        work.step(number / len(frames), f"{pictures.camera}, {pictures.name(k)}")
        pixels, reason = None, "the board was not found"
        try:
            image = pictures.read(k)
            own = image.shape[1], image.shape[0]
            size = size or own
            if own == size:
                pixels = recognition.find(image)
            else:
                reason = f"its size is {own[0]}x{own[1]} instead of {size[0]}x{size[1]}"
        except DamagedFrame as problem:
            reason = str(problem)
        if pixels is None:
            left_out.append(LeftOut(pictures.camera, k, pictures.name(k), reason))
        else:
            found[k] = pixels
    if size is None:
        what = f"none of {counted(len(frames), 'picture')} can be read" + (
            f": {left_out[0].reason}" if left_out else ""
        )
        raise InputError(what, f"camera {pictures.camera}", "Check the files.")
    shown = np.array(list(found), dtype=np.int64)
    places = np.array(list(found.values())).reshape(-1, len(recognition.board.corners), 2)
    names = tuple(pictures.name(k) for k in found)
    return Sightings(pictures.camera, size, shown, places, names, tuple(left_out), len(frames))
