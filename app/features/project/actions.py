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
            "Open a project file (.stereotrack) with its recording.",
            projects.ask_for_project,
            "Ctrl+Alt+O",
            "open",
        ),
        Command(
            "demo",
            "&File",
            "Make and track the demo",
            "Render four stereo views of a moving person with known truth (once), and track them.",
            files.begin_demo,
            icon="run-tracker",
            why_not=lambda: "The demo is being made." if files.making_demo else "",
        ),
        Command(
            "close",
            "&File",
            "Close the recording",
            "Go back to the welcome page.",
            files.close_recording,
            "Ctrl+W",
            why_not=session.no_recording,
        ),
        *_projects(session, projects),
        Command(
            "open_run",
            "&File",
            "Open a run …",
            "Show a stored run (.npz) over this recording.",
            files.ask_for_run,
            "Ctrl+Shift+O",
            "open",
            section=True,
            why_not=session.no_recording,
        ),
        Command(
            "save_run",
            "&File",
            "Save the run as …",
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
            "copy_project", "&File/Project", "Save a copy …", "Write the project as it is now to "
            "another file; the project itself needs no saving.", projects.ask_for_copy,
            icon="save", why_not=session.no_project,
        ),
        Command(
            "take_over", "&File/Project", "Take over …", "Open for writing a project that another "
            "program seems to have, because that program is gone for certain.",
            projects.take_over, icon="lock",
            why_not=lambda: "" if session.project.in_use else "No other program has the project.",
        ),
        Command(
            "rescue_project", "&File/Project", "Rescue a damaged project …", "Save everything that "
            "can be read of a damaged project file into a new one.",
            projects.ask_what_to_rescue, icon="reset",
        ),
        Command(
            "projects_beside", "&File/Project", "New ones beside their recordings",
            "Make the project of a recording that has none beside its folder.",
            projects.keep_beside, checked=projects.kept_beside, section=True,
        ),
        Command(
            "projects_folder", "&File/Project", "New ones in a folder …",
            "Choose a folder for the projects of recordings that have none yet.",
            projects.ask_for_home, icon="settings",
            checked=lambda: not projects.kept_beside(),
        ),
    ]  # fmt: skip


def _edits(session: Session, projects: ProjectController) -> list[Command]:
    def said(verb: str, words: str) -> str:
        return f"{verb}: {words}" if words else verb

    def nothing(words: str, verb: str) -> str:
        return session.no_edit() or ("" if words else f"There is no edit to {verb}.")

    return [
        Command(
            "undo", "&Edit", "Undo", "Take the last edit back and show where it was; works without "
            "limit, also for edits of earlier days.", session.project.undo, "Ctrl+Z", "undo",
            lambda: nothing(session.project.to_undo(), "undo"),
            says=lambda: said("Undo", session.project.to_undo()),
        ),
        Command(
            "redo", "&Edit", "Redo", "Make the edit again that was taken back last.",
            session.project.redo, "Ctrl+Shift+Z", "redo",
            lambda: nothing(session.project.to_redo(), "redo"),
            says=lambda: said("Redo", session.project.to_redo()),
        ),
        Command(
            "annotator", "&Edit", "Who annotates …", "Say whose name edits are signed with.",
            projects.ask_annotator, icon="settings", section=True,
        ),
    ]  # fmt: skip
