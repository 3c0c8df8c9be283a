"""The window program: ``open``, ``demo`` and the welcome page."""

from __future__ import annotations

import os
import signal
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from stereotrack_core.cli.command import FAILED, OK, WRONG_INPUT
from stereotrack_core.cli.demo import demo_places
from stereotrack_core.cli.output import say
from stereotrack_core.cli.program import main as command_line
from stereotrack_core.cli.program import parser
from stereotrack_core.errors import InputError

from .screen import load_qt, prepare


def start(arguments: Sequence[str]) -> int:
    """Show the window as the arguments ask; return the exit status."""
    try:
        args = parser().parse_args(list(arguments)) if arguments else Namespace(command="")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else OK
    except InputError as error:
        return _refuse(error)
    picture = getattr(args, "screenshot", None)
    if getattr(args, "headless", False):
        done = command_line(_without_screenshot(arguments), app_package=__package__)
        if done != OK:
            return done
    try:
        _check(args, picture)
        prepare(needs_screen=picture is None)
        load_qt()
    except InputError as error:
        return _refuse(error)
    before = signal.signal(signal.SIGINT, _leave_at_once)
    try:
        return _show(args, picture)
    finally:
        signal.signal(signal.SIGINT, before)


def _leave_at_once(*_: object) -> None:
    """End the program at Ctrl-C while the window is being made.

    An exception would be raised somewhere within Qt, which swallows it or does not survive it.
    What a project says is on the drive already. A window that is shown closes instead.
    """
    os.write(2, b"Stopped.\n")
    os._exit(FAILED)


def _refuse(error: InputError) -> int:
    say(f"stereotrack: {error}")
    return WRONG_INPUT


def _without_screenshot(arguments: Sequence[str]) -> list[str]:
    """Return the arguments without ``--screenshot PNG``."""
    kept, skip = [], False
    for word in arguments:
        if skip:
            skip = False
        elif word == "--screenshot":
            skip = True
        elif not word.startswith("--screenshot="):
            kept.append(word)
    return kept


def _check(args: Namespace, picture: Path | None) -> None:
    """Refuse at once what can be known to be wrong before a window is there."""
    if args.command == "open":
        from stereotrack_core.project.database import check_header
        from stereotrack_core.recording.folder import open_recording

        from .shell.workspaces.names import check_workspace_name

        check_workspace_name(args.workspace)
        if args.path.is_file() and args.path.name != "recording.toml":
            check_header(args.path)
        else:
            open_recording(args.path.parent if args.path.is_file() else args.path)
    if picture is not None:
        folder = picture.absolute().parent
        if not folder.is_dir() or not os.access(folder, os.W_OK):
            raise InputError(
                "the picture cannot be written there",
                where=str(picture),
                remedy="Name a folder that exists and that you may write to.",
            )


def _show(args: Namespace, picture: Path | None) -> int:
    from .program import WindowProgram

    program = WindowProgram()
    program.window.project.makes = picture is None  # a picture leaves nothing behind
    if args.command == "open":
        program.window.files.open(args.path, frame=args.frame, workspace=args.workspace)
    elif args.command == "demo" and args.headless:
        program.window.follower.change_display(keep_person=True)
        places = demo_places(args.folder)
        program.window.files.open(
            places.recording, frame=program.DEMO_FRAME, workspace="track", run=places.run
        )
    elif args.command == "demo":
        program.track_demo(args)
    if picture is None:
        return program.run()
    return OK if program.picture(picture) else FAILED
