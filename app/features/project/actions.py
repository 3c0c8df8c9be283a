"""Commands about recordings, projects and stored runs, and those that take edits back."""

from __future__ import annotations

from ...services.actions import Command
from ...session.session import Session
from .files import FileController
from .projects import ProjectController


def commands(session: Session, files: FileController, projects: ProjectController) -> list[Command]:
    """Commands of the menus File and Edit."""
    return [*_files(session, files, projects), *_edits(session, projects)]


def _files(session: Session, files: FileController, projects: ProjectController) -> list[Command]:
    return [
        Command(
            "open",
            "&File",
            "Open a recording …",
            "Open a recording folder.",
            files.ask_for_recording,
            "Ctrl+O",
            "open",
        ),
        Command(
            "open_project",
            "&File",
            "Open a project …",
            "Open a project file (.stereotrack) and its recording.",
            projects.ask_for_project,
            "Ctrl+Alt+O",
            "open",
        ),
        Command(
            "demo",
            "&File",
            "Create and track demo",
            "Render four stereo views of a moving person with known ground truth (only the first "
            "time), and track them.",
            files.begin_demo,
            icon="run-tracker",
            why_not=lambda: "The demo is already being created." if files.making_demo else "",
        ),
        Command(
            "close",
            "&File",
            "Close the recording",
            "Close the recording and show the welcome page.",
            files.close_recording,
            "Ctrl+W",
            why_not=session.no_recording,
        ),
        *_projects(session, projects),
        Command(
            "open_run",
            "&File",
            "Open run …",
            "Show a saved run (.npz) with this recording.",
            files.ask_for_run,
            "Ctrl+Shift+O",
            "open",
            section=True,
            why_not=session.no_recording,
        ),
        Command(
            "save_run",
            "&File",
            "Save run as …",
            "Save the active run: complete (.npz), or as .csv, .trc, .c3d or .bvh.",
            files.ask_where_to_save,
            "Ctrl+S",
            "save",
            why_not=session.no_run,
        ),
    ]


def _projects(session: Session, projects: ProjectController) -> list[Command]:
    return [
        Command(
            "copy_project", "&File/Project", "Save a copy …",
            "Write the project in its present state to another file. The project itself is always "
            "saved.", projects.ask_for_copy,
            icon="save", why_not=session.no_project,
        ),
        Command(
            "take_over", "&File/Project", "Force unlock …", "Open for writing a project that is "
            "locked by another program, when that program is certainly no longer running.",
            projects.take_over, icon="lock",
            why_not=lambda: "" if session.project.in_use else "The project is not locked.",
        ),
        Command(
            "rescue_project", "&File/Project", "Recover damaged project …",
            "Save everything that can be read from a damaged project file to a new one.",
            projects.ask_what_to_rescue, icon="reset",
        ),
        Command(
            "projects_beside", "&File/Project", "Keep new projects beside recordings",
            "Create the project of a new recording beside the recording's folder.",
            projects.keep_beside, checked=projects.kept_beside, section=True,
        ),
        Command(
            "projects_folder", "&File/Project", "Keep new projects in folder …",
            "Choose a folder for the projects of new recordings.",
            projects.ask_for_home, icon="settings",
            checked=lambda: not projects.kept_beside(),
        ),
    ]  # fmt: skip


def _edits(session: Session, projects: ProjectController) -> list[Command]:
    def said(verb: str, words: str) -> str:
        return f"{verb}: {words}" if words else verb

    def nothing(words: str, verb: str) -> str:
        return session.no_edit() or ("" if words else f"There is nothing to {verb}.")

    return [
        Command(
            "undo", "&Edit", "Undo", "Undo the last edit and show where it was made. Undo is "
            "unlimited and includes edits of earlier sessions.",
            session.project.undo, "Ctrl+Z", "undo",
            lambda: nothing(session.project.to_undo(), "undo"),
            says=lambda: said("Undo", session.project.to_undo()),
        ),
        Command(
            "redo", "&Edit", "Redo", "Redo the last edit that was undone.",
            session.project.redo, "Ctrl+Shift+Z", "redo",
            lambda: nothing(session.project.to_redo(), "redo"),
            says=lambda: said("Redo", session.project.to_redo()),
        ),
        Command(
            "annotator", "&Edit", "Annotator …", "Set the name that your edits are stored "
            "under.",
            projects.ask_annotator, icon="settings", section=True,
        ),
    ]  # fmt: skip
