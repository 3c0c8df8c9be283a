"""The history: every edit of the project in words; a click goes there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime
from typing import TypeAlias

from PySide6.QtCore import QModelIndex, Qt, Signal, Slot
from PySide6.QtWidgets import QPushButton, QTreeView, QWidget

from stereotrack_core.project.history import Entry

from ..style.building import empty_label, hbox, label, vbox
from .table import Cell, Column, Index, RowDelegate, TableModel, dress_list


class HistoryPanel(QWidget):
    """Edits, newest first, with who made them and when."""

    jump_requested = Signal(object)
    """This edit shall be the last one in effect; None: none."""
    stop_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.model = HistoryModel()
        self.tree = QTreeView()
        self.tree.setModel(self.model)
        self.tree.setItemDelegate(RowDelegate(self.tree))
        width = self.fontMetrics().horizontalAdvance
        dress_list(self.tree, "History", (None, width("annota") + 18, width("00:00:00") + 18))
        self._none = empty_label("What you do appears here. Click one to go back or forward to it.")
        self.going = QWidget()
        self._going_words = label(wraps=False)
        self.stop_button = QPushButton("Stop here")
        self.stop_button.clicked.connect(self.stop_requested)
        self.going.setLayout(hbox((self._going_words, 1), self.stop_button, margins=(8, 4, 8, 4)))
        self.going.hide()
        self.setLayout(vbox((self._none, 1), self.going, (self.tree, 1), spacing=0))
        self.tree.clicked.connect(self._on_chosen)
        self.tree.activated.connect(self._on_chosen)
        self._steps = 0
        self.show_edits(None)

    def show_edits(self, fetch: Fetch | None) -> None:
        """Show the edits of another project, or of none."""
        self.model.open(fetch)
        self._none.setVisible(fetch is None)
        self.tree.setVisible(fetch is not None)
        self.show_going(None)

    @Slot()
    def follow(self) -> None:
        """Take over an edit that was made, undone or redone."""
        at_the_top = self.tree.verticalScrollBar().value() == 0
        self.model.follow()
        if at_the_top:
            self.tree.scrollToTop()

    def show_going(self, count: int | None) -> None:
        """Say that so many edits were undone or redone on the way; None: there is no way to go."""
        self.going.setVisible(count is not None)
        if count is not None:
            self._going_words.setText(f"{count} of {self._steps} edits …")

    @Slot(QModelIndex)
    def _on_chosen(self, index: QModelIndex) -> None:
        row, entry = index.row(), self.model.rows[index.row()]
        if row != self.model.current and index.flags():
            self._steps = self.model.steps_to(row)
            self.jump_requested.emit(entry)


Fetch: TypeAlias = Callable[[int, int | None], tuple[Entry, ...]]
"""From a number of edits and the number that they are older than to these edits, newest first."""

_PAGE = 200
_TIPS = {
    "done": "Applied. Click to undo everything after it.",
    "undone": "Undone. Click to redo it and everything before it.",
    "dropped": "Undone and followed by another edit. It cannot be redone.",
}
_COLOURS = {"undone": "muted", "dropped": "disabled"}
_MOVED = {"done", "undone"}


class HistoryModel(TableModel[Entry | None]):
    """Edits, of which older ones are fetched as they come into view; None: before all of them."""

    def __init__(self) -> None:
        super().__init__([Column("Edit"), Column("Annotator"), Column("When")], self._look)
        self._fetch: Fetch | None = None
        self._edits: list[Entry] = []
        self._whole = True
        self.current = 0
        """Row of the last edit in effect that undo would take back."""

    def open(self, fetch: Fetch | None) -> None:
        """Show another project's edits, or none."""
        self.beginResetModel()
        self._fetch = fetch
        self._edits = list(fetch(_PAGE, None)) if fetch is not None else []
        self._whole = len(self._edits) < _PAGE
        self._list()
        self.endResetModel()

    def steps_to(self, row: int) -> int:
        """How many edits have to be undone or redone to come to a row."""
        passed = self._edits[min(self.current, row) : max(self.current, row)]
        return sum(entry.state in _MOVED for entry in passed)

    def follow(self) -> None:
        """Take over an edit, an undo or a redo, by reading again what is loaded."""
        if self._fetch is None:
            return
        newest, known = self._fetch(1, None), self._edits[0].number if self._edits else 0
        new = max(newest[0].number - known, 0) if newest else 0
        found = self._fetch(len(self._edits) + new, None)
        added = len(found) - len(self._edits)
        if added > 0:
            self.beginInsertRows(QModelIndex(), 0, added - 1)
        self._edits = list(found)
        self._list()
        if added > 0:
            self.endInsertRows()
        self.tell(0, len(self.rows) - 1)

    def _list(self) -> None:
        """Let the rows be the edits, with the state before all of them where they are complete."""
        beginning = [None] if self._whole and self._fetch is not None else []
        self.rows = [*self._edits, *beginning]
        states = (row for row, entry in enumerate(self._edits) if entry.state == "done")
        self.current = next(states, len(self._edits))
        self.forget()

    # ---- Qt's questions

    def canFetchMore(self, parent: Index) -> bool:
        return not parent.isValid() and not self._whole

    def fetchMore(self, parent: Index) -> None:
        if parent.isValid() or self._fetch is None:
            return
        older = self._fetch(_PAGE, self._edits[-1].number if self._edits else None)
        whole = len(older) < _PAGE
        if older or whole:
            first = len(self._edits)
            self.beginInsertRows(QModelIndex(), first, first + len(older) + int(whole) - 1)
            self._edits.extend(older)
            self._whole = whole
            self._list()
            self.endInsertRows()

    def flags(self, index: Index) -> Qt.ItemFlag:
        entry = self.rows[index.row()]
        fixed = entry is not None and entry.state not in _MOVED
        return Qt.ItemFlag.NoItemFlags if fixed else super().flags(index)

    def _look(self, entry: Entry | None) -> Sequence[Cell]:
        if entry is None:
            return (Cell("before the first edit", colour="muted"), Cell(), Cell())
        local = datetime.fromisoformat(entry.at).astimezone()
        tip = f"{entry.words}\n{entry.who}, {local:%Y-%m-%d %H:%M:%S}\n{_TIPS[entry.state]}"
        today = datetime.now().astimezone().date()
        when = f"{local:%H:%M:%S}" if local.date() == today else f"{local:%d %b}"
        look = Cell(
            tip=tip,
            colour=_COLOURS.get(entry.state, ""),
            bold=entry.state == "done" and entry is self.rows[self.current],
            italic=entry.state == "undone",
            struck=entry.state == "dropped",
        )
        return tuple(replace(look, text=text) for text in (entry.words, entry.who, when))
