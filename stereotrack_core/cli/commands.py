"""The commands of the program, and their parsers."""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NoReturn, cast

from stereotrack_core.cli.options import CommandLine, option
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
    """A command, whose module is imported when it is chosen; with subcommands none is."""

    name: str
    summary: str
    place: str = ""  # `module.name` of its `CommandLine`, if that is not `run` of its own module
    subcommands: tuple[Command, ...] = ()

    def load(self) -> CommandLine:
        """Import the module."""
        module, _, name = (self.place or self.name).partition(".")
        found = getattr(import_module(f"stereotrack_core.cli.{module}"), name or "run")
        return cast("CommandLine", found)


COMMANDS: tuple[Command, ...] = (
    Command("open", "open the workbench on a recording folder or project file", "workbench"),
    Command("demo", "track the demo recording, print its errors, open the workbench"),
    Command("simulate", "render a stereo recording with ground truth"),
    Command("info", "print what a recording contains and all problems found in it"),
    Command("cloud", "the fused point cloud of one frame as a PLY file"),
    Command("detector", "whether the pretrained pose detector is installed; `install` installs it",
            "detect.detector"),
    Command("detect", "keypoints of the person in all pictures, with it or a model of yours"),
    Command("track", "track the person through a recording and write the run"),
    Command("evaluate",
            "errors of a run against the reference; its joint angles, failures, or another run"),
    Command("compare", "compare runs with the first of them, frame by frame", "evaluate.compare"),
    Command("sweep",
            "track with several parameter values, recordings and seeds, and compare the results",
            "study.sweep"),
    Command("study", "track and evaluate many recordings, with their conditions, as one study",
            "", (
        Command("create", "list the recordings below folders, or add new ones", "study.create"),
        Command("status", "annotation, runs, errors and problems of every recording",
                "study.status"),
        Command("run", "track and evaluate recordings, on this machine or a cluster", "study.run"),
        Command("export", "write all results as one tidy table", "study.export"),
    )),
    Command("fit", "fit the body to clicked landmarks, to make a reference"),
    Command("import", "import labels or predictions into a project, or make a recording of videos",
            "", (
        Command("labels", "clicks or a trajectory of another tool, into a project",
                "into_project.import_labels"),
        Command("predictions", "keypoints of a 2-D detector, into a project",
                "into_project.import_predictions"),
        Command("recording", "a recording folder of videos or images", "import_recording"),
    )),
    Command("export", "export a run, or clicks, keypoints or a reference of a project"),
    Command("calibrate", "calibrate cameras from pictures of a board, or align a calibration", "", (
        Command("intrinsics", "the lens of one camera", "calibrate.calibrate_lens"),
        Command("stereo", "a pair of cameras side by side", "calibrate.calibrate_pair"),
        Command("world", "all cameras in one world", "calibrate.calibrate_rig"),
        Command("align", "z up, y north and the origin on the floor"),
        Command("import", "read a calibration of another tool", "calibrate.import_calibration"),
        Command("export", "write a calibration for another tool", "calibrate.export_calibration"),
    )),
    Command("project", "make a project for the annotation of a recording", "", (
        Command("create", "a project of a recording folder", "into_project.create"),
    )),
    Command("report", "write a report on a run: one page with errors, curves, failures and images"),
)  # fmt: skip


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
        own = make(description=f"{command.summary[0].upper()}{command.summary[1:]}.", **named)
        chooser = own.add_subparsers(metavar="COMMAND", required=True, help="what to do")
        for inner in command.subcommands:
            _filled(chooser.add_parser, inner, name=inner.name, help=inner.summary)
        options: Sequence[Any] = EVERYWHERE
    else:
        line = command.load()
        own = make(description=line.description, **named)
        own.set_defaults(run=line.run)
        options = (*EVERYWHERE, *line.options)
    for one in options:
        own.add_argument(*one.names, **one.keywords)
    return own


def command_named(name: str) -> Command:
    """The command of that name; InputError where there is none."""
    known = {command.name: command for command in COMMANDS}
    if name not in known:
        remedy = f"{did_you_mean(name, known)}`{PROGRAM} --help` lists all commands."
        raise InputError(f"unknown command {name!r}", remedy=remedy)
    return known[name]
