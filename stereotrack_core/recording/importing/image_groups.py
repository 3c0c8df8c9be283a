"""Files of a folder that belong together, and the frame or instant of each image.

The last number in a name is the number of the frame, or a time stamp: seconds with decimals, or
milli-, micro- or nanoseconds since 1970, as many recorders name their images.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path

from stereotrack_core.errors import InputError, shortened
from stereotrack_core.reading import reason
from stereotrack_core.recording.images import numbered_files
from stereotrack_core.recording.stream_files import IMAGE_SUFFIXES, VIDEO_SUFFIXES

_FEWEST_IMAGES = 2
"""A single image beside videos is a background or a photo of the room, not a stream."""

_LAST_NUMBER = re.compile(r"(\d+)(?=\D*$)")
_SECONDS = re.compile(r"(\d{9,10})\.(\d{1,9})")
_TICKS = {13: 1e-3, 16: 1e-6, 19: 1e-9}  # seconds, by the digits of a time since 1970
_STEPS = (1e-3, 10.0)  # seconds from one frame to the next
_FEWEST_PRESENT = 0.5  # of the numbers from the first to the last, where they count frames


@dataclass(frozen=True)
class Numbering:
    """Frames and times of images, by their names."""

    numbers: tuple[int, ...]
    """Frame of each image, the first is 0; a number that is left out has no image."""
    times: tuple[float, ...]
    """Seconds since 1970 of each image; none where the names are no time stamps."""
    pattern: str  # printf pattern of exactly these images; empty where there is none
    lowest: int  # the number in the first name


def is_image(path: Path) -> bool:
    """Whether a name is that of an image."""
    return path.suffix.lower() in IMAGE_SUFFIXES


def is_video(path: Path) -> bool:
    """Whether a name is that of a video."""
    return path.suffix.lower() in VIDEO_SUFFIXES


def groups_of(paths: Iterable[Path]) -> Iterator[tuple[Path, ...]]:
    """Videos alone, and images of the same folder whose names differ in their last number."""
    given = [path for path in paths if path.is_file()]
    yield from _of_files(given)
    for folder in folders_of(paths):
        yield from _of_files(entries_of(folder))


def single_images(paths: Iterable[Path]) -> Iterator[Path]:
    """Images that are no frames of a stream: those that no other belongs to."""
    paths = tuple(paths)
    in_groups = {path for group in groups_of(paths) for path in group}
    files = [path for path in paths if path.is_file()]
    for path in (*files, *(one for folder in folders_of(paths) for one in entries_of(folder))):
        if is_image(path) and path not in in_groups and not path.name.startswith("."):
            yield path


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
        raise InputError(what, where=str(folder), remedy="Check its permissions.") from None


def stem_of(path: Path) -> str:
    """The name of an image without its number; empty where it is a number alone."""
    return _place(path)[1].strip("_-. ")


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


# ---- what the numbers mean


def numbering_of(files: Sequence[Path]) -> Numbering:
    """Frames or instants of the images of a stream, in order of their numbers.

    Numbers with a common step, most of which are there, count frames; where one is missing, that
    frame has no image. All others tell nothing but the order.

    Raises InputError where two names have the same number.
    """
    values = [_number(path) for path in files]
    twice = [b for (_, a), (b, c) in pairwise(zip(files, values, strict=True)) if a == c]
    if twice:
        what = f"two images have the same number ({twice[0].name} is the second)"
        raise InputError(what, where=str(files[0].parent), remedy="Keep one of them.")
    times = _times(files[0], values)
    steps = Counter(b - a for a, b in pairwise(values))
    step = min(steps, key=lambda one: (-steps[one], one))
    frames = [(value - values[0]) / step for value in values]
    counted = all(frame == int(frame) for frame in frames)
    enough = len(values) >= _FEWEST_PRESENT * (frames[-1] + 1)
    if times or not (counted and enough):
        return Numbering(tuple(range(len(values))), times, "", values[0])
    pattern = _pattern_of(files) if step == 1 else ""
    return Numbering(tuple(map(int, frames)), (), pattern, values[0])


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
        remedy = f"{apart}, or remove what does not belong to them."
        raise InputError(what, where=str(files[0].parent), remedy=remedy)
