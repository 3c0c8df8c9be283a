"""What came of a sweep: plots of any table that a sweep has written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PySide6.QtCore import QTimer, Signal, Slot
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QWidget,
)

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.measures import measure_named
from stereotrack_core.experiments.sweep.points import SPECIAL
from stereotrack_core.experiments.sweep.table import (
    SweepTable,
    axis_of,
    curves_of,
    draw_curves,
    draw_heat,
    heat_of,
    table_of_cells,
    words_of,
)
from stereotrack_core.tables import read_csv_table

from ...widgets.forms.form_dialog import ask_to_open, push_button
from ...widgets.plots.sweep_plot import SweepPlot
from ...widgets.style.building import choice, hbox, label, vbox

_LOOK_MS = 1000
_MOST_COLOURS = 8
_FAVOURITES = ("forearms", "unexplained_fraction", "keypoint_error")
_TOLD = (
    "torso_position",
    "upper_arms",
    "forearms",
    "lost",
    "unexplained_fraction",
    "keypoint_error",
    "frames_per_second",
)


class SweepResults(QDialog):
    """Plots a table; a click on a point shows its values, which can be taken over."""

    taken_over = Signal(object)
    """dict: values by name, as text, that the person wants in the parameter panel."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Sweep results")
        self.table: SweepTable | None = None
        self.path: Path | None = None
        self._read_at = 0.0
        self._chosen: dict[str, str] = {}
        self.file_label, self.averaged_label = label("", "muted"), label("", "muted")
        self.plot = SweepPlot()
        self.plot.rows_chosen.connect(self.choose)
        self.chosen_label = label()
        self.chosen_label.setMinimumHeight(2 * self.fontMetrics().lineSpacing() + 4)
        self.take_button = push_button(
            "&Apply to parameter panel", lambda: self.taken_over.emit(dict(self._chosen))
        )
        self.take_button.setEnabled(False)
        tip = "Select the point with the best mean over recordings and seeds"
        self.best_button = push_button("&Best point", self.choose_best, tip)
        top = hbox((self.file_label, 1), push_button("&Open …", self._ask))
        chosen = hbox((self.chosen_label, 1), self.best_button, self.take_button)
        self.setLayout(
            vbox(
                top, self._choices(), (self.plot, 1), self.averaged_label, chosen,
                self._make_buttons(), margins=(9, 9, 9, 9),
            )
        )  # fmt: skip
        self.resize(900, 640)
        self._timer = QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)
        self._timer.start()

    def open_table(self, path: Path) -> None:
        """Show a table.

        Raises
        ------
        InputError
            Where it is none of a sweep.
        """
        columns, rows = read_csv_table(path)
        table = table_of_cells(columns, rows, str(path))
        self._read_at = path.stat().st_mtime
        first = path != self.path
        self.path, self.table = path, table
        self._fill(table, keep=not first)
        if first:
            self._chosen = {}
            self.chosen_label.setText("Click a point to see its values.")
            self.take_button.setEnabled(False)
        settled = ", ".join(f"{name} {value}" for name, value in table.settled.items())
        failed = f"; {table.failed} failed (not shown)" if table.failed else ""
        self.file_label.setText(
            f"{path.name}: {counted(len(table.rows), 'run')}{failed}. {settled}".strip()
        )
        self.file_label.setToolTip(str(path))
        self.draw()

    @Slot()
    def draw(self) -> None:
        """Draw what the choices say."""
        table, across, second, up = self._wanted()
        if table is None or not across or not up:
            return
        if self._is_heat(across, second):
            self.plot.show_heat((across, second), up, heat_of(table, across, second, up))
            self.averaged_label.setText(_averaged(table, (across, second), "Each cell is"))
            return
        self.plot.show_curves(axis_of(table, across), up, curves_of(table, across, up, second))
        told = "Each faint point is one run; lines and error bars are"
        self.averaged_label.setText(_averaged(table, (across, second), told, spread=True))

    @Slot(object)
    def choose(self, rows: tuple[int, ...]) -> None:
        """Show the values of some runs."""
        table = self.table
        if table is None:
            return
        self._chosen = {
            name: value for name, value in table.chosen(rows).items() if name != "recording"
        }
        named = ", ".join(
            f"{name.replace('_', ' ')} {_rounded(value)}" for name, value in self._chosen.items()
        )
        told = [_figures(table, rows, name) for name in _TOLD if name in table.measures]
        self.chosen_label.setText(
            f"{named or 'All runs'} – {counted(len(rows), 'run')}: {', '.join(told)}"
        )
        self.take_button.setEnabled(bool(self._chosen))

    @Slot()
    def choose_best(self) -> None:
        """Show the point that has the best mean of the measure that is drawn."""
        if self.table is not None:
            self.choose(best_rows(self.table, self.measure.currentData()))

    def save_picture(self, path: Path) -> None:
        """Write what is shown as a picture for a paper.

        Raises
        ------
        InputError
            Where nothing can be written there.
        """
        table, across, second, up = self._wanted()
        if table is not None and self._is_heat(across, second):
            draw_heat(path, (across, second), up, heat_of(table, across, second, up))
        elif table is not None:
            draw_curves(path, axis_of(table, across), up, curves_of(table, across, up, second))

    # ---- inside

    def _wanted(self) -> tuple[SweepTable | None, str, str, str]:
        """The table, what is across, what else distinguishes points, and the measure."""
        across, second = self.across.currentData() or "", self.second.currentData() or ""
        up = self.measure.currentData() or ""
        return self.table, across, second if second != across else "", up

    def _is_heat(self, across: str, second: str) -> bool:
        return self.kind.currentData() == "heat" and bool(across and second)

    def _choices(self) -> QHBoxLayout:
        kinds = (("curves", "Curves"), ("heat", "Heat map"))
        self.kind = choice("Draw", kinds, "Curves over one parameter, or a heat map over two")
        self.measure, self.across = choice("of"), choice("across")
        tip = "Curves: distinguished by colour. Heat map: vertical axis."
        self.second = choice("and", tip=tip)
        row = hbox()
        for box in (self.kind, self.measure, self.across, self.second):
            row.addWidget(QLabel(box.accessibleName()))
            row.addWidget(box)
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
            box.activated.connect(self.draw)
        row.addStretch(1)
        return row

    def _make_buttons(self) -> QDialogButtonBox:
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.save_button = buttons.addButton("&Save plot …", QDialogButtonBox.ButtonRole.ActionRole)
        self.save_button.setAutoDefault(False)
        self.save_button.clicked.connect(self._ask_picture)
        buttons.rejected.connect(self.reject)
        return buttons

    def _fill(self, table: SweepTable, *, keep: bool) -> None:
        """Offer what the table has; what was chosen stays where it can."""
        old = [box.currentData() if keep else None for box in (self.across, self.second)]
        measure = self.measure.currentData() if keep else None
        names = table.parameters or tuple(table.settled)[:1]
        for box in (self.across, self.second, self.measure):
            box.clear()
        self.second.addItem("nothing more", "")
        for name in names:
            self.across.addItem(words_of(name), name)
            self.second.addItem(words_of(name), name)
        for name in table.measures:
            self.measure.addItem(words_of(name), name)
        favourite = next((one for one in _FAVOURITES if one in table.measures), None)
        # recordings and seeds are what is averaged over, unless somebody asks for them
        chosen = [name for name in names if name not in AVERAGED] or list(names)
        _show(self.across, old[0], chosen[0] if chosen else None)
        few = [name for name in chosen[1:] if len(table.values(name)) <= _MOST_COLOURS]
        _show(self.second, old[1], few[0] if few else "")
        _show(self.measure, measure, favourite)

    @Slot()
    def _look(self) -> None:
        """Read the table again when a sweep has written to it."""
        if self.path is None or not self.isVisible():
            return
        try:
            if self.path.stat().st_mtime != self._read_at:
                self.open_table(self.path)
        except (OSError, InputError):
            return  # it is being written at this moment; the next look will find it

    @Slot()
    def _ask(self) -> None:
        start = str(self.path.parent) if self.path is not None else ""

        def show(path: Path) -> None:
            try:
                self.open_table(path)
            except InputError as error:
                self.file_label.setText(str(error))

        ask_to_open(self, "Open sweep results", start, "Table (*.csv)", show)

    @Slot()
    def _ask_picture(self) -> None:
        name = str(self.path.with_suffix(".svg")) if self.path is not None else "sweep.svg"
        chosen, _ = QFileDialog.getSaveFileName(
            self, "Save plot", name, "SVG drawing (*.svg);;PNG image (*.png)"
        )
        if chosen:
            path = Path(chosen)
            try:
                self.save_picture(path if path.suffix else path.with_suffix(".svg"))
            except InputError as error:
                self.chosen_label.setText(str(error))


def _show(box: QComboBox, old: str | None, otherwise: str | None) -> None:
    place = box.findData(old) if old is not None else -1
    box.setCurrentIndex(place if place >= 0 else max(0, box.findData(otherwise)))


def _rounded(value: str) -> str:
    """A number with the digits that say something; words as they are."""
    try:
        return f"{float(value):.4g}" if "." in value else value
    except ValueError:
        return value


def _figures(table: SweepTable, rows: tuple[int, ...], name: str) -> str:
    """Mean and spread of a measure: ``forearms 9.1 ± 0.5 deg``."""
    measure = measure_named(name)
    values = table.numbers(name)[list(rows)]
    values = values[np.isfinite(values)]
    if measure is None or not values.size:
        return ""
    spread = float(values.std(ddof=1)) if values.size > 1 else math.nan
    more = f" ± {spread:.1f}" if math.isfinite(spread) else ""
    return f"{measure.short or measure.label} {values.mean():.1f}{more} {measure.unit}".strip()


def _averaged(
    table: SweepTable, shown: tuple[str, str], begin: str, *, spread: bool = False
) -> str:
    """What is averaged over: ``Each field is the mean over recording, seed and views.``"""
    over = [name.replace("_", " ") for name in table.parameters if name not in shown]
    if not over:
        return "Each point is one run."
    named = over[0] if len(over) == 1 else f"{', '.join(over[:-1])} and {over[-1]}"
    return f"{begin} the mean{' and standard deviation' if spread else ''} over {named}."


def parameters_of(values: Mapping[str, str]) -> dict[str, str]:
    """Values of declared parameters among those of a point."""
    return {name: value for name, value in values.items() if name not in SPECIAL and value}


AVERAGED = ("recording", "seed")
"""Columns that a point is averaged over, unless somebody asks for them."""


def best_rows(table: SweepTable, measure: str) -> tuple[int, ...]:
    """Rows of the point with the best mean of a measure; empty where nothing is known."""
    columns = [table.columns.index(name) for name in table.parameters if name not in AVERAGED]
    known, values = measure_named(measure), table.numbers(measure)
    sign = -1.0 if known is not None and known.more_is_better else 1.0
    points: dict[tuple[str, ...], list[int]] = {}
    for row in np.flatnonzero(np.isfinite(values)).tolist():
        points.setdefault(tuple(table.rows[row][i] for i in columns), []).append(row)
    best = min(points.values(), key=lambda rows: sign * float(values[rows].mean()), default=[])
    return tuple(best)
