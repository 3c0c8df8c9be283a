"""The table of a study, with what can be done with the recordings that are selected."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from PySide6.QtCore import QItemSelection, QItemSelectionModel, Qt, Signal, Slot
from PySide6.QtWidgets import QDialog, QHBoxLayout, QHeaderView, QLineEdit, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.study.file import Study
from stereotrack_core.study.shown import COLUMNS, messages_of
from stereotrack_core.study.status import RowStatus

from ...widgets.forms.form_dialog import line_edit, push_button, say_in
from ...widgets.style.building import hbox, label, scrolled, thin_progress, vbox
from ...widgets.tables.table import TableModel, new_table, selected_rows
from .rows import Order, arranged, cells_of, columns_of, replaced

_HINT = "The selected recordings, or all that are shown if none is selected"


class StudyWindow(QDialog):
    """Shows one study; says by signals what a person wants."""

    open_wanted = Signal(object)
    """RowStatus: to be opened in the workbench."""
    track_wanted = Signal(object)
    pages_wanted = Signal(object)
    export_wanted = Signal(object)
    """Tuple of the names of recordings."""
    refresh_wanted = Signal()
    stop_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent, Qt.WindowType.Window)
        self.study = Study(Path())
        self.rows: list[RowStatus] = []
        self._order = Order()
        self._kept: set[str] = set()
        self._arranging = False
        self.model: TableModel[RowStatus] = TableModel(cells=lambda row: cells_of(self.study, row))
        self.view = new_table(self.model, "Recordings of the study")
        self.view.activated.connect(self._open)
        header = self.view.horizontalHeader()
        header.setSectionsClickable(True)
        header.setSortIndicatorShown(True)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        header.setSortIndicatorClearable(True)
        header.sortIndicatorChanged.connect(self._sort)
        self.view.selectionModel().selectionChanged.connect(self._on_selected)
        self.filter: QLineEdit = line_edit(
            "Filter", "", "Filter: words, or column=value such as condition=slow"
        )
        self.filter.setClearButtonEnabled(True)
        self.filter.textChanged.connect(self._arrange)
        self.count, self.messages = label("", "muted"), label("")
        self.messages.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.messages.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.progress, self.words = thin_progress(), label("", "muted")
        self.progress.setMaximum(1000)
        told = scrolled(self.messages, "Messages about the selected recording")
        told.setMaximumHeight(5 * self.fontMetrics().lineSpacing())
        top = hbox((self.filter, 1), self.count)
        self.setLayout(
            vbox(
                top, (self.view, 1), told, self.progress, self.words, self._buttons(),
                margins=(9, 9, 9, 9),
            )
        )  # fmt: skip
        self.resize(1180, 640)
        self.show_work(None)

    def _buttons(self) -> QHBoxLayout:
        self.open_button = push_button("&Open", self._open, "Open the recording with its project")
        self.track_button = push_button(
            "&Track …", lambda: self.track_wanted.emit(self.chosen()), f"{_HINT}: track them"
        )
        self.pages_button = push_button(
            "&Report", lambda: self.pages_wanted.emit(self.chosen()),
            f"{_HINT}: write a page about the newest run of each",
        )  # fmt: skip
        self.export_button = push_button(
            "&Export table …", lambda: self.export_wanted.emit(self.chosen()),
            f"{_HINT}: write all their results as one table",
        )  # fmt: skip
        self.refresh_button = push_button(
            "Re&fresh", self.refresh_wanted.emit, "Read what has changed, and evaluate new runs"
        )
        self.stop_button = push_button("&Stop", self.stop_wanted.emit)
        row = hbox(self.open_button, self.track_button, self.pages_button, self.export_button)
        row.addStretch(1)
        row.addWidget(self.refresh_button)
        row.addWidget(self.stop_button)
        return row

    def show_study(self, study: Study, rows: Iterable[RowStatus]) -> None:
        """Show a study from the beginning."""
        self.study, self.rows = study, list(rows)
        self._order, self._kept = Order(), set()
        self.setWindowTitle(f"Study {study.stem}")
        self.model.show([], columns_of(study))
        self._arrange()
        self._hide_unknown()
        self.view.resizeColumnsToContents()
        header = self.view.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setStretchLastSection(True)

    def take(self, news: Iterable[RowStatus]) -> None:
        """Show what is now known of some rows."""
        rows = replaced(self.rows, news)
        if rows != self.rows:
            self.rows = rows
            self._arrange()
            self._hide_unknown()

    def _hide_unknown(self) -> None:
        """Hide columns that say nothing about any recording."""
        first = 1 + len(self.study.factors)
        for k, one in enumerate(COLUMNS, start=first):
            self.view.setColumnHidden(k, all(one.value(row) is None for row in self.rows))

    def show_work(self, words: str | None, share: float = 0.0, *, error: bool = False) -> None:
        """Say what is being done, or how it ended; None where nothing is being done."""
        self.progress.setVisible(words is not None and not error and share < 1.0)
        self.progress.setValue(round(1000 * share))
        say_in(self.words, words or "", error=error)

    def show_working(self, *, reading: bool, tracking: bool) -> None:
        """What can be asked for while something is being done."""
        self.stop_button.setEnabled(reading or tracking)
        self.track_button.setEnabled(not tracking)
        for button in (self.refresh_button, self.pages_button, self.export_button):
            button.setEnabled(not reading)

    def selected(self) -> list[RowStatus]:
        """Rows that are selected."""
        return [self.model.rows[k] for k in selected_rows(self.view)]

    def chosen(self) -> tuple[str, ...]:
        """Recordings that are selected, or all that are shown."""
        return tuple(row.row.recording for row in self.selected() or self.model.rows)

    @Slot()
    def _open(self) -> None:
        rows = self.selected()
        if rows:
            self.open_wanted.emit(rows[0])

    @Slot(int, Qt.SortOrder)
    def _sort(self, column: int, order: Qt.SortOrder) -> None:
        self._order = Order(column, order == Qt.SortOrder.AscendingOrder)
        self._arrange()

    @Slot()
    def _arrange(self) -> None:
        """Show the rows that the filter lets through; the same recordings stay selected."""
        self._arranging = True
        shown = arranged(self.study, self.rows, self.filter.text(), self._order)
        self.model.show(shown)
        selection = QItemSelection()
        for k, row in enumerate(shown):
            if row.row.recording in self._kept:
                selection.select(self.model.index(k, 0), self.model.index(k, 0))
        flags = QItemSelectionModel.SelectionFlag
        self.view.selectionModel().select(selection, flags.ClearAndSelect | flags.Rows)
        self._arranging = False
        total = counted(len(self.rows), "recording")
        self.count.setText(total if len(shown) == len(self.rows) else f"{len(shown)} of {total}")
        self._show_messages()

    @Slot()
    def _on_selected(self) -> None:
        """Remember what a person has selected, also while a filter hides it."""
        if not self._arranging:
            self._kept = {row.row.recording for row in self.selected()}
            self._show_messages()

    def _show_messages(self) -> None:
        """Tell all that is wrong with the row that is selected."""
        rows = self.selected()
        self.open_button.setEnabled(len(rows) == 1 and rows[0].place.folder is not None)
        if len(rows) != 1:
            self.messages.setText("Select a recording to see its messages.")
            return
        told = messages_of(rows[0])
        self.messages.setText("\n".join(told) or "No problems are known.")
