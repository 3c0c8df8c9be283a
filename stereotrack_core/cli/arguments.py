"""Options of the commands, those that several share, and checks of what they were given."""

from __future__ import annotations

import os
import tempfile
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.errors import InputError

if TYPE_CHECKING:  # the program begins with this file
    from stereotrack_core.recording.description import Recording


@dataclass(frozen=True)
class Option:
    """What a command is given: the arguments of :meth:`argparse.ArgumentParser.add_argument`."""

    names: tuple[str, ...]
    keywords: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Part:
    """A command of a module that has several: its help, its options, and what does it."""

    description: str
    options: tuple[Option, ...]
    run: Callable[[Namespace], int]


def option(words: str, text: str, **keywords: Any) -> Option:
    """Declare an option as its help begins with it, ``-o --output FILE``, or an argument.

    An argument has no dashes: its name in the program, then the name that people read.
    """
    names = tuple(word for word in words.split() if word.startswith("-")) or (words.split()[0],)
    if metavar := " ".join(words.split()[len(names) :]):
        keywords["metavar"] = metavar
    return Option(names, {"help": text, **keywords})


def flag(name: str, text: str) -> Option:
    """Declare an option without a value."""
    return option(name, text, action="store_true")


def changes(what: str) -> Option:
    """Changes of parameters; `what` begins the help."""
    text = f"{what}; may be given several times"
    return option("--set NAME=VALUE", text, action="append", default=[], dest="changes")


RECORDING = option("recording RECORDING", "folder that contains recording.toml", type=Path)
LAYOUT = option(
    "--layout NAME",
    "order of the points of files without names, such as coco17, body25 or body25b (default: told "
    "by their number and a body's proportions)",
)
PERSON = option(
    "--person NAME",
    "name or number of the person in keypoints of several (default: the surest of all frames)",
)
JSON = flag("--json", "print the result as JSON")
PRESET = option(
    "--preset accurate|thesis|fast|FILE.toml",
    "preset that the parameters come from (default: accurate), or a file with your own preset as "
    "saved by the workbench",
    default="accurate",
)
SETTINGS = (PRESET, changes("change one parameter"))
FRAMES = option("--frames A:B", "only frames A up to but not including B; either may be omitted")
SEGMENTS = flag("--segments", "also print the results for each segment of segments.csv")
VIEWS = option(
    "--views NS or cam_0+cam_2",
    "use only these views; join names with +; single-letter names may be written together",
)
SEED = option("--seed N", "random seed (default: 0)", type=int, default=0)
FPS = option("--fps N", "frames per second, for files that do not state it", type=float)
NAMES = option(
    "--name THEIRS=OURS",
    "landmark name here for a landmark name in the file; may be given several times",
    action="append",
    default=[],
    dest="names",
)
AXES = option(
    "--axes EAST,NORTH,UP",
    "the axes of a .trc, .c3d or .csv file that point east, north and up, for example z,x,y "
    "or x,-z,y; by default z,x,y for .trc, and what the file states, or x,y,z, for the others",
)
STATED = (NAMES, AXES)
REFERENCE = option(
    "--reference FILE",
    "reference landmarks (.csv, .trc, .c3d), or with their uncertainty (.npz of `stereotrack "
    "fit`); by default the reference of the run's recording",
    type=Path,
)
OF_RUN = option(
    "--recording DIR", "the run's recording; by default the one named in the run", type=Path
)


def check_least(least: int, **values: int | None) -> None:
    """Refuse numbers, by the names of their options, that are less than a least one.

    Raises InputError for the first that is.
    """
    for name, value in values.items():
        if value is not None and value < least:
            raise InputError(
                f"{value} is less than {least}",
                where=f"--{name.replace('_', '-')}",
                remedy=f"Give {least} or more.",
            )


def check_suffix(path: Path, *suffixes: str) -> None:
    """Refuse a name of a file that does not end as its format wants.

    Raises InputError with a name that would do.
    """
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"the name must end in {' or '.join(suffixes)}",
            where=str(path),
            remedy=f"Use the name {path.with_suffix(suffixes[0]).name}.",
        )


def check_output(path: Path, recording: Recording | None = None) -> Path:
    """Refuse at once what could not be written after long work.

    Raises InputError where the folder does not exist, or is the recording's own, which is never
    written to.
    """
    if not path.parent.is_dir():
        raise InputError(
            "there is no such folder",
            where=str(path.parent),
            remedy="Create it, or choose another folder.",
        )
    if path.is_dir():
        raise InputError(
            "this is a folder", where=str(path), remedy="Give the name of a file in it."
        )
    place = Path(os.path.realpath(path))  # which knows links that lead in a circle
    if recording is not None and place.is_relative_to(recording.folder.resolve()):
        raise InputError(
            "this is inside the recording folder, which is never written to",
            where=str(path),
            remedy="Choose a place outside the recording folder.",
        )
    try:
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        raise InputError(
            f"cannot write to this folder ({error.strerror})",
            where=str(path.parent),
            remedy="Choose a folder that you may write to.",
        ) from None
    return path
