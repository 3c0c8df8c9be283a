"""Look at videos and images that are no recording yet: what belongs together, what each of them is.

The last number in an image's name is the number of the frame, or a time stamp: seconds with
decimals, or milli-, micro- or nanoseconds since 1970, as many recorders name their images.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError, shortened
from stereotrack_core.reading import reason
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.images import DamagedFrame, numbered_files, read_image, read_metres
from stereotrack_core.recording.importing.choices import AGAIN, METRIC_UNIT, Source, SourceKind
from stereotrack_core.recording.importing.video_sources import joined, rate_of, tracks_of
from stereotrack_core.recording.stream_files import is_image, is_video

_FEWEST_IMAGES = 2  # a single image beside videos is a background or a photo of the room, no stream
_LAST_NUMBER = re.compile(r"(\d+)(?=\D*$)")
_SECONDS = re.compile(r"(\d{9,10})\.(\d{1,9})")
_TICKS = {13: 1e-3, 16: 1e-6, 19: 1e-9}  # seconds, by the digits of a time since 1970
_STEPS = (1e-3, 10.0)  # seconds from one frame to the next
_FEWEST_PRESENT = 0.5  # of the numbers from the first to the last, where they count frames


def groups_of(paths: Iterable[Path]) -> Iterator[tuple[Path, ...]]:
    """Videos alone, and images of the same folder whose names differ in their last number."""
    given = [path for path in paths if path.is_file()]
    yield from _of_files(given)
    for folder in folders_of(paths):
        yield from _of_files(entries_of(folder))


def folders_of(paths: Iterable[Path]) -> Iterator[Path]:
    """The folders among paths, and the folders in them."""
    for folder in (path for path in paths if path.is_dir()):
        yield folder
        for inner in entries_of(folder):
            if inner.is_dir() and not inner.name.startswith("."):
                yield inner


def entries_of(folder: Path) -> list[Path]:
    """Contents of a folder; raises InputError if it cannot be read."""
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        what = f"the folder cannot be read ({reason(error)})"
        raise InputError(what, folder, "Check its permissions.") from None


def _of_files(files: Iterable[Path]) -> Iterator[tuple[Path, ...]]:
    files = [one for one in files if not one.name.startswith(".") and one.is_file()]
    for path in sorted(one for one in files if is_video(one)):
        yield (path,)
    images = sorted((one for one in files if is_image(one)), key=_place)
    for _, several in groupby(images, _place):
        group = sorted(several, key=_number)
        once = len({_number(path) for path in group}) == len(group)
        # else images of each suffix alone, as those of a preview beside the originals
        for suffix in sorted({path.suffix for path in group}) if not once else ("",):
            one = tuple(path for path in group if once or path.suffix == suffix)
            if len(one) >= _FEWEST_IMAGES:
                yield one


def _place(path: Path) -> tuple[str, str, str]:
    """Folder and name without the last number: the same for all images of a stream."""
    if _SECONDS.fullmatch(path.stem):
        return str(path.parent), "", ""
    before, _, after = _LAST_NUMBER.sub("\0", path.stem).partition("\0")
    return str(path.parent), before, after


def _number(path: Path) -> int:
    """The last number of a name; nanoseconds where it is seconds with decimals."""
    seconds = _SECONDS.fullmatch(path.stem)
    if seconds is not None:
        return int(seconds[1]) * 10**9 + int(seconds[2].ljust(9, "0"))
    found = _LAST_NUMBER.search(path.stem)
    return int(found.group()) if found else -1


def _numbering(files: Sequence[Path]) -> dict[str, Any]:
    """Fields of a source that its images' names tell: numbers of their frames, or their times.

    Numbers with a common step, most of which are there, count frames; where one is missing, that
    frame has no image. All others tell nothing but the order.

    Raises InputError where two names have the same number.
    """
    values = [_number(path) for path in files]
    twice = [b for (_, a), (b, c) in pairwise(zip(files, values, strict=True)) if a == c]
    if twice:
        what = f"two images have the same number ({twice[0].name} is the second)"
        raise InputError(what, files[0].parent, "Keep one of them.")
    in_order = {"numbers": tuple(range(len(values)))}
    if times := _times(files[0], values):
        rate, uneven, pause = rate_of(np.array(times))
        timing = {"start": times[0], "fps": rate, "uneven": uneven, "pause": pause}
        return {**in_order, **timing, "times": times}
    steps = Counter(b - a for a, b in pairwise(values))
    step = min(steps, key=lambda one: (-steps[one], one))
    frames = [(value - values[0]) / step for value in values]
    counted = all(frame == int(frame) for frame in frames)
    if not counted or len(values) < _FEWEST_PRESENT * (frames[-1] + 1):
        return {**in_order, "lowest": values[0]}
    pattern = _pattern_of(files) if step == 1 else ""
    return {"numbers": tuple(map(int, frames)), "pattern": pattern, "lowest": values[0]}


def _times(first: Path, values: Sequence[int]) -> tuple[float, ...]:
    """Seconds since 1970 of names that are time stamps with plausible steps."""
    nanoseconds = _SECONDS.fullmatch(first.stem) is not None
    tick = 1e-9 if nanoseconds else _TICKS.get(len(str(values[0])))
    if tick is None:
        return ()
    steps = sorted(tick * (b - a) for a, b in pairwise(values))
    middle = steps[len(steps) // 2]
    return tuple(tick * value for value in values) if _STEPS[0] <= middle <= _STEPS[1] else ()


def _pattern_of(files: Sequence[Path]) -> str:
    """The printf pattern of exactly these files; empty where there is none."""
    first = files[0]
    digits = _LAST_NUMBER.search(first.stem)
    if digits is None:
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


def check_sizes(files: Sequence[Path], size: tuple[int, int]) -> None:
    """Raise InputError where an image's header states another width and height than `size`."""
    from PIL import Image, UnidentifiedImageError

    others = []
    for path in files:
        try:
            with Image.open(path) as image:
                if image.size != size:
                    others.append(f"{path.name} ({image.size[0]} x {image.size[1]})")
        except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
            continue  # it is a damaged frame, or one of a kind that is not known there
    if others:
        first = f"the first one, {size[0]} x {size[1]} pixels"
        listed = shortened(", ".join(others))
        what = f"{len(others)} of {len(files)} images have another size than {first}: {listed}"
        apart = "Put images of each size into a folder of their own"
        raise InputError(what, files[0].parent, f"{apart}, or remove what does not belong to them.")


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
            raise InputError("there is no such file or folder", path, "Correct the path.")
    sources: list[Source] = []
    problems: list[InputError] = []
    for group in groups_of(paths):
        if len(sources) >= _MOST_SOURCES:
            break
        try:
            sources += [_images(group)] if is_image(group[0]) else tracks_of(group[0])
        except InputError as problem:
            problems.append(problem)
    sources, notes = joined(sources)
    in_groups = {path for group in groups_of(paths) for path in group}
    inner = [one for folder in folders_of(paths) for one in entries_of(folder)]
    alone = [one for one in (*paths, *inner) if is_image(one) and one not in in_groups]
    backgrounds = tuple(one for one in alone if one.is_file() and not one.name.startswith("."))
    if not sources:
        if problems:
            raise problems[0]
        single = len(backgrounds)
        what = "no videos and no numbered images were found"
        what += f", but {counted(single, 'single image')}" if single else ""
        remedy = "Name video files, or a folder with videos or folders of images."
        if single > 1:
            remedy = "Number images in their order, such as 0001.png."
        raise InputError(what, ", ".join(map(str, paths)), remedy)
    return Found(_named(sources), tuple(problems), backgrounds, tuple(notes), _common_folder(paths))


def is_media(path: Path) -> bool:
    """Whether a file looks like a video or an image."""
    return is_video(path) or is_image(path)


def is_unmade(path: Path) -> bool:
    """Whether a path holds videos or images of which a recording could be made."""
    if path.is_dir():
        return not (path / DESCRIPTION).exists() and next(groups_of([path]), None) is not None
    return path.is_file() and is_media(path)


def _images(files: tuple[Path, ...]) -> Source:
    first = files[0]
    kind, size, unit, bits = _what_is(first)
    check_sizes(files, size)
    told = _numbering(files) | ({"pattern": ""} if unit else {})
    return Source(
        name=_place(first)[1].strip("_-. ") or first.parent.name, path=first, kind=kind,
        width=size[0], height=size[1], frames=told["numbers"][-1] + 1, images=files, unit=unit,
        bits=bits, **told,
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
        raise InputError(complaint, image, AGAIN) from None
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
