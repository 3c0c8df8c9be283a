"""Commands about recordings, runs and the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.actions import Command
from app.commands.reasons import no_recording, no_run

if TYPE_CHECKING:
    from app.main_window import MainWindow


def commands(w: MainWindow) -> list[Command]:
    """Commands of the menu File."""
    return [
        Command(
            "open",
            "&File",
            "Open a recording …",
            "Open a recording folder.",
            w.files.ask_for_recording,
            "Ctrl+O",
            "open",
        ),
        Command(
            "demo",
            "&File",
            "Make and track the demo",
            "Render four stereo views of a moving person with known truth (once), and track them.",
            w.files.begin_demo,
            icon="run-tracker",
            why_not=lambda: "The demo is being made." if w.files.making_demo else "",
        ),
        Command(
            "close",
            "&File",
            "Close the recording",
            "Go back to the welcome page.",
            w.files.close_recording,
            "Ctrl+W",
            why_not=lambda: no_recording(w),
        ),
        Command(
            "open_run",
            "&File",
            "Open a run …",
            "Show a stored run (.npz) over this recording.",
            w.files.ask_for_run,
            "Ctrl+Shift+O",
            "open",
            section=True,
            why_not=lambda: no_recording(w),
        ),
        Command(
            "save_run",
            "&File",
            "Save the run as …",
            "Save the active run: complete (.npz), or as .csv, .trc, .c3d or .bvh.",
            w.files.ask_where_to_save,
            "Ctrl+S",
            "save",
            why_not=lambda: no_run(w),
        ),
        Command(
            "picture",
            "&File",
            "Save a picture of the window …",
            "Save what is seen now as PNG.",
            w.files.ask_for_picture,
            "Ctrl+Shift+P",
            "picture",
        ),
        Command(
            "quit",
            "&File",
            "Quit",
            "Stop everything and close the window.",
            w.close_later,
            "Ctrl+Q",
            "close",
            section=True,
        ),
    ]
