"""The history of a project: every edit in words; a click goes there."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, Qt, Signal, Slot
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QTreeView,
    QVBoxLayout,
    QWidget,
)

from .history_model import Fetch, HistoryModel

_NOTHING = "The edits of a project are listed here; a click on one goes back or forward to it."


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
