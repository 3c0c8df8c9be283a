"""Recordings, projects and stored runs: opening, saving, undo."""

from functools import partial

from stereotrack_core.project.history import Entry

from ...context import Context
from ...services.actions import Command, Menu
from ...session.changes import Part
from ...session.edits import WindowEdit
from ...session.opening import MOST_RECENT
from ...session.session import Session
from .files import FileController, ProjectController
from .importing.wizard import ImportController


def _files(
    session: Session,
    files: FileController,
    projects: ProjectController,
    importing: ImportController,
) -> list[Command]:
    command, project = Menu("&File").command, Menu("&File/Project").command
    return [
        command("open", "Open a recording …", "Open a recording folder.", files.ask_for_recording,
                "Ctrl+O", "open"),
        *_recents(session, files),
        command("open_project", "Open a project …", "Open a project file (.stereotrack) and its "
                "recording.", projects.ask_for_project, "Ctrl+Alt+O", "open"),
        command("import_recording", "Make a recording of videos …", "Make a recording folder of "
                "videos, stereo videos, or folders of images or depth maps.",
                importing.ask_for_videos, "", "camera"),
        command("demo", "Open and track demo", "Open four stereo views of a simulated person "
                "with known ground truth, and track them.", files.begin_demo, icon="run-tracker"),
        command("close", "Close the recording", "Close the recording and show the welcome page. "
                "Trials are discarded, and changes of parameters can no longer be undone.",
                files.close_recording, "Ctrl+W", why_not=session.no_recording),
        project("copy_project", "Save a copy …", "Write the project in its present state to "
                "another file. The project itself is always saved.", projects.ask_for_copy,
                icon="save", why_not=session.no_project),
        project("take_over", "Force unlock …", "Open for writing a project that is locked by "
                "another program, when that program is certainly no longer running.",
                projects.take_over, icon="lock", why_not=lambda: (
                    "" if session.project.in_use else "The project is not locked.")),
        project("projects_beside", "Keep new projects beside recordings", "Create the project of "
                "a new recording beside the recording's folder.", projects.keep_beside,
                checked=projects.kept_beside, section=True),
        project("projects_folder", "Keep new projects in folder …", "Choose a folder for the "
                "projects of new recordings.", projects.ask_for_home, icon="settings",
                checked=lambda: not projects.kept_beside()),
        command("open_run", "Open run …", "Show a saved run (.npz) with its recording.",
                files.ask_for_run, "Ctrl+Shift+O", "open", section=True),
        command("save_run", "Save run as …", "Save the active run complete, or export it to "
                "OpenSim, C3D, BVH or as joint angles.",
                files.ask_where_to_save, "Ctrl+S", "save",
                why_not=session.no_run),
    ]  # fmt: skip


def _recents(session: Session, files: FileController) -> list[Command]:
    none = "Nothing was opened yet."

    def says(place: int) -> str:
        found = files.recents[place : place + 1]  # none beyond the end of the list
        return "".join(f"{path.name}   {path.parent}" for path in found)

    def there(place: int) -> bool:
        return place < len(files.recents)

    command = Menu("&File/Open &recent", lambda: "" if files.recents else none).command
    return [
        *(
            command(
                f"recent_{place + 1}", f"Recent {place + 1}", "Open this recording or project "
                "again.",
                partial(files.open_recent, place), says=partial(says, place),
                shown=partial(there, place),
            )
            for place in range(MOST_RECENT)
        ),
        command("forget_recent", "Clear this list", "Forget what was opened. No file is deleted.",
                session.opening.forget_recents, icon="delete", section=True),
    ]  # fmt: skip


def _edits(session: Session, projects: ProjectController) -> list[Command]:
    def said(verb: str, entry: Entry | WindowEdit | None) -> str:
        return verb if entry is None else f"{verb} {entry.words[:1].upper()}{entry.words[1:]}"

    def nothing(entry: Entry | WindowEdit | None, verb: str) -> str:
        none = session.no_edit() or f"There is nothing to {verb}."
        return none if entry is None else ""

    edits, command = session.edits, Menu("&Edit").command
    return [
        command("undo", "Undo", "Undo what was done last, and show where: clicks and other edits "
                "of the project without limit, parameters as long as the recording is open.",
                edits.undo, "Ctrl+Z", "undo",
                why_not=lambda: nothing(edits.to_undo(), "undo"),
                says=lambda: said("Undo", edits.to_undo())),
        command("redo", "Redo", "Redo what was undone last.", edits.redo, "Ctrl+Shift+Z", "redo",
                why_not=lambda: nothing(edits.to_redo(), "redo"),
                says=lambda: said("Redo", edits.to_redo())),
        command("annotator", "Annotator …", "Set the name that your edits are stored under.",
                projects.ask_annotator, icon="settings", section=True),
    ]  # fmt: skip


def register(context: Context) -> FileController:
    """Offer files and edits."""
    files = FileController(context)
    projects, importing = ProjectController(context), ImportController(context)
    context.actions.add(_files(context.session, files, projects, importing))
    context.actions.add(_edits(context.session, projects))
    # keys that follow an edit at once find them ready
    context.session.changes.watch(Part.EDITS, lambda: context.actions.refresh("&Edit"))
    return files
