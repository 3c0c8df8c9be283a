"""Commands about recordings, runs and the window."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...services.actions import Command
from ...shell.reasons import no_project, no_recording, no_run

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow


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
            "open_project",
            "&File",
            "Open a project …",
            "Open a project file (.stereotrack) with its recording.",
            w.projects.ask_for_project,
            "Ctrl+Alt+O",
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
        *_projects(w),
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
            "report",
            "&File",
            "Report …",
            "Write a page or a PDF about the active run: errors, curves, episodes with pictures, "
            "calibration, parameters, and how to do it again.",
            w.files.reports.ask_where,
            "Ctrl+Shift+R",
            "export",
            why_not=lambda: (
                no_run(w) or ("A report is being made." if w.files.reports.working else "")
            ),
        ),
    ]


def last_commands(w: MainWindow) -> list[Command]:
    """Commands at the end of the menu File."""
    return [
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


def _projects(w: MainWindow) -> list[Command]:
    return [
        Command(
            "copy_project", "&File/Project", "Save a copy …", "Write the project as it is now to "
            "another file; the project itself needs no saving.", w.projects.ask_for_copy,
            icon="save", why_not=lambda: no_project(w),
        ),
        Command(
            "take_over", "&File/Project", "Take over …", "Open for writing a project that another "
            "program seems to have, because that program is gone for certain.",
            w.projects.take_over, icon="lock",
            why_not=lambda: "" if w.project.in_use else "No other program has the project.",
        ),
        Command(
            "rescue_project", "&File/Project", "Rescue a damaged project …", "Save everything that "
            "can be read of a damaged project file into a new one.",
            w.projects.ask_what_to_rescue, icon="reset",
        ),
        Command(
            "projects_beside", "&File/Project", "New ones beside their recordings",
            "Make the project of a recording that has none beside its folder.",
            w.projects.keep_beside, checked=w.projects.kept_beside, section=True,
        ),
        Command(
            "projects_folder", "&File/Project", "New ones in a folder …",
            "Choose a folder for the projects of recordings that have none yet.",
            w.projects.ask_for_home, icon="settings",
            checked=lambda: not w.projects.kept_beside(),
        ),
    ]  # fmt: skip
