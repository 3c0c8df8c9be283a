"""The program: one of its commands, and how errors end it."""

import contextlib
import os
import sys
import traceback
from argparse import Namespace
from collections.abc import Sequence

from stereotrack_core.cli.commands import PROGRAM, command_list, command_named, parser_of, split
from stereotrack_core.cli.output import FAILED, OK, WRONG_INPUT, complain, put, speaking
from stereotrack_core.cli.workbench import show_window
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.version import __version__
from stereotrack_core.window import Opening, ShowWindow


def main(argv: Sequence[str] | None = None, *, window: ShowWindow | None = None) -> int:
    """Run one command; return the exit status: 0 done, 2 wrong input, 1 everything else.

    Without `argv` the arguments are those of the process. The core itself does not know the
    workbench; without a `window` commands that need it say so.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        if not arguments and window is not None:
            return show_window(window, Opening())
        everywhere, words = split(arguments)
        if not words or words[0] in ("-h", "--help"):
            put(command_list())
            return OK
        if words[0] == "--version":
            put(f"{PROGRAM} {__version__}")
            return OK
        parser = parser_of(command_named(words[0]))
        args = parser.parse_args([*everywhere, *words[1:]], Namespace(window=window))
        with speaking(quiet=getattr(args, "quiet", False)):
            status: int = args.run(args)
        return status
    except SystemExit as end:  # argparse, after --help or --version
        return end.code if isinstance(end.code, int) else OK
    except InputError as error:
        text = str(error)
        complain(f"{PROGRAM}: {text}" if text.endswith((".", "!", "?")) else f"{PROGRAM}: {text}.")
        return WRONG_INPUT
    except (Cancelled, KeyboardInterrupt) as stop:
        complain(f"Stopped. {stop}".rstrip())
        return FAILED
    except BrokenPipeError:
        # the reader of our output has left; nothing more can be said to it
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except PermissionError as error:
        where = error.filename or "a file"
        remedy = "Check the permissions of the file or folder."
        complain(f"{PROGRAM}: {where}: permission denied. {remedy}")
        return WRONG_INPUT
    except OSError as error:
        if error.filename is None or "--debug" in arguments:
            return _unexpected(error, debug="--debug" in arguments)
        remedy = "Check that the drive is connected and has free space."
        complain(f"{PROGRAM}: {error.filename}: {error.strerror or error}. {remedy}")
        return FAILED
    except Exception as error:  # noqa: BLE001 - the last resort: a sentence instead of a traceback
        return _unexpected(error, debug="--debug" in arguments)


def _unexpected(error: Exception, *, debug: bool) -> int:
    if debug:
        complain("".join(traceback.format_exception(error)).rstrip())
        return FAILED
    reason = " ".join(str(error).split())
    kind = type(error).__name__
    complain(
        f"Unexpected error in the program ({kind}: {reason or 'no details'}). Run the same "
        "command with --debug for details."
    )
    return FAILED
