"""Studies in the window: their recordings, their settings, and the plot of their results."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QItemSelection, QItemSelectionModel, Qt
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLineEdit, QTabWidget, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.recording.selection import seeds_of
from stereotrack_core.study.description import Study
from stereotrack_core.study.status import COLUMNS, RowStatus

from ...context import Context
from ...session.changes import Part
from ...widgets.forms.form_dialog import ask_for_folder, line_edit, push_button, say_in
from ...widgets.style.building import allow, hbox, holder, label, scrolled, thin_progress, vbox
from ...widgets.tables.table import LEFT, RIGHT, STRETCH, Cell, CellTable, Column
from .pages import ResultsPanel, SettingsForm

_FACTOR_TIP = "A factor of the recordings, as the study file states it."
_HINT = "The selected recordings, or all if none is selected"
_EMPTY = "The study has no recordings yet. Add folders with recordings."
_UNKNOWN = float("-inf")  # value by which unknown cells are sorted: before all numbers


def _columns(factors: tuple[str, ...]) -> tuple[Column, ...]:
    known = (
        Column(one.label, one.help, align=LEFT if one.name == "views" else RIGHT) for one in COLUMNS
    )
    first = Column("recording", "Folder of the recording, relative to the study file.")
    told = "The gravest problem. Select the row to see all of them."
    last = Column("message", told, width=STRETCH)
    return (first, *(Column(one, _FACTOR_TIP) for one in factors), *known, last)


class StudyWindow(QDialog):
    """Shows the study that is open."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.docks.dialog_parent, Qt.WindowType.Window)
        self._context, self._state = context, context.session.study
        self.form = SettingsForm(self._take_panel)
        self.results = ResultsPanel(context)
        context.show(Part.SETTINGS | Part.JUDGEMENT, lambda _now: self._draw_results())
        self.study, self.rows = Study(Path()), tuple[RowStatus, ...]()
        self.count, self.words = label("", "muted"), label("")
        self.progress = thin_progress()
        self.progress.setMaximum(1000)
        self.tabs = QTabWidget()
        self.tabs.addTab(self._recordings(), "Recordings")
        self.tabs.addTab(self.form, "Settings")
        self.tabs.addTab(self.results, "Results")
        self.tabs.currentChanged.connect(self._follow_table)
        self.form.changed.connect(self._count)
        parts = ((self.tabs, 1), self.count, self.words, self.progress, self._buttons())
        self.setLayout(vbox(*parts, margins=(9, 9, 9, 9)))
        self.resize(1180, 640)

    def _recordings(self) -> QWidget:
        self.view = CellTable("Recordings of the study", (), self._cells, sorts=True, least=200)
        self.model, self.proxy = self.view.cells, self.view.sorted
        self.proxy.setFilterKeyColumn(-1)
        self.proxy.setFilterCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.view.header().setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        self.view.header().setSortIndicatorClearable(True)
        self.view.selectionModel().selectionChanged.connect(self._show_messages)
        self.filter: QLineEdit = line_edit("Filter", "", "Filter: words that a row shows")
        self.filter.setClearButtonEnabled(True)
        self.filter.textChanged.connect(self.proxy.setFilterFixedString)
        self.empty = label(_EMPTY, "muted")
        self.messages = label(align=Qt.AlignmentFlag.AlignTop, copied=True)
        told = scrolled(self.messages, "Messages about the selected recording")
        told.setMaximumHeight(5 * self.fontMetrics().lineSpacing())
        self.add_button = push_button("&Add …", self._ask_for_folders)
        remove = self._state.remove
        self.remove_button = push_button("Re&move", lambda: remove(self._names(self.selected())))
        top = hbox(self.add_button, self.remove_button, (self.filter, 1), spacing=9)
        return holder(vbox(top, (self.view, 1), (self.empty, 1), told, margins=(6, 6, 6, 6)))

    def _buttons(self) -> QHBoxLayout:
        self.open_button = push_button("&Open", self._open)
        self.track_button = push_button("&Track", self._track)
        self.refresh_button = push_button("Re&fresh", self._state.refresh)
        self.stop_button = push_button("&Stop", self._state.stop)
        buttons = (self.refresh_button, self.stop_button)
        return hbox(self.open_button, self.track_button, None, *buttons)

    def show_study(self, study: Study) -> None:
        state, before = self._state, self.study
        if (study, state.rows) != (before, self.rows):
            other, selected = study.path != before.path, self._names(self.selected())
            self.study, self.rows = study, state.rows
            self.setWindowTitle(f"Study {study.stem}")
            self.view.show_rows(self.rows, _columns(study.factors))
            self.view.setVisible(bool(self.rows))
            self.empty.setVisible(not self.rows)
            if other or study.settings != before.settings:
                self.form.show_settings(study.settings)
            self.select(() if other else selected)
            for k, one in enumerate(COLUMNS, start=1 + len(study.factors)):
                self.view.setColumnHidden(k, all(one.value(row) is None for row in self.rows))
            self._count()
        say_in(self.words, state.said, error=state.is_error)
        self.progress.setValue(round(1000 * state.share))
        self._show_working(state.doing)
        self._follow_table()

    def _show_working(self, what: str) -> None:
        """Disable what cannot be done during work; `what` names it, empty if nothing is done."""
        self.progress.setVisible(bool(what))
        why_not = f"{what}. Wait, or stop it.".capitalize() if what else ""
        idle = "" if what else "Nothing is being done."
        allow(self.stop_button, idle, "Stop; what is finished is kept")
        allow(self.track_button, why_not, f"{_HINT}: track them with the settings")
        allow(self.refresh_button, why_not, "Read the study and its recordings again")
        allow(self.add_button, why_not, "Add the recordings in and below a folder")
        self.form.setEnabled(not what)

    def _cells(self, row: RowStatus) -> list[Cell]:
        unread, messages = row.frames is None and not row.findings, row.messages
        told = messages[0] if messages else "not read yet" if unread else ""
        values = [one.value(row) for one in COLUMNS]
        return [
            Cell(row.row.recording, colour="" if row.frames is not None or unread else "error"),
            *(Cell(row.row.cell(name)) for name in self.study.factors),
            *(
                Cell(one.text(row), value=_UNKNOWN if value is None else value)
                for one, value in zip(COLUMNS, values, strict=True)
            ),
            Cell(told, "\n".join(messages), "muted" if unread else ""),
        ]

    def _count(self) -> None:
        try:
            settings = self.form.settings()
            points = len(settings.all_points())
        except InputError as error:
            say_in(self.count, str(error), error=True)
            return
        seeds = len(seeds_of(settings.seeds))
        runs = points * seeds * len(self.rows)
        parts = (counted(points, "point"), counted(len(self.rows), "recording"))
        say_in(self.count, f"{counted(runs, 'run')}: {', '.join(parts)}, {counted(seeds, 'seed')}.")

    def _draw_results(self) -> None:
        if self.results.isVisible():
            self.results.draw()

    def _follow_table(self) -> None:
        self.results.follow(self.study.table)

    def _show_messages(self) -> None:
        rows = self.selected()
        single = "" if len(rows) == 1 else "Select one recording first."
        some = "" if rows else "Select recordings first."
        allow(self.open_button, single, "Open the recording in the workbench")
        allow(self.remove_button, some, "Remove from the study; no file is deleted")
        if len(rows) != 1:
            self.messages.setText("Select one recording to see its messages." if self.rows else "")
        else:
            self.messages.setText("\n".join(rows[0].messages) or "No problems are known.")

    def _take_panel(self) -> None:
        settings = self._state.panel_settings(self.form.settings())
        self._state.edit(lambda study: replace(study, settings=settings))

    def _track(self) -> None:
        try:
            settings = self.form.settings()
        except InputError as error:
            say_in(self.words, str(error), error=True)
        else:
            self._state.track(self.chosen(), settings, self.form.processes.value())

    def _open(self) -> None:
        rows = self.selected()
        if rows:
            row = rows[0].row
            self._context.session.open(self.study.place(row.project or row.recording))
            self._context.docks.dialog_parent.window().raise_()

    def _ask_for_folders(self) -> None:
        title, add = "Add the recordings in and below a folder", self._state.add
        ask_for_folder(self, title, self.study.folder, lambda path: add((path,), self.select))

    @staticmethod
    def _names(rows: Iterable[RowStatus]) -> tuple[str, ...]:
        return tuple(row.row.recording for row in rows)

    def selected(self) -> list[RowStatus]:
        return [self.rows[k] for k in self.view.selected()]

    def chosen(self) -> tuple[str, ...]:
        shown = range(self.proxy.rowCount())
        places = (self.proxy.mapToSource(self.proxy.index(k, 0)).row() for k in shown)
        rows = self.selected() or [self.rows[k] for k in places]
        return self._names(rows)

    def select(self, recordings: Iterable[str]) -> None:
        wanted, selection = set(recordings), QItemSelection()
        for k, row in enumerate(self.rows):
            if row.row.recording in wanted:
                index = self.proxy.mapFromSource(self.model.index(k, 0))
                selection.select(index, index)
        flags = QItemSelectionModel.SelectionFlag
        self.view.selectionModel().select(selection, flags.ClearAndSelect | flags.Rows)
        self._show_messages()
