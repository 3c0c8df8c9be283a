"""The commands of the program, and ``stereotrack help``, which tells of them."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import NoReturn

from stereotrack_core.cli.arguments import option
from stereotrack_core.cli.output import OK, put
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.version import __version__

PROGRAM = "stereotrack"

DESCRIPTION = "List all commands, or show the help of one command."
OPTIONS = (option("command_name COMMAND", "a command (default: list all commands)", nargs="?"),)


_FLAG = {"action": "store_true", "default": SUPPRESS}  # else a subcommand's would undo it
EVERYWHERE = (
    option("--debug", "show the traceback of an unexpected error", **_FLAG),
    option("-q --quiet", "no messages and no progress; only results, and errors", **_FLAG),
    option("-v --verbose", "also tell which files are read and written, and the time", **_FLAG),
)
"""Options of all commands; they may also stand before the command."""


class _Parser(ArgumentParser):
    """A parser whose complaints are one sentence."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message, remedy=f"See `{self.prog} --help`.")


@dataclass(frozen=True)
class Command:
    """A command, whose module is imported when it is chosen.

    The module has a ``DESCRIPTION`` for the command's own help, its ``OPTIONS``, and a function
    ``run`` that is given what was said and returns the exit status. Where it has ``SUBCOMMANDS``
    instead of the last two, the next word chooses one of these commands.
    """

    name: str
    summary: str
    module: str = ""
    """Where it has another name than the command."""


COMMANDS: tuple[Command, ...] = (
    Command("open", "open the workbench on a recording folder or project file", "workbench"),
    Command(
        "demo", "create a demo recording (once), track it, print its errors, open the workbench"
    ),
    Command("simulate", "render a stereo recording with ground truth"),
    Command("info", "print what a recording contains and all problems found in it"),
    Command("cloud", "the fused point cloud of one frame as a PLY file"),
    Command("detect", "keypoints of the person in all pictures, with a pose model that you give"),
    Command("proportions", "estimate a person's segment lengths from the recording"),
    Command("track", "track the person through a recording and write the run"),
    Command(
        "evaluate", "compute the errors of a run against the reference, with the thesis's measures"
    ),
    Command(
        "compare", "compare runs: how much better one is, and whether the difference is significant"
    ),
    Command(
        "angles",
        "joint angles of a run or reference: ranges of motion, velocities, left-right differences",
    ),
    Command("episodes", "detect failures in a run and their probable causes"),
    Command(
        "sweep",
        "track with several parameter values, recordings and seeds, and compare the results",
    ),
    Command("study", "track and evaluate many recordings, with their conditions, as one study"),
    Command("fit", "fit the body to clicked landmarks, to make a reference"),
    Command(
        "import",
        "import labels or predictions into a project, or make a recording of videos",
        "import_chosen",
    ),
    Command("export", "export a run, or clicks, keypoints or a reference of a project"),
    Command("calibrate", "calibrate cameras from pictures of a board, or align a calibration"),
    Command("project", "make a project for the annotation of a recording", "project_chosen"),
    Command("benchmark", "compare presets and baselines on recordings with a reference"),
    Command("report", "write a report on a run: one page with errors, curves, failures and images"),
    Command("reproduce", "reproduce the tables and curves of the thesis"),
    Command("bench", "run the README's benchmarks, as ratios"),
    Command("completion", "print a script by which a shell completes commands and options"),
    Command("help", "list all commands, or show the help of one command", "commands"),
)


def command_list() -> str:
    """All commands with one line each."""
    width = max(len(command.name) for command in COMMANDS)
    lines = [f"  {PROGRAM} {command.name:<{width}}  {command.summary}" for command in COMMANDS]
    bare = f"  {PROGRAM} {'':<{width}}  open the workbench with a welcome page"
    end = (
        f"`{PROGRAM} COMMAND --help` shows the help of a command. All commands take --quiet and "
        "--verbose."
    )
    return "\n".join([f"{PROGRAM} {__version__}", "", bare, *lines, "", end])


def parser_of(command: Command) -> ArgumentParser:
    """The parser of a command; ``run`` of what it has read does the command."""
    module = import_module(f"stereotrack_core.cli.{command.module or command.name}")
    own = _Parser(f"{PROGRAM} {command.name}", description=module.DESCRIPTION)
    _fill(own, module)
    return own


def program_parser() -> ArgumentParser:
    """The parser of all commands at once, for what asks which there are."""
    own = _Parser(PROGRAM)
    chooser = own.add_subparsers(metavar="COMMAND")
    for command in COMMANDS:
        module = import_module(f"stereotrack_core.cli.{command.module or command.name}")
        inner = chooser.add_parser(
            command.name, help=command.summary, description=module.DESCRIPTION
        )
        _fill(inner, module)
    return own


def split(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Options of all commands that stand before the command, and the rest."""
    names = {name for one in EVERYWHERE for name in one.names}
    first = next((k for k, word in enumerate(arguments) if word not in names), len(arguments))
    return list(arguments[:first]), list(arguments[first:])


def _fill(own: ArgumentParser, module: ModuleType) -> None:
    for one in EVERYWHERE:
        own.add_argument(*one.names, **one.keywords)
    if hasattr(module, "SUBCOMMANDS"):
        chooser = own.add_subparsers(metavar="COMMAND", required=True, help="what to do")
        for command in module.SUBCOMMANDS:
            inner = import_module(f"stereotrack_core.cli.{command.module}")
            text = command.summary
            _fill(chooser.add_parser(command.name, help=text, description=inner.DESCRIPTION), inner)
        return
    for one in module.OPTIONS:
        own.add_argument(*one.names, **one.keywords)
    own.set_defaults(run=module.run)


def command_named(name: str) -> Command:
    """The command of that name; InputError where there is none."""
    known = {command.name: command for command in COMMANDS}
    if name not in known:
        raise InputError(
            f"unknown command {name!r}",
            remedy=f"{did_you_mean(name, known)}`{PROGRAM} help` lists all commands.",
        )
    return known[name]


def run(args: Namespace) -> int:
    """Print the list of commands, or one command's own help."""
    if args.command_name is None:
        put(command_list())
    else:
        parser_of(command_named(args.command_name)).print_help()
    return OK
