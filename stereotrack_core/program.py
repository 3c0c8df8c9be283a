"""The program: its commands, and how errors end it."""

from __future__ import annotations

import contextlib
import os
import sys
import traceback
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Sequence
from typing import NoReturn

from stereotrack_core.cli import (
    angles,
    bench,
    benchmark,
    cloud,
    compare,
    demo,
    episodes,
    evaluate,
    export,
    fit,
    import_labels,
    info,
    proportions,
    report,
    reproduce,
    simulate,
    sweep,
    track,
    workbench,
)
from stereotrack_core.cli.command import FAILED, OK, WRONG_INPUT, Command
from stereotrack_core.cli.output import put, say
from stereotrack_core.cli.workbench import show_window
from stereotrack_core.errors import Cancelled, InputError, did_you_mean
from stereotrack_core.version import __version__
from stereotrack_core.window import Opening, Window

PROGRAM = "stereotrack"


class _Parser(ArgumentParser):
    """A parser whose complaints are one sentence."""

    def error(self, message: str) -> NoReturn:
        raise InputError(message, remedy=f"See `{self.prog} --help`.")


def _add_no_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "command_name", nargs="?", metavar="COMMAND", help="a command (default: list all commands)"
    )


def _help(args: Namespace) -> int:
    if args.command_name is None:
        put(command_list())
        return OK
    return main([args.command_name, "--help"])


HELP = Command(
    name="help",
    summary="list all commands, or show the help of one command",
    description="List all commands, or show the help of one command.",
    add_arguments=_add_no_arguments,
    run=_help,
)

_MODULES = (
    *(workbench, demo, simulate, info, cloud, proportions, track, evaluate, compare, angles),
    *(episodes, sweep, fit, import_labels, export, benchmark, report, reproduce, bench),
)
COMMANDS: tuple[Command, ...] = (*(module.COMMAND for module in _MODULES), HELP)


def command_list() -> str:
    """All commands with one line each."""
    width = max(len(command.name) for command in COMMANDS)
    lines = [f"  {PROGRAM} {command.name:<{width}}  {command.summary}" for command in COMMANDS]
    bare = f"  {PROGRAM} {'':<{width}}  open the workbench with a welcome page"
    end = f"`{PROGRAM} COMMAND --help` shows the help of a command."
    return "\n".join([f"{PROGRAM} {__version__}", "", bare, *lines, "", end])


def parser() -> ArgumentParser:
    """The parser of the whole program; ``run`` of the result does the command."""
    root = _Parser(PROGRAM, formatter_class=RawDescriptionHelpFormatter, usage=command_list())
    root.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    commands = root.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)
    for command in COMMANDS:
        own = commands.add_parser(
            command.name,
            help=command.summary,
            description=command.description or command.summary,
            prog=f"{PROGRAM} {command.name}",
        )
        command.add_arguments(own)
        own.add_argument(
            "--debug", action="store_true", help="show the traceback of an unexpected error"
        )
        own.set_defaults(run=command.run)
    return root


def main(argv: Sequence[str] | None = None, *, window: Window | None = None) -> int:
    """Run one command; return the exit status: 0 done, 2 wrong input, 1 everything else.

    Without `argv` the arguments are those of the process. The core itself does not know the
    workbench; without a `window` commands that need it say so.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        if not arguments and window is not None:
            return show_window(window, Opening())
        if not arguments or arguments[0] in ("-h", "--help"):
            put(command_list())
            return OK
        _check_command(arguments[0])
        args = parser().parse_args(arguments, Namespace(window=window))
        status: int = args.run(args)
        return status
    except SystemExit as end:  # argparse, after --help or --version
        return end.code if isinstance(end.code, int) else OK
    except InputError as error:
        text = str(error)
        say(f"{PROGRAM}: {text}" if text.endswith((".", "!", "?")) else f"{PROGRAM}: {text}.")
        return WRONG_INPUT
    except (Cancelled, KeyboardInterrupt):
        say("Stopped.")
        return FAILED
    except BrokenPipeError:
        # the reader of our output has left; nothing more can be said to it
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except PermissionError as error:
        where = error.filename or "a file"
        say(f"{PROGRAM}: {where}: permission denied. Check the permissions of the file or folder.")
        return WRONG_INPUT
    except OSError as error:
        if error.filename is None or "--debug" in arguments:
            return _unexpected(error, debug="--debug" in arguments)
        remedy = "Check that the drive is connected and has free space."
        say(f"{PROGRAM}: {error.filename}: {error.strerror or error}. {remedy}")
        return FAILED
    except Exception as error:  # noqa: BLE001 - the last resort: a sentence instead of a traceback
        return _unexpected(error, debug="--debug" in arguments)


def _check_command(name: str) -> None:
    known = [command.name for command in COMMANDS]
    if name not in known and not name.startswith("-"):
        raise InputError(
            f"unknown command {name!r}",
            remedy=f"{did_you_mean(name, known)}`{PROGRAM} help` lists all commands.",
        )


def _unexpected(error: Exception, *, debug: bool) -> int:
    if debug:
        say("".join(traceback.format_exception(error)).rstrip())
        return FAILED
    detail = " ".join(str(error).split())
    kind = type(error).__name__
    say(
        f"Unexpected error in the program ({kind}: {detail or 'no details'}). Run the same "
        "command with --debug for details."
    )
    return FAILED
