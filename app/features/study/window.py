"""The table of a study, with what can be done with the recordings that are selected."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from PySide6.QtCore import QEvent, QPoint, Qt, Signal, Slot
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QHeaderView,
    QLineEdit,
    QMenu,
    QPushButton,
    QToolButton,
    QWidget,
)

from stereotrack_core.counting import counted
from stereotrack_core.project.whereabouts import SUFFIX as PROJECT_SUFFIX
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.study.file import Study
from stereotrack_core.study.shown import COLUMNS, messages_of
from stereotrack_core.study.status import RowStatus

from ...services.actions import ActionRegistry
from ...widgets.forms.form_dialog import line_edit, push_button, say_in
from ...widgets.style.building import (
    action_button,
    hbox,
    label,
    scrolled,
    thin_progress,
    tool_button,
    vbox,
)
from ...widgets.tables.table import selected_rows
from .rows import Order, arranged, columns_of, statuses
from .table import StudyTable

_HINT = "The selected recordings, or all that are shown if none is selected"
_NONE = "The study has no recordings yet. Add some first."
_EMPTY = (
    "This study has no recordings yet. Add folders with recordings or project files, or drag them "
    "here from a file manager."
)
_ROW_MENU = (
    *("study_edit_cell", "study_set_value", "study_fill", "", "study_remove", ""),
    *("study_undo", "study_redo"),
)
_COLUMN_MENU = ("study_add_column", "study_rename_column", "study_remove_column")


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
    selection_changed = Signal()
    cell_edited = Signal(object, str, str)
    """Tuple of the names of recordings, a factor, and its value in all of them."""
    dropped = Signal(object)
    """Tuple of folders and project files."""
    came_back = Signal()
    """A person has come back from another window."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent, Qt.WindowType.Window)
        self.study = Study(Path())
        self.rows: list[RowStatus] = []
        self._known: dict[str, RowStatus] = {}
        self._order = Order()
        self._kept: set[str] = set()
        self._reading = self._tracking = False
        self.setAcceptDrops(True)
        self._make_table()
        self.filter: QLineEdit = line_edit(
            "Filter", "", "Filter: words, or column=value such as condition=slow"
        )
        self.filter.setClearButtonEnabled(True)
        self.filter.textChanged.connect(self._arrange)
        self.count, self.messages = label("", "muted", wraps=False), label("")
        self.messages.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.messages.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.progress, self.words, self.said = thin_progress(), label("", "muted"), label("")
        self.progress.setMaximum(1000)
        self.empty = label(_EMPTY, "muted", margins=(10, 10, 10, 10))
        self.empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        told = scrolled(self.messages, "Messages about the selected recording")
        told.setMaximumHeight(5 * self.fontMetrics().lineSpacing())
        self.tools = hbox(spacing=2)
        top = hbox(self.tools, (self.filter, 1), self.count, spacing=9)
        self.setLayout(
            vbox(
                top, (self.view, 1), (self.empty, 1), told, self.said, self.progress, self.words,
                self._buttons(), margins=(9, 9, 9, 9),
            )
        )  # fmt: skip
        self.resize(1180, 640)
        self.say("")
        self.show_work(None)

    def _make_table(self) -> None:
        self.view = StudyTable()
        self.model = self.view.rows
        self.view.activated.connect(self._open)
        self.view.selected.connect(self._on_selected)
        self.view.written.connect(self.cell_edited)
        self.view.wide.connect(self._on_editor)
        self.view.closed.connect(self._arrange)
        header = self.view.horizontalHeader()
        header.setSectionsClickable(True)
        header.setSortIndicatorShown(True)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        header.setSortIndicatorClearable(True)
        header.sortIndicatorChanged.connect(self._sort)
        for area in (self.view, header):
            area.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.view.customContextMenuRequested.connect(self._show_row_menu)
        header.customContextMenuRequested.connect(self._show_column_menu)

    def _buttons(self) -> QHBoxLayout:
        self.open_button = push_button("&Open", self._open)
        self.track_button = push_button("&Track …", lambda: self.track_wanted.emit(self.chosen()))
        self.pages_button = push_button("&Report", lambda: self.pages_wanted.emit(self.chosen()))
        self.export_button = push_button(
            "&Export table …", lambda: self.export_wanted.emit(self.chosen())
        )
        self.refresh_button = push_button("Re&fresh", self.refresh_wanted.emit)
        self.stop_button = push_button("&Stop", self.stop_wanted.emit)
        row = hbox(self.open_button, self.track_button, self.pages_button, self.export_button)
        row.addStretch(1)
        row.addWidget(self.refresh_button)
        row.addWidget(self.stop_button)
        return row

    def offer(self, actions: ActionRegistry) -> None:
        """Show the edits of the study above the table and in its menus."""
        self._row_menu, self._column_menu = QMenu(self), QMenu(self)
        for menu, names in ((self._row_menu, _ROW_MENU), (self._column_menu, _COLUMN_MENU)):
            menu.setToolTipsVisible(True)
            for name in names:
                _ = menu.addAction(actions.action(name)) if name else menu.addSeparator()
        add = QMenu(self)
        add.setToolTipsVisible(True)
        add.addActions([actions.action(f"study_add_{name}") for name in ("folders", "projects")])
        for text, icon, tip, menu in (
            ("Add ▾", "add", "Add recordings: folders or project files", add),
            ("Columns ▾", "table", "Add, rename or remove columns", self._column_menu),
        ):
            button = tool_button(tip, icon, text, role="plain")
            button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
            button.setMenu(menu)
            self.tools.addWidget(button)
        style = Qt.ToolButtonStyle
        for name, shown in (
            ("study_set_value", style.ToolButtonTextOnly),
            ("study_remove", style.ToolButtonTextBesideIcon),
            ("study_undo", style.ToolButtonIconOnly),
            ("study_redo", style.ToolButtonIconOnly),
        ):
            button = action_button(actions.action(name))
            button.setToolButtonStyle(shown)
            self.tools.addWidget(button)

    # ---- what is shown

    def show_study(self, study: Study, rows: Iterable[RowStatus]) -> None:
        """Show a study from the beginning."""
        self._known = {row.row.recording: row for row in rows}
        self._order, self._kept = Order(), set()
        self.setWindowTitle(f"Study {study.stem}")
        self.say("")
        self.model.show([], ())
        self.show_edited(study)

    def show_edited(self, study: Study) -> None:
        """Show another state of the study: what is known of its recordings stays."""
        same_columns = study.factors == self.study.factors and bool(self.model.columns)
        more_rows = len(study.rows) > len(self.study.rows)
        if not same_columns:
            self._follow_order(study)
        self.study = self.model.study = study
        self.rows = statuses(study, self._known)
        self.view.setVisible(bool(study.rows))
        self.empty.setVisible(not study.rows)
        if same_columns:
            self._arrange()
        else:
            column = self.view.currentIndex().column()
            self.model.show([], columns_of(study))
            self._arrange()
            self.view.put_cursor(column)
        if more_rows or not same_columns:
            self._fit_columns()
        self._hide_unknown()
        self._allow()

    def _follow_order(self, study: Study) -> None:
        """Let rows stay sorted by the same column, where it is still there."""
        headings = [column.heading for column in columns_of(study)]
        column = self._order.column
        heading = (
            self.model.columns[column].heading if 0 <= column < len(self.model.columns) else ""
        )
        self._order = Order(
            headings.index(heading) if heading in headings else -1, self._order.ascending
        )
        header = self.view.horizontalHeader()
        before = header.blockSignals(True)
        ways = Qt.SortOrder
        header.setSortIndicator(
            self._order.column,
            ways.AscendingOrder if self._order.ascending else ways.DescendingOrder,
        )
        header.blockSignals(before)

    def _fit_columns(self) -> None:
        self.view.resizeColumnsToContents()
        header = self.view.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setStretchLastSection(True)

    def take(self, news: Iterable[RowStatus]) -> None:
        """Show what is now known of some rows."""
        self._known |= {row.row.recording: row for row in news}
        rows = statuses(self.study, self._known)
        if rows != self.rows:
            self.rows = rows
            self._arrange()
            self._hide_unknown()

    def _hide_unknown(self) -> None:
        """Hide columns that say nothing about any recording."""
        first = 1 + len(self.study.factors)
        for k, one in enumerate(COLUMNS, start=first):
            self.view.setColumnHidden(k, all(one.value(row) is None for row in self.rows))

    def say(self, words: str, *, error: bool = False) -> None:
        """Say what an edit has done, or why it could not be made."""
        say_in(self.said, words, error=error)

    def show_work(self, words: str | None, share: float = 0.0, *, error: bool = False) -> None:
        """Say what is being done, or how it ended; None where nothing is being done."""
        self.progress.setVisible(words is not None and not error and share < 1.0)
        self.progress.setValue(round(1000 * share))
        say_in(self.words, words or "", error=error)

    def show_working(self, *, reading: bool, tracking: bool) -> None:
        """What can be asked for while something is being done."""
        self._reading, self._tracking = reading, tracking
        self._allow()

    def _allow(self) -> None:
        """Enable buttons, or say on them why not."""
        rows, none = self.selected(), "" if self.rows else _NONE
        reading = "The study is being read or written. Wait, or stop it." if self._reading else ""
        going = "Recordings are being tracked. Wait, or stop it." if self._tracking else ""
        single = "" if len(rows) == 1 else "Select one recording first."
        if not single and rows[0].place.folder is None:
            single = "The recording was not found. Its message says what to do."
        idle = "" if self._reading or self._tracking else "Nothing is being read or tracked."
        _allow(self.open_button, single, "Open the recording with its project  [Enter]")
        _allow(self.track_button, going or none, f"{_HINT}: track them")
        _allow(self.pages_button, reading or none,
               f"{_HINT}: write a page about the newest run of each")  # fmt: skip
        _allow(self.export_button, reading or none, f"{_HINT}: write all results as one table")
        _allow(self.refresh_button, reading, "Read what has changed, and evaluate new runs")
        _allow(self.stop_button, idle, "Stop reading or tracking; what is finished is kept")

    # ---- what is selected

    def selected(self) -> list[RowStatus]:
        """Rows that are selected."""
        return self.view.selected_statuses()

    def chosen(self) -> tuple[str, ...]:
        """Recordings that are selected, or all that are shown."""
        return tuple(row.row.recording for row in self.selected() or self.model.rows)

    def select(self, recordings: Iterable[str]) -> None:
        """Select these, let the first be seen, and keys be for them."""
        self._kept = set(recordings)
        self._arrange()
        rows = selected_rows(self.view)
        if rows:
            self.view.scrollTo(self.model.index(rows[0], 0))
            self.view.setFocus()
        self.selection_changed.emit()

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
        shown = arranged(self.study, self.rows, self.filter.text(), self._order)
        self.view.show_rows(shown, self._kept)
        total = counted(len(self.rows), "recording")
        self.count.setText(total if len(shown) == len(self.rows) else f"{len(shown)} of {total}")
        self._show_messages()

    @Slot()
    def _on_selected(self) -> None:
        """Remember what a person has selected, also while a filter hides it."""
        self._kept = {row.row.recording for row in self.selected()}
        self._show_messages()
        self.selection_changed.emit()

    def _show_messages(self) -> None:
        """Tell all that is wrong with the row that is selected."""
        rows = self.selected()
        self._allow()
        if len(rows) != 1:
            self.messages.setText("Select one recording to see its messages." if self.rows else "")
            return
        told = messages_of(rows[0])
        self.messages.setText("\n".join(told) or "No problems are known.")

    # ---- editing

    @Slot(int)
    def _on_editor(self, count: int) -> None:
        wide = f"What you write goes into the {count} selected recordings."
        self.say(wide if count > 1 else "")

    @Slot(QPoint)
    def _show_row_menu(self, place: QPoint) -> None:
        self._row_menu.popup(self.view.viewport().mapToGlobal(place))

    @Slot(QPoint)
    def _show_column_menu(self, place: QPoint) -> None:
        header = self.view.horizontalHeader()
        self.view.put_cursor(header.logicalIndexAt(place))
        self._column_menu.popup(header.viewport().mapToGlobal(place))

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.ActivationChange and self.isActiveWindow():
            self.came_back.emit()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if _dropped(event):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        paths = _dropped(event)
        if paths:
            event.acceptProposedAction()
            self.dropped.emit(paths)


def _dropped(event: QDropEvent) -> tuple[Path, ...]:
    """Folders, projects and descriptions of recordings that are dragged here."""
    paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
    return tuple(
        path
        for path in paths
        if path.is_dir() or path.name.endswith(PROJECT_SUFFIX) or path.name == DESCRIPTION
    )


def _allow(button: QPushButton, why_not: str, tip: str) -> None:
    button.setEnabled(not why_not)
    button.setToolTip(f"{tip}. Unavailable: {why_not}" if why_not else tip)
    button.setStatusTip(button.toolTip())
