"""One parameter along a slider: choose it, its range, and look at what each value gives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QSlider,
    QWidget,
)

from stereotrack_core.counting import typed_number
from stereotrack_core.parameters import ParameterRow, Value, value_text
from stereotrack_core.study.table import RunTable, axis_of, curve_of
from stereotrack_core.tracking.tuning.series import MOST, usual_range

from ..plots.study_plot import StudyPlot
from ..style.building import choice, hbox, label, searchable, thin_progress, vbox
from .numbers import WholeNumberField

_NOTHING = (
    "Choose a parameter and a range to see the errors for each value. The selected frames are "
    "tracked with each value."
)


@dataclass(frozen=True)
class SeriesValue:
    """Results with one value of the parameter."""

    words: str
    """The value with its unit."""
    text: str
    """The value as it is typed."""
    summary: str
    mean: float = math.nan
    """Mean of the arms in degrees; NaN while frames are missing."""
    best: bool = False


class ValueSlider(QSlider):
    """A slider whose arrow keys move it, while they go to other frames elsewhere."""

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            arrow = event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Right)
            if arrow and not event.modifiers():
                event.accept()
                return True
        return super().event(event)


class SeriesPanel(QWidget):
    """Chooser, the plot of a study of this one parameter, and a slider along the values."""

    begin_requested = Signal(object, float, float, int, bool)
    """Parameter, range, number of values, and whether by even factors; range and number do not
    count for words and switches."""
    cancel_requested = Signal()
    shown = Signal(int)
    """Place of the value whose model shall be shown; -1 for none."""
    taken = Signal(int)
    """Place of the value that shall be taken over."""
    row_chosen = Signal(object)
    """Another parameter is chosen; the caller answers with :meth:`set_value`."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rows: dict[str, ParameterRow] = {}
        self._running = False
        self._make_chooser()
        self.words = label(_NOTHING, "muted")
        self.progress = thin_progress()
        self.progress.setRange(0, 100)
        self.plot = StudyPlot(self)
        self.plot.setToolTip("Mean over the arm segments and frames. Click a point to show it.")
        self.plot.rows_chosen.connect(lambda rows: self.shown.emit(rows[0]))
        self.slider = ValueSlider(Qt.Orientation.Horizontal, self)
        self.slider.setAccessibleName("Value whose model is shown")
        self.slider.setTickPosition(QSlider.TickPosition.TicksBelow)
        self.slider.setPageStep(1)
        self.slider.valueChanged.connect(self.shown)
        self.take = QPushButton("Apply", self)
        self.take.setToolTip("Set the parameter to this value")
        self.take.clicked.connect(lambda: self.taken.emit(self.slider.value()))
        self._lay_out()
        self.show_series("", (), None)

    def set_rows(self, rows: Sequence[ParameterRow]) -> None:
        """Offer these parameters."""
        if [*self._rows] == [row.name for row in rows]:
            return
        self._rows = {row.name: row for row in rows}
        with QSignalBlocker(self.parameter):
            self.parameter.clear()
            for row in rows:
                self.parameter.addItem(row.name.replace("_", " "), row.name)
        self._on_parameter()

    @property
    def row(self) -> ParameterRow | None:
        """The parameter that is chosen."""
        return self._rows.get(str(self.parameter.currentData()))

    def choose(self, name: str) -> None:
        """Choose a parameter by its name."""
        self.parameter.setCurrentIndex(self.parameter.findData(name))
        self._on_parameter()

    def set_value(self, value: Value) -> None:
        """Propose a range around the value that the parameter has."""
        row = self.row
        if row is None:
            return
        number = row.type in (int, float)
        for widget in (self.low, self._to, self.high, self.count, self.by_factors):
            widget.setVisible(number)
        words = ", ".join(row.choices) if row.choices else "yes and no"
        self.unit.setText(row.unit if number else f"each of: {words}")
        self.parameter.setToolTip(row.help)
        if number:
            low, high = usual_range(row, value)
            self.low.setText(value_text(low))
            self.high.setText(value_text(high))
            self.by_factors.setChecked(low > 0 and row.type is float)

    def refuse(self, sentence: str) -> None:
        """Say why it cannot begin."""
        self._write(sentence, "error")

    def show_series(
        self,
        name: str,
        values: Sequence[SeriesValue],
        current: int | None,
        *,
        share: float = 0.0,
        running: bool = False,
    ) -> None:
        """Show what was found with each value of a parameter, and which is shown in the views."""
        self._running = running
        self.begin.setText("Stop" if running else "Track")
        self.begin.setToolTip(
            "Stop the series"
            if running
            else "Track the selected frames with each value. This replaces the series before it, "
            "which cannot be undone."
        )
        self.progress.setValue(round(100 * share) if running else 0)
        for widget in (self.plot, self.slider, self.take):
            widget.setVisible(bool(values))
        with QSignalBlocker(self.slider):
            self.slider.setRange(0, max(len(values) - 1, 0))
            self.slider.setValue(current if current is not None else 0)
        self.take.setEnabled(current is not None)
        self._draw(name, values)
        self._say(values, current)

    def _draw(self, name: str, values: Sequence[SeriesValue]) -> None:
        known = [place for place, one in enumerate(values) if math.isfinite(one.mean)]
        if not known:
            self.plot.clear()
            return
        axis = axis_of(RunTable((name,), tuple((one.text,) for one in values)), name)
        x = np.array([axis.places[values[place].text] for place in known])
        mean = np.array([values[place].mean for place in known])
        curve = curve_of("", x, mean, np.array(known))
        self.plot.show_curves(axis, "arms, mean [deg]", (curve,))

    def _say(self, values: Sequence[SeriesValue], current: int | None) -> None:
        best = next((one for one in values if one.best), None)
        said = _NOTHING
        if values:
            said = "Click a point or move the slider to show the model for a value in the views."
        if best is not None:
            said = f"Best: {best.words} ({best.summary})."
        if current is not None and current < len(values):
            shown = values[current]
            said = f"Shown: {shown.words} ({shown.summary}). {said if best is not None else ''}"
        self._write(said.strip(), "muted")

    def _write(self, text: str, role: str) -> None:
        self.words.setText(text)
        self.words.setProperty("role", role)
        self.words.style().polish(self.words)

    def _make_chooser(self) -> None:
        self.parameter = searchable(choice("Parameter to vary"))
        self.parameter.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.parameter.activated.connect(lambda _index: self._on_parameter())
        self.low, self.high = QLineEdit(self), QLineEdit(self)
        for field, name in ((self.low, "From"), (self.high, "To")):
            field.setAccessibleName(name)
            field.setMaximumWidth(72)
            field.returnPressed.connect(self._on_begin)
        self.unit = label("", "muted", wraps=False)
        self.count = WholeNumberField(self)
        self.count.setRange(2, MOST)
        self.count.setValue(6)
        self.count.setAccessibleName("Number of values")
        self.count.setSuffix(" values")
        self.by_factors = QCheckBox("logarithmic", self)
        self.by_factors.setToolTip("Multiply by a constant factor from value to value")
        self.begin = QPushButton(self)
        self.begin.clicked.connect(self._on_begin)

    def _lay_out(self) -> None:
        self._to = QLabel("to", self)
        chosen = hbox((self.parameter, 1), self.begin)
        values = (self.low, self._to, self.high, self.unit)
        many = hbox(*values, None, self.by_factors, self.count)
        last = hbox((self.slider, 1), self.take)
        parts = (
            chosen,
            many,
            self.progress,
            self.words,
            (self.plot, 1),
            last,
        )
        self.setLayout(vbox(*parts, margins=(6, 6, 6, 4), spacing=4))

    def _on_parameter(self) -> None:
        row = self.row
        if row is not None:
            self.row_chosen.emit(row)

    def _on_begin(self) -> None:
        if self._running:
            self.cancel_requested.emit()
            return
        row = self.row
        if row is None:
            self.refuse("There is no parameter of that name.")
            return
        low, high = (_number(field.text()) for field in (self.low, self.high))
        self.begin_requested.emit(row, low, high, self.count.value(), self.by_factors.isChecked())


def _number(text: str) -> float:
    try:
        return typed_number(text)
    except ValueError:
        return float("nan")
