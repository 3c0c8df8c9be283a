"""The commands of the program, and their parsers."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NoReturn

from stereotrack_core.cli.arguments import Part, option
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.version import __version__

PROGRAM = "stereotrack"


_FLAG = {"action": "store_true", "default": SUPPRESS}  # else a subcommand's would undo it
EVERYWHERE = (
    option("--debug", "show the traceback of an unexpected error", **_FLAG),
    option("-q --quiet", "no messages and no progress; only results, and errors", **_FLAG),
)
"""Options of all commands; they may also stand before the command."""


class _Parser(ArgumentParser):
    """A parser whose complaints are one sentence."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message, remedy=f"See `{self.prog} --help`.")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse arguments; axes such as ``--axes -x,y,-z`` would be taken for an option."""
        words: list[str] = []
        for word in [] if args is None else args:
            if words and words[-1] == "--axes" and word[:2].lower() in ("-x", "-y", "-z"):
                words[-1] += f"={word}"
            else:
                words.append(word)
        return super().parse_known_args(words, namespace)


@dataclass(frozen=True)
class Command:
    """A command, whose module is imported when it is chosen.

    The module has a ``DESCRIPTION`` for the command's own help, its ``OPTIONS``, and a function
    ``run`` that is given what was said and returns the exit status; or a :class:`Part` with these.
    A command with subcommands has none: the next word chooses one of these.
    """

    name: str
    summary: str
    module: str = ""
    """Where it has another name than the command; ``module.PART`` of one with several."""
    description: str = ""
    subcommands: tuple[Command, ...] = ()
    """`description` and `subcommands`: of a command without a module."""


COMMANDS: tuple[Command, ...] = (
    Command("open", "open the workbench on a recording folder or project file", "workbench"),
    Command("demo", "track the demo recording, print its errors, open the workbench"),
    Command("simulate", "render a stereo recording with ground truth"),
    Command("info", "print what a recording contains and all problems found in it"),
    Command("cloud", "the fused point cloud of one frame as a PLY file"),
    Command(
        "detector",
        "whether the pretrained pose detector is installed; `install` installs it",
        "detect.DETECTOR",
    ),
    Command("detect", "keypoints of the person in all pictures, with it or a model of yours"),
    Command("track", "track the person through a recording and write the run"),
    Command(
        "evaluate",
        "errors of a run against the reference; its joint angles, failures, or another run",
    ),
    Command("compare", "compare runs with the first of them, frame by frame", "evaluate.COMPARE"),
    Command(
        "sweep",
        "track with several parameter values, recordings and seeds, and compare the results",
    ),
    Command(
        "study",
        "track and evaluate many recordings, with their conditions, as one study",
        description="List recordings and their conditions in a study file, see how far they are, "
        "track them, and export all results as one table.",
        subcommands=(
            Command("create", "list the recordings below folders, or add new ones", "study.CREATE"),
            Command(
                "status", "annotation, runs, errors and problems of every recording", "study.STATUS"
            ),
            Command(
                "run", "track and evaluate recordings, on this machine or a cluster", "study.RUN"
            ),
            Command("export", "write all results as one tidy table", "study.EXPORT"),
        ),
    ),
    Command("fit", "fit the body to clicked landmarks, to make a reference"),
    Command(
        "import",
        "import labels or predictions into a project, or make a recording of videos",
        description="Import labels of another tool or predictions of a detector into a project, "
        "or make a recording of videos.",
        subcommands=(
            Command(
                "labels",
                "clicks or a trajectory of another tool, into a project",
                "into_project.LABELS",
            ),
            Command(
                "predictions",
                "keypoints of a 2-D detector, into a project",
                "into_project.PREDICTIONS",
            ),
            Command("recording", "a recording folder of videos or images", "import_recording"),
        ),
    ),
    Command("export", "export a run, or clicks, keypoints or a reference of a project"),
    Command(
        "calibrate",
        "calibrate cameras from pictures of a board, or align a calibration",
        description="Calibrate cameras from pictures of a board, align a calibration to the room, "
        "or convert calibrations from and to other tools.",
        subcommands=(
            Command("intrinsics", "the lens of one camera", "calibrate.INTRINSICS"),
            Command("stereo", "a pair of cameras side by side", "calibrate.STEREO"),
            Command("world", "all cameras in one world", "calibrate.WORLD"),
            Command("align", "z up, y north and the origin on the floor"),
            Command("import", "read a calibration of another tool", "calibration_files.IMPORT"),
            Command("export", "write a calibration for another tool", "calibration_files.EXPORT"),
        ),
    ),
    Command(
        "project",
        "make a project for the annotation of a recording",
        description="Make a project for the annotation of a recording.",
        subcommands=(Command("create", "a project of a recording folder", "into_project.CREATE"),),
    ),
    Command("report", "write a report on a run: one page with errors, curves, failures and images"),
)


def command_list() -> str:
    """All commands with one line each."""
    width = max(len(command.name) for command in COMMANDS)
    lines = [f"  {PROGRAM} {command.name:<{width}}  {command.summary}" for command in COMMANDS]
    bare = f"  {PROGRAM} {'':<{width}}  open the workbench with a welcome page"
    end = f"`{PROGRAM} COMMAND --help` shows the help of a command. All commands take --quiet."
    return "\n".join([f"{PROGRAM} {__version__}", "", bare, *lines, "", end])


def parser_of(command: Command) -> ArgumentParser:
    """The parser of a command; ``run`` of what it has read does the command."""
    return _filled(_Parser, command, prog=f"{PROGRAM} {command.name}")


def split(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Options of all commands that stand before the command, and the rest."""
    names = {name for one in EVERYWHERE for name in one.names}
    first = next((k for k, word in enumerate(arguments) if word not in names), len(arguments))
    return list(arguments[:first]), list(arguments[first:])


def _filled(make: Callable[..., ArgumentParser], command: Command, **named: str) -> ArgumentParser:
    """Make the parser of a command with its options, or with what chooses its subcommands."""
    if command.subcommands:
        own = make(description=command.description, **named)
        chooser = own.add_subparsers(metavar="COMMAND", required=True, help="what to do")
        for inner in command.subcommands:
            _filled(chooser.add_parser, inner, name=inner.name, help=inner.summary)
        options: Sequence[Any] = EVERYWHERE
    else:
        name, _, part = (command.module or command.name).partition(".")
        module = import_module(f"stereotrack_core.cli.{name}")
        said = getattr(module, part or "run")
        if not part:
            said = Part(module.DESCRIPTION, module.OPTIONS, said)
        own = make(description=said.description, **named)
        own.set_defaults(run=said.run)
        options = (*EVERYWHERE, *said.options)
    for one in options:
        own.add_argument(*one.names, **one.keywords)
    return own


def command_named(name: str) -> Command:
    """The command of that name; InputError where there is none."""
    known = {command.name: command for command in COMMANDS}
    if name not in known:
        raise InputError(
            f"unknown command {name!r}",
            remedy=f"{did_you_mean(name, known)}`{PROGRAM} --help` lists all commands.",
        )
    return known[name]
