"""What a person does to the study that is shown: recordings, values, columns, undo."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Qt, Signal, Slot
from PySide6.QtWidgets import QDialog

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.project.whereabouts import SUFFIX as PROJECT_SUFFIX
from stereotrack_core.study.create import Found, Pattern
from stereotrack_core.study.editing import (
    with_column,
    with_column_renamed,
    with_names_of_folders,
    with_recordings,
    with_value,
    without,
    without_column,
)
from stereotrack_core.study.file import Study

from ...services.actions import ActionRegistry, Command, Menu
from ...widgets.forms.form_dialog import ask_to_open_several
from ...widgets.redraw import RedrawQueue
from .edit_dialogs import (
    RemoveColumnDialog,
    TextDialog,
    ValueDialog,
    ask_for_folders,
    column_choice,
)
from .editor import StudyEditor
from .window import StudyWindow

_PROJECTS = f"Projects (*{PROJECT_SUFFIX})"
_NO_COLUMN = "The study has no columns that can be edited. Add one first."
_PATTERN_NOTE = (
    "Write a name of a column for each of the last folders. Empty cells of the selected recordings "
    "are filled, and columns are added where they are missing."
)


class StudyEditing(QObject):
    """Offers the edits of a study in its window, asks what is needed, and makes them.

    Attributes
    ----------
    busy : str
        Why no recordings can be added now, as a sentence; empty where they can.
    """

    add_wanted = Signal(object)
    """Tuple of folders and project files whose recordings are to be added."""

    def __init__(self, window: StudyWindow, settings: QSettings) -> None:
        super().__init__(window)
        self.window, self.busy = window, ""
        self.editor = StudyEditor(self)
        self.actions = ActionRegistry(window, settings, RedrawQueue(window))
        self.actions.add(self._commands())
        self.actions.refused.connect(lambda words: window.say(words, error=True))
        window.offer(self.actions)
        window.selection_changed.connect(self.refresh)
        window.cell_edited.connect(self.set_value)
        window.dropped.connect(self._on_dropped)
        self.editor.changed.connect(self._show)
        self.editor.stack.changed.connect(self.refresh)
        self.editor.said.connect(lambda words, error: window.say(words, error=error))
        self.refresh()

    @Slot()
    def refresh(self) -> None:
        """Find out what can be done now."""
        self.actions.refresh()

    def _commands(self) -> list[Command]:
        return [*self._row_commands(), *self._column_commands(), *self._undo_commands()]

    def _row_commands(self) -> list[Command]:
        command = Menu("&Study").command
        return [
            command("study_add_folders", "Add folders …", "Add the recordings in and below folders "
                    "to the study. Several folders can be chosen, or dragged onto the table.",
                    self._ask_for_folders, "Ctrl+N", "add", why_not=lambda: self.busy),
            command("study_add_projects", "Add project files …", "Add the recordings of project "
                    "files to the study. A recording that is listed takes the project.",
                    self._ask_for_projects, "Ctrl+Shift+N", why_not=lambda: self.busy),
            command("study_edit_cell", "Edit cell", "Edit the cell under the cursor. What you "
                    "write goes into all selected recordings.",
                    self.window.view.edit_current, "F2", section=True, why_not=self._why_no_value),
            command("study_set_value", "Set value …", "Set a value for all selected recordings.",
                    self._ask_for_value, "Shift+F2", why_not=self._why_no_value),
            command("study_fill", "Fill from folder names …", "Fill empty cells of the selected "
                    "recordings from the names of their folders.",
                    self._ask_for_pattern, why_not=self._why_no_row),
            command("study_remove", "Remove from study", "Remove the selected recordings from the "
                    "study. No file is deleted.",
                    self.remove, "Del", "delete", section=True, why_not=self._why_no_row),
        ]  # fmt: skip

    def _column_commands(self) -> list[Command]:
        command = Menu("&Columns").command
        return [
            command("study_add_column", "Add column …", "Add an empty column to the study.",
                    self._ask_for_column),
            command("study_rename_column", "Rename column …", "Give a column of the study another "
                    "name. Its values stay.", self._ask_for_name, why_not=self._why_no_column),
            command("study_remove_column", "Remove column …", "Remove a column of the study with "
                    "its values.", self._ask_which_column, why_not=self._why_no_column),
        ]  # fmt: skip

    def _undo_commands(self) -> list[Command]:
        command, stack = Menu("&Edit").command, self.editor.stack

        def said(verb: str, back: bool) -> str:
            entry = stack.to_undo() if back else stack.to_redo()
            return verb if entry is None else f"{verb} {entry.words[:1].upper()}{entry.words[1:]}"

        return [
            command("study_undo", "Undo", "Undo the last edit of the study since it was opened.",
                    stack.undo, "Ctrl+Z", "undo", says=lambda: said("Undo", True),
                    why_not=lambda: "" if stack.to_undo() else "There is nothing to undo."),
            command("study_redo", "Redo", "Redo what was undone last.",
                    stack.redo, "Ctrl+Shift+Z", "redo", says=lambda: said("Redo", False),
                    why_not=lambda: "" if stack.to_redo() else "There is nothing to redo."),
        ]  # fmt: skip

    # ---- why not

    def _why_no_row(self) -> str:
        return "" if self.window.selected() else "Select recordings in the table first."

    def _why_no_column(self) -> str:
        return "" if self.editor.study.factors else _NO_COLUMN

    def _why_no_value(self) -> str:
        return self._why_no_column() or self._why_no_row()

    # ---- recordings

    def _ask_for_folders(self) -> None:
        ask_for_folders(self.window, self.editor.study.folder, self._on_dropped)

    def _ask_for_projects(self) -> None:
        start = str(self.editor.study.folder)
        ask_to_open_several(self.window, "Add projects", start, _PROJECTS, self._on_dropped)

    @Slot(object)
    def _on_dropped(self, paths: Sequence[Path]) -> None:
        if self.busy:
            self.window.say(f"Nothing was added. {self.busy}", error=True)
        elif paths:
            self.add_wanted.emit(tuple(paths))

    def add(self, found: Found) -> None:
        """Add what was found in folders and projects, and say what was not."""
        before = {row.recording for row in self.editor.study.rows}
        new = [row.recording for row in found.rows if row.recording not in before]
        named = len(found.rows) - len(new)
        words = f"add {counted(len(new), 'recording')}" if new else "set projects"
        if not self.attempt(words, lambda study: with_recordings(study, found.rows)):
            return
        if found.rows:
            self.window.select(row.recording for row in found.rows)
        said = [f"{counted(len(new), 'recording')} added."]
        if found.listed:
            said.append(f"{counted(found.listed, 'recording')} listed already.")
        if named:
            said.append(f"Projects set for {counted(named, 'recording')} listed already.")
        said += [f"{one.where}: {one.what}. {one.remedy}" for one in found.findings]
        self.window.say(" ".join(said), error=not found.rows and bool(found.findings))

    @Slot()
    def remove(self) -> None:
        """Remove the selected recordings from the study."""
        recordings = self._selected()
        count = counted(len(recordings), "recording")
        if self.attempt(f"remove {count}", lambda study: without(study, recordings)):
            self.window.say(
                f"{count} removed from the study. No file was deleted, and runs stay in "
                f"{self.editor.study.runs.name}. Undo lists them again."
            )

    # ---- values

    @Slot(object, str, str)
    def set_value(self, recordings: Iterable[str], column: str, value: str) -> None:
        """Write a value into a column of some recordings, and say it."""
        self._try(lambda: self._set_value(tuple(recordings), column, value))

    def _set_value(self, recordings: tuple[str, ...], column: str, value: str) -> None:
        count = counted(len(recordings), "recording")
        edited = self.editor.do(
            f"set {column} of {count}", lambda study: with_value(study, recordings, column, value)
        )
        what = f"is {value.strip()!r}" if value.strip() else "is empty"
        self.window.say(f"{column} {what} in {count}." if edited else "Nothing has changed.")

    def _ask_for_value(self) -> None:
        recordings = self._selected()

        def do(column: str, value: str) -> None:
            self._set_value(recordings, column, value)

        column = self.window.view.current_factor()
        self._open(ValueDialog(self.editor.study, len(recordings), column, do, self.window))

    def _ask_for_pattern(self) -> None:
        recordings = self._selected()

        def do(_column: str, text: str) -> None:
            pattern = Pattern(text, where="pattern")
            self.editor.do(
                "fill from folder names",
                lambda study: with_names_of_folders(study, recordings, pattern),
            )
            path = [row for row in self.editor.study.rows if row.recording in recordings]
            unlike = sum(pattern.factors_of_end(row.recording) is None for row in path)
            said = f" {counted(unlike, 'recording')} did not fit." if unlike else ""
            self.window.say(f"Filled from folder names.{said}")

        field = ("&Pattern", "subject/condition", "A * stands for a folder without a meaning")
        first = f"A selected recording: {recordings[0]}. {_PATTERN_NOTE}"
        self._open(
            TextDialog("Fill from folder names", "&Fill", field, first, do, parent=self.window)
        )

    # ---- columns

    def _ask_for_column(self) -> None:
        def do(_column: str, name: str) -> None:
            if self.editor.do(f"add column {name.strip()}", lambda study: with_column(study, name)):
                self.window.say(f"Column {name.strip()} added.")

        field = ("&Name", "age", "Name of the new column")
        note = "The column stands behind the others, and in the table of results."
        self._open(TextDialog("Add column", "&Add", field, note, do, parent=self.window))

    def _ask_for_name(self) -> None:
        def do(column: str, name: str) -> None:
            self.editor.do(
                f"rename column {column}", lambda study: with_column_renamed(study, column, name)
            )
            self.window.say(f"Column {column} is called {name.strip()} now.")

        study = self.editor.study
        columns = column_choice(study, self.window.view.current_factor())
        field = ("&New name", "session", "Name of the column from now on")
        note = "The values stay."
        self._open(TextDialog("Rename column", "&Rename", field, note, do, columns, self.window))

    def _ask_which_column(self) -> None:
        def do(column: str, _text: str) -> None:
            self.editor.do(f"remove column {column}", lambda study: without_column(study, column))
            self.window.say(f"Column {column} removed. Undo brings it back.")

        def filled(column: str) -> int:
            return sum(bool(row.factors.get(column)) for row in self.editor.study.rows)

        columns = column_choice(self.editor.study, self.window.view.current_factor())
        self._open(RemoveColumnDialog(columns, filled, do, self.window))

    # ---- inside

    def attempt(self, words: str, edit: Callable[[Study], Study]) -> bool:
        """Make an edit; where it cannot be made, that is said."""
        return self._try(lambda: self.editor.do(words, edit))

    def _try(self, do: Callable[[], object]) -> bool:
        try:
            do()
        except InputError as error:
            self.window.say(str(error), error=True)
            return False
        return True

    def _selected(self) -> tuple[str, ...]:
        return tuple(row.row.recording for row in self.window.selected())

    @Slot()
    def _show(self) -> None:
        self.window.show_edited(self.editor.study)

    @staticmethod
    def _open(dialog: QDialog) -> None:
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.open()
