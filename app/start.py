"""Shows the window as the program asks."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from typing import TYPE_CHECKING

from stereotrack_core.errors import InputError
from stereotrack_core.window import Opening

from .screen import load_qt, prepare

if TYPE_CHECKING:
    from .program import WindowProgram


def show(opening: Opening, say: Callable[[str], None]) -> bool:
    """Show the window until it is closed; whether all went well.

    Raises
    ------
    InputError
        For what cannot be shown.
    """
    _check(opening)
    prepare(needs_screen=opening.picture is None)
    load_qt()
    before = signal.signal(signal.SIGINT, _leave_at_once)
    try:
        from .program import WindowProgram

        program = WindowProgram()
        _begin(program, opening)
        return program.run() if opening.picture is None else program.picture(opening.picture, say)
    finally:
        signal.signal(signal.SIGINT, before)


def _leave_at_once(*_: object) -> None:
    """End the program at Ctrl-C while the window is being made.

    An exception would be raised somewhere within Qt, which swallows it or does not survive it.
    What a project says is on the drive already. A window that is shown closes instead.
    """
    os.write(2, b"Stopped.\n")
    os._exit(1)


def _check(opening: Opening) -> None:
    """Refuse at once what can be known to be wrong before a window is there."""
    path, picture = opening.path, opening.picture
    if path is not None:
        from stereotrack_core.project.database import check_header
        from stereotrack_core.recording.folder import open_recording

        from .workspace_names import check_workspace_name

        check_workspace_name(opening.workspace)
        if path.is_file() and path.name != "recording.toml":
            check_header(path)
        else:
            open_recording(path.parent if path.is_file() else path)
    if picture is not None:
        folder = picture.absolute().parent
        if not folder.is_dir() or not os.access(folder, os.W_OK):
            raise InputError(
                "cannot write the image here",
                where=str(picture),
                remedy="Choose a folder that exists and that you may write to.",
            )


def _begin(program: WindowProgram, opening: Opening) -> None:
    context = program.context
    context.session.project.makes = opening.picture is None  # a picture leaves nothing behind
    if opening.run is not None or opening.demo is not None:
        context.view_state.change_display(keep_person=True)
    if opening.demo is not None:
        program.track_demo(opening.demo, opening.frame)
    elif opening.path is not None:
        context.session.opening.open(
            opening.path, frame=opening.frame, workspace=opening.workspace, run=opening.run
        )
