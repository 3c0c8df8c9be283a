"""Options of the commands, those that several share, and checks of what they were given."""

import math
import os
import tempfile
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.locks import writing


@dataclass(frozen=True)
class Option:
    """Arguments of :meth:`argparse.ArgumentParser.add_argument`."""

    names: tuple[str, ...]
    keywords: dict[str, Any] = field(default_factory=dict)
    suffixes: tuple[str, ...] | None = None
    """Endings allowed for the name of an output file, any if empty; None for other options."""


@dataclass(frozen=True)
class CommandLine:
    """A command: the text and the options of its help, and its function."""

    description: str
    options: tuple[Option, ...]
    run: Callable[[Namespace], int]


def command(
    *options: Option, json: bool = True
) -> Callable[[Callable[[Namespace], int]], CommandLine]:
    """Make a command of a function that returns the exit status; its docstring is the help.

    Its result may be asked for as JSON, unless it has none. Where it writes an :func:`output`, that
    is checked before and held meanwhile.
    """
    written = next((one.suffixes for one in options if one.suffixes is not None), None)

    def made(run: Callable[[Namespace], int]) -> CommandLine:
        def checked(args: Namespace) -> int:
            if written is None:
                return run(args)
            check_suffix(args.output, *written)
            check_output(args.output, args.recording if RECORDING in options else None)
            with writing(args.output):
                return run(args)

        every = (*options, JSON) if json else options
        return CommandLine(" ".join((run.__doc__ or "").split()), every, checked)

    return made


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


def path(words: str, text: str, **keywords: Any) -> Option:
    """Declare a file or folder."""
    return option(words, text, type=Path, **keywords)


def output(metavar: str, text: str, *suffixes: str) -> Option:
    """Declare the file that a command writes, and the endings that its name may have."""
    declared = path(f"-o --output {metavar}", text, required=True)
    return replace(declared, suffixes=suffixes)


def several(words: str, text: str, **keywords: Any) -> Option:
    """Declare an option that may be given several times."""
    text += "; may be given several times"
    return option(words, text, action="append", default=[], **keywords)


def positive(text: str) -> float:
    """A number above 0, as the type of an option."""
    value = float(text)
    if not 0.0 < value < math.inf:
        raise ArgumentTypeError(f"{text} is not a number above 0")
    return value


def at_least(least: int) -> Callable[[str], int]:
    """Make a type of an option: whole numbers from a least one on."""

    def whole(text: str) -> int:
        if int(text) < least:
            raise ArgumentTypeError(f"{text} is less than {least}")
        return int(text)

    return whole


def changes(what: str) -> Option:
    """Declare changes of parameters; `what` begins the help."""
    return several("--set NAME=VALUE", what, dest="changes")


JSON = flag("--json", "print the result as JSON")
RECORDING = path("recording RECORDING", "folder that contains recording.toml")
LAYOUT = option(
    "--layout NAME",
    "order of the points of files without names, such as coco17, body25 or body25b (default: told "
    "by their number and a body's proportions)",
)
PERSON = option(
    "--person NAME",
    "name or number of the person in keypoints of several (default: the surest of all frames)",
)
PRESET = option(
    "--preset accurate|thesis|fast|FILE.toml",
    "preset that the parameters come from (default: accurate), or a file with your own preset as "
    "saved by the workbench",
)
SETTINGS = (
    replace(PRESET, keywords={**PRESET.keywords, "default": "accurate"}),
    changes("change one parameter"),
)
FRAMES = option("--frames A:B", "only frames A up to but not including B; either may be omitted")
SEGMENTS = flag("--segments", "also print the results for each segment of segments.csv")
SCENARIOS = path(
    "--scenarios PROJECT",
    "the same for each named stretch of a project, and for the segments of its recording",
)
VIEWS = option(
    "--views NS or cam_0+cam_2",
    "use only these views; join names with +; single-letter names may be written together",
)
SEED = option("--seed N", "random seed (default: 0)", type=int, default=0)
FPS = option("--fps N", "frames per second, for files that do not state it", type=positive)
NAMES = several(
    "--name THEIRS=OURS", "landmark name here for a landmark name in the file", dest="names"
)
AXES = option(
    "--axes EAST,NORTH,UP",
    "the axes of a .trc, .c3d or .csv file that point east, north and up, for example z,x,y "
    "or x,-z,y; by default z,x,y for .trc, and what the file states, or x,y,z, for the others",
)
STATED = (NAMES, AXES)
REFERENCE = path(
    "--reference FILE",
    "reference landmarks (.csv, .trc, .c3d), or with their uncertainty (.npz of `stereotrack "
    "fit`); by default the reference of the run's recording",
)
MAX_SIGMA = option(
    "--max-sigma MM",
    "leave out landmarks of the reference with a larger standard deviation, in millimetres "
    "(default: 100)",
    type=positive,
    default=100.0,
)
EXCLUDE = several(
    "--exclude SOURCE",
    "leave out landmarks of the reference by their source",
    choices=("clicked", "merged", "imported", "accepted", "detector", "fit", "interpolated"),
)
OF_RUN = path("--recording DIR", "the run's recording; by default the one named in the run")


def check_suffix(path: Path, *suffixes: str) -> None:
    """Raise InputError for a file's name that ends in none of these, with one that would do."""
    if suffixes and path.suffix.lower() not in suffixes:
        what = f"the name must end in {' or '.join(suffixes)}"
        raise InputError(what, path, f"Use the name {path.with_suffix(suffixes[0]).name}.")


def check_output(path: Path, recording: Path | None = None) -> Path:
    """Refuse what could not be written after long work: no folder, or one of the recording."""
    if not path.parent.is_dir():
        remedy = "Create it, or choose another folder."
        raise InputError("there is no such folder", path.parent, remedy)
    if path.is_dir():
        raise InputError("this is a folder", path, "Give the name of a file in it.")
    place = Path(os.path.realpath(path))  # which knows links that lead in a circle
    if recording is not None and place.is_relative_to(os.path.realpath(recording)):
        what = "this is inside the recording folder, which is never written to"
        raise InputError(what, path, "Choose a place outside the recording folder.")
    try:
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        what = f"cannot write to this folder ({error.strerror})"
        raise InputError(what, path.parent, "Choose a folder that you may write to.") from None
    return path
