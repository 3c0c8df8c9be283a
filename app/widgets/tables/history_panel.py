"""The history of a project: every edit in words; a click goes there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from typing import Any, TypeAlias

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    QSize,
    Qt,
    Signal,
    Slot,
)
from PySide6.QtGui import QColor, QFont, QFontMetrics
from PySide6.QtWidgets import (
    QAbstractItemView,
    QApplication,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QTreeView,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.project.history import Entry, How

from ..style.theme import current_theme

_NOTHING = "The edits of the project appear here. Click one to go back or forward to it."


class HistoryPanel(QWidget):
    """Edits, newest first, with who made them and when.

    Signals
    -------
    jump_requested : int
        The edit of this number shall be the last one in effect; 0: none.
    stop_requested : ()
    """

    jump_requested = Signal(int)
    stop_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.model = HistoryModel()
        self.tree = QTreeView()
        self.tree.setModel(self.model)
        self.tree.setRootIsDecorated(False)
        self.tree.setUniformRowHeights(True)
        self.tree.setAllColumnsShowFocus(True)
        self.tree.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.tree.setAccessibleName("History")
        header = self.tree.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        metrics = self.fontMetrics()
        for column, widest in ((1, "annota"), (2, "00:00:00")):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Interactive)
            header.resizeSection(column, metrics.horizontalAdvance(widest) + 18)
        self._none = QLabel(_NOTHING)
        self._none.setProperty("role", "muted")
        self._none.setWordWrap(True)
        self._none.setContentsMargins(10, 10, 10, 10)
        self._none.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.going = QWidget()
        self._going_words = QLabel()
        self.stop_button = QPushButton("Stop here")
        self.stop_button.clicked.connect(self.stop_requested)
        row = QHBoxLayout(self.going)
        row.setContentsMargins(8, 4, 8, 4)
        row.addWidget(self._going_words, 1)
        row.addWidget(self.stop_button)
        self.going.hide()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self._none, 1)
        layout.addWidget(self.going)
        layout.addWidget(self.tree, 1)
        self.tree.clicked.connect(self._on_chosen)
        self.tree.activated.connect(self._on_chosen)
        self._steps = 0
        self.show_edits(None)

    def show_edits(self, fetch: Fetch | None) -> None:
        """Show the edits of another project, or of none."""
        self.model.show(fetch)
        self._none.setVisible(fetch is None)
        self.tree.setVisible(fetch is not None)
        self.show_going(None)

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
        row, entry = index.row(), self.model.entry(index.row())
        if entry is None and not self.model.is_beginning(row):
            return
        if row == self.model.current_row() or not index.flags():
            return
        self._steps = self.model.steps_to(row)
        self.jump_requested.emit(0 if entry is None else entry.number)


Fetch: TypeAlias = Callable[[int, int | None], tuple[Entry, ...]]
"""From a number of edits and the number that they are older than to these edits, newest first."""

_PAGE = 200
_HEADINGS = ("Edit", "Annotator", "When")
_TIPS = {
    "done": "Applied. Click to undo everything after it.",
    "undone": "Undone. Click to redo it and everything before it.",
    "dropped": "Undone and followed by another edit. It cannot be redone.",
    "kept": "A stored run. Undo skips it; delete it in the Runs panel.",
}
_MOVED = {"done", "undone"}
_Index: TypeAlias = QModelIndex | QPersistentModelIndex
_NOWHERE = QModelIndex()


class HistoryModel(QAbstractTableModel):
    """Edits in words, who made them and when; the last row is the state before all of them."""

    def __init__(self) -> None:
        super().__init__()
        self._fetch: Fetch | None = None
        self._rows: list[Entry] = []
        self._whole = True
        self._current = 0

    def show(self, fetch: Fetch | None) -> None:
        """Show another project's edits, or none."""
        self.beginResetModel()
        self._fetch = fetch
        self._rows = list(fetch(_PAGE, None)) if fetch is not None else []
        self._whole = len(self._rows) < _PAGE
        self._current = self._border()
        self.endResetModel()

    def entry(self, row: int) -> Entry | None:
        """The edit of a row; None for the state before all edits."""
        return self._rows[row] if 0 <= row < len(self._rows) else None

    def is_beginning(self, row: int) -> bool:
        """Whether a row stands for the state before all edits."""
        return self._fetch is not None and self._whole and row == len(self._rows)

    def current_row(self) -> int:
        """Row of the last edit in effect that undo would take back."""
        return self._current

    def steps_to(self, row: int) -> int:
        """How many edits have to be undone or redone to come to a row."""
        here = self.current_row()
        passed = self._rows[min(here, row) : max(here, row)]
        return sum(entry.state in _MOVED for entry in passed)

    def follow(self) -> None:
        """Take over an edit, an undo or a redo; what is loaded further down is not read again."""
        if self._fetch is None:
            return
        newest = self._fetch(1, None)
        if newest and (not self._rows or newest[0].number > self._rows[0].number):
            self._take_in(newest[0])
        elif newest and newest[0] != self._rows[0] and newest[0].state == "done":
            self._rows[0] = newest[0]
            self._tell(0, 0)
        self._state_again()

    def _take_in(self, newest: Entry) -> None:
        assert self._fetch is not None  # noqa: S101 - there is a newest edit
        known = self._rows[0].number if self._rows else 0
        found = self._fetch(newest.number - known + self._current, None)
        added = tuple(entry for entry in found if entry.number > known)
        states = [entry.state for entry in found[len(added) :]]
        for row, state in zip(range(len(self._rows)), states, strict=False):
            self._set_state(row, state)  # what was taken back may be given up now
        self.beginInsertRows(QModelIndex(), 0, len(added) - 1)
        self._rows[:0] = added
        self.endInsertRows()

    def _state_again(self) -> None:
        """Let the rows around the last edit in effect say what the project says."""
        assert self._fetch is not None  # noqa: S101 - asked by the caller
        while True:
            border = self._current = self._border()
            above = (row for row in range(border - 1, -1, -1) if self._rows[row].state == "undone")
            first = max(next(above, border) - 2, 0)
            before = self._rows[first - 1].number if first else None
            for row, entry in enumerate(self._fetch(border - first + 3, before), start=first):
                if row < len(self._rows) and entry.number == self._rows[row].number:
                    self._set_state(row, entry.state)
            if self._border() == border:
                return

    def _border(self) -> int:
        states = (row for row, entry in enumerate(self._rows) if entry.state == "done")
        return next(states, len(self._rows))

    def _set_state(self, row: int, state: How) -> None:
        if self._rows[row].state != state:
            self._rows[row] = replace(self._rows[row], state=state)
            self._tell(row, row)

    def _tell(self, first: int, last: int) -> None:
        self.dataChanged.emit(self.index(first, 0), self.index(last, len(_HEADINGS) - 1))

    # ---- Qt's questions

    def rowCount(self, parent: _Index = _NOWHERE) -> int:
        if parent.isValid() or self._fetch is None:
            return 0
        return len(self._rows) + int(self._whole)

    def columnCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(_HEADINGS)

    def canFetchMore(self, parent: _Index) -> bool:
        return not parent.isValid() and not self._whole

    def fetchMore(self, parent: _Index) -> None:
        if parent.isValid() or self._fetch is None:
            return
        older = self._fetch(_PAGE, self._rows[-1].number if self._rows else None)
        whole = len(older) < _PAGE
        if older or whole:
            first = len(self._rows)
            self.beginInsertRows(QModelIndex(), first, first + len(older) + int(whole) - 1)
            self._rows.extend(older)
            self._whole = whole
            self._current = self._border()
            self.endInsertRows()

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return _HEADINGS[section]
        return None

    def flags(self, index: _Index) -> Qt.ItemFlag:
        entry = self.entry(index.row())
        if entry is not None and entry.state not in _MOVED:
            return Qt.ItemFlag.NoItemFlags
        return Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role == Qt.ItemDataRole.SizeHintRole:
            return QSize(0, QFontMetrics(QApplication.font()).height() + 6)
        entry = self.entry(index.row())
        if entry is None:
            return self._beginning(index, role)
        if role == Qt.ItemDataRole.DisplayRole:
            return (entry.words, entry.who, when_in_words(entry.at))[index.column()]
        if role == Qt.ItemDataRole.ToolTipRole:
            local = datetime.fromisoformat(entry.at).astimezone()
            return f"{entry.words}\n{entry.who}, {local:%Y-%m-%d %H:%M:%S}\n{_TIPS[entry.state]}"
        if role == Qt.ItemDataRole.ForegroundRole and entry.state != "done":
            theme = current_theme()
            return QColor(theme.disabled if entry.state == "dropped" else theme.muted)
        if role == Qt.ItemDataRole.FontRole:
            font = QFont()
            font.setItalic(entry.state == "undone")
            font.setStrikeOut(entry.state == "dropped")
            font.setBold(index.row() == self.current_row())
            return font
        return None

    def _beginning(self, index: _Index, role: int) -> Any:
        if role == Qt.ItemDataRole.DisplayRole and index.column() == 0:
            return "before the first edit"
        if role == Qt.ItemDataRole.ForegroundRole:
            return QColor(current_theme().muted)
        return None


def when_in_words(at: str) -> str:
    """A stored time as a clock of this place shows it; its day where that is not today."""
    local = datetime.fromisoformat(at).astimezone()
    today = datetime.now().astimezone().date()
    return f"{local:%H:%M:%S}" if local.date() == today else f"{local:%d %b}"
