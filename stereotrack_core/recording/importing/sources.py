"""Look at videos and images that are no recording yet: what each of them is."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.images import DamagedFrame, read_image, read_metres
from stereotrack_core.recording.importing import image_groups
from stereotrack_core.recording.importing.source import AGAIN, METRIC_UNIT, Source, SourceKind
from stereotrack_core.recording.importing.video_sources import joined, rate_of, tracks_of

_MOST_SOURCES = 100


@dataclass(frozen=True)
class Found:
    """Sources in folders and files that somebody named."""

    sources: tuple[Source, ...]
    problems: tuple[InputError, ...] = ()  # errors of the files that could not be read
    backgrounds: tuple[Path, ...] = ()
    """Single images beside the streams, some of which may show the empty scene."""
    notes: tuple[str, ...] = ()  # remarks on them, in clauses
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
            what = "there is no such file or folder"
            raise InputError(what, where=str(path), remedy="Correct the path.")
    sources: list[Source] = []
    problems: list[InputError] = []
    for group in image_groups.groups_of(paths):
        if len(sources) >= _MOST_SOURCES:
            break
        try:
            sources += [_images(group)] if image_groups.is_image(group[0]) else tracks_of(group[0])
        except InputError as problem:
            problems.append(problem)
    sources, notes = joined(sources)
    if not sources:
        if problems:
            raise problems[0]
        single = len(list(image_groups.single_images(paths)))
        what = "no videos and no numbered images were found"
        what += f", but {counted(single, 'single image')}" if single else ""
        remedy = "Name video files, or a folder with videos or folders of images."
        if single > 1:
            remedy = "Number images in their order, such as 0001.png."
        raise InputError(what, where=", ".join(map(str, paths)), remedy=remedy)
    backgrounds = tuple(image_groups.single_images(paths))
    return Found(_named(sources), tuple(problems), backgrounds, tuple(notes), _common_folder(paths))


def is_media(path: Path) -> bool:
    """Whether a file looks like a video or an image."""
    return image_groups.is_video(path) or image_groups.is_image(path)


def is_unmade(path: Path) -> bool:
    """Whether a path holds videos or images of which a recording could be made."""
    if path.is_dir():
        return not (path / DESCRIPTION).exists() and holds_media(path)
    return path.is_file() and is_media(path)


def holds_media(folder: Path) -> bool:
    """Whether a folder, or one of its folders, holds videos or several images by their names."""
    return next(image_groups.groups_of([folder]), None) is not None


# ---- one source


def _images(files: tuple[Path, ...]) -> Source:
    first = files[0]
    kind, size, unit, bits = _what_is(first)
    image_groups.check_sizes(files, size)
    numbering = image_groups.numbering_of(files)
    timing: dict[str, Any] = {}
    if times := numbering.times:
        rate, uneven, pause = rate_of(np.array(times))
        timing = {"times": times, "start": times[0], "fps": rate, "uneven": uneven, "pause": pause}
    return Source(
        name=image_groups.stem_of(first) or first.parent.name,
        path=first, kind=kind, width=size[0], height=size[1], frames=numbering.numbers[-1] + 1,
        images=files, pattern="" if unit else numbering.pattern, numbers=numbering.numbers,
        lowest=None if numbering.times else numbering.lowest, unit=unit, bits=bits,
        **timing,
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
