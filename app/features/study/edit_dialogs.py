"""What is asked before a study is edited: folders, a value for several rows, names of columns."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QFileDialog,
    QFormLayout,
    QLineEdit,
    QWidget,
)

from stereotrack_core.counting import counted
from stereotrack_core.study.editing import values_of
from stereotrack_core.study.file import Study

from ...widgets.forms.form_dialog import FormDialog, line_edit
from ...widgets.style.building import choice, label, searchable

Do: TypeAlias = Callable[[str, str], object]
"""Is given the column and the text; raises InputError where that makes no sense."""


def ask_for_folders(
    parent: QWidget, start: Path, use: Callable[[tuple[Path, ...]], object]
) -> QFileDialog:
    """Let the person choose several folders at once, which dialogs of the system do not offer."""
    dialog = QFileDialog(parent, "Add folders with recordings", str(start))
    dialog.setFileMode(QFileDialog.FileMode.Directory)
    dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
    dialog.setOption(QFileDialog.Option.ShowDirsOnly)
    dialog.setLabelText(QFileDialog.DialogLabel.Accept, "&Add")
    for view in dialog.findChildren(QAbstractItemView):
        if view.objectName() in ("listView", "treeView"):
            view.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
    dialog.filesSelected.connect(lambda chosen: use(tuple(Path(one) for one in chosen)))
    dialog.open()
    return dialog


def column_choice(study: Study, column: str) -> QComboBox:
    """A list of the columns that can be edited."""
    box = choice("Column", [(name, name) for name in study.factors], "Column of the study")
    box.setCurrentIndex(max(box.findData(column), 0))
    return box


class ValueDialog(FormDialog):
    """Asks for the value of a column in several recordings."""

    def __init__(
        self, study: Study, count: int, column: str, do: Do, parent: QWidget | None = None
    ) -> None:
        super().__init__("Set value", "&Set", self._set, parent)
        self._study, self._do = study, do
        self.column = column_choice(study, column)
        self.value = searchable(
            choice("Value", tip="Type a value, or choose one that other recordings have")
        )
        self.column.currentIndexChanged.connect(self._propose)
        form = QFormLayout()
        form.addRow("Recordings:", label(f"{counted(count, 'recording')} selected"))
        form.addRow("&Column:", self.column)
        form.addRow("&Value:", self.value)
        note = label("An empty value empties the cells.", "muted")
        self.lay_out(form, note, None, size=(420, 200))
        self._propose()
        self.value.setFocus()

    def _propose(self) -> None:
        typed = self.value.currentText()
        self.value.clear()
        self.value.addItems(list(values_of(self._study, self.column.currentData())))
        self.value.setEditText(typed)

    def _set(self) -> None:
        column, value = self.column.currentData(), self.value.currentText()
        if self.attempt(lambda: self._do(column, value)):
            self.accept()


class TextDialog(FormDialog):
    """Asks for one text, such as a name or a pattern, and for a column where some are given."""

    def __init__(
        self,
        title: str,
        accept: str,
        field: tuple[str, str, str],
        note: str,
        do: Do,
        columns: QComboBox | None = None,
        parent: QWidget | None = None,
    ) -> None:
        """`field` is the label of the text, what an example of it is, and its tip."""
        super().__init__(title, accept, self._do_it, parent)
        self._do, self.column = do, columns
        name, example, tip = field
        self.text: QLineEdit = line_edit(name.replace("&", ""), "", example, tip)
        form = QFormLayout()
        if columns is not None:
            form.addRow("&Column:", columns)
            columns.currentTextChanged.connect(self.text.setText)
            self.text.setText(columns.currentText())
            self.text.selectAll()
        form.addRow(f"{name}:", self.text)
        self.lay_out(form, label(note, "muted"), None, size=(420, 170))
        self.text.setFocus()

    def _do_it(self) -> None:
        column = "" if self.column is None else self.column.currentData()
        if self.attempt(lambda: self._do(column, self.text.text())):
            self.accept()


class RemoveColumnDialog(FormDialog):
    """Asks which column is removed."""

    def __init__(
        self, columns: QComboBox, filled: Callable[[str], int], do: Do, parent: QWidget | None
    ) -> None:
        super().__init__("Remove column", "&Remove", self._remove, parent)
        self._filled, self._do, self.column = filled, do, columns
        self.note = label("", "muted")
        form = QFormLayout()
        form.addRow("&Column:", columns)
        columns.currentIndexChanged.connect(self._tell)
        self.lay_out(form, self.note, None, size=(420, 150))
        self._tell()

    def _tell(self) -> None:
        count = self._filled(self.column.currentData())
        self.note.setText(
            f"It has a value for {counted(count, 'recording')}. Undo brings them back."
            if count
            else "It is empty."
        )

    def _remove(self) -> None:
        if self.attempt(lambda: self._do(self.column.currentData(), "")):
            self.accept()
