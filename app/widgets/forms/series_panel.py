"""One parameter along a slider: choose it, its range, and look at what each value gives."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
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
from stereotrack_core.tracking.tuning.series import MOST, usual_range

from ..plots.small_multiples import MeansCurve, Multiple, SmallMultiples, keeps_arrows
from ..style.building import choice, hbox, label, scrolled, searchable, thin_progress, vbox
from .numbers import WholeNumberField

_NOTHING = (
    "Choose a parameter and a range to see the errors for each value. The selected frames are "
    "tracked with each value."
)


class ValueSlider(QSlider):
    """A slider whose arrow keys move it, while they go to other frames elsewhere."""

    def event(self, event: QEvent) -> bool:
        return keeps_arrows(event) or super().event(event)


class SeriesPanel(QWidget):
    """Chooser, small multiples, the curve of their means, and a slider along the values."""

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
        self.multiples = SmallMultiples(self)
        self.multiples.chosen.connect(self.shown)
        self.multiples.taken.connect(self.taken)
        self.means = MeansCurve(self)
        self.slider = ValueSlider(Qt.Orientation.Horizontal, self)
        self.slider.setAccessibleName("Value whose model is shown")
        self.slider.setTickPosition(QSlider.TickPosition.TicksBelow)
        self.slider.setPageStep(1)
        self.slider.valueChanged.connect(self.shown)
        self.take = QPushButton("Apply", self)
        self.take.setToolTip("Set the parameter to this value")
        self.take.clicked.connect(lambda: self.taken.emit(self.slider.value()))
        self._lay_out()
        self.show_series((), None, 0.0, running=False)

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
        self, multiples: Sequence[Multiple], current: int | None, share: float, *, running: bool
    ) -> None:
        """Show what was found with each value, and which of them is shown in the views."""
        self._running = running
        self.begin.setText("Stop" if running else "Track")
        self.begin.setToolTip(
            "Stop the series"
            if running
            else "Track the selected frames with each value. This replaces the series before it, "
            "which cannot be undone."
        )
        self.progress.setValue(round(100 * share) if running else 0)
        self.multiples.show_multiples(multiples, current)
        self.means.show_means(multiples, current)
        for widget in (self.means, self.slider, self.take):
            widget.setVisible(bool(multiples))
        with QSignalBlocker(self.slider):
            self.slider.setRange(0, max(len(multiples) - 1, 0))
            self.slider.setValue(current if current is not None else 0)
        self.take.setEnabled(current is not None)
        self._say(multiples, current)

    def _say(self, multiples: Sequence[Multiple], current: int | None) -> None:
        best = next((m for m in multiples if m.best), None)
        said = _NOTHING
        if multiples:
            said = "Click a plot or move the slider to show the model for a value in the views."
        if best is not None:
            said = f"Best: {best.title} ({best.summary})."
        if current is not None and current < len(multiples):
            shown = multiples[current]
            said = f"Shown: {shown.title} ({shown.summary}). {said if best is not None else ''}"
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
            (scrolled(self.multiples, "Trials of the series"), 1),
            self.means,
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
