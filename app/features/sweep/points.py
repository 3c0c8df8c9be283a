"""What a sweep tries: every combination of values, the points of a list, or a search."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import (
    QComboBox,
    QFileDialog,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QSpinBox,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.request import TRIALS

from ...widgets.forms.sweep_values import SweepValues
from .plan import hint_for, measures_to_judge_by, names_to_vary

_WAYS = (
    ("grid", "All combinations of values", "Every combination of the values of all parameters."),
    ("list", "List of points", "Parameter values listed in a file, one point per row."),
    (
        "search",
        "Search for the best values",
        "Each point is chosen from the results of the previous ones.",
    ),
)
_ABOUT_LIST = (
    "A CSV file with one column per parameter and one row per point. Columns can also be views, "
    "preset, frames, init or smooth. An empty cell keeps the present value."
)
_ABOUT_RANGES = (
    "Write a range as 50:600, or as 0.1:10:log for a logarithmic scale. Write words and switches "
    "as a list: yes,no."
)


class SweepPoints(QGroupBox):
    """Asks which points are tried."""

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Values", parent)
        self.way = QComboBox()
        self.way.setAccessibleName("Values")
        for place, (name, words, about) in enumerate(_WAYS):
            self.way.addItem(words, name)
            self.way.setItemData(place, about, Qt.ItemDataRole.ToolTipRole)
        self.values = SweepValues(names_to_vary(), hint_for)
        self.ranges = SweepValues(names_to_vary(), hint_for, "from:to, or a,b,c")
        self.stack = QStackedWidget()
        for page in (self.values, self._list_page(), self._search_page()):
            self.stack.addWidget(page)
        self.besides = _muted()
        column = QVBoxLayout(self)
        column.addWidget(self.way)
        column.addWidget(self.stack, 1)
        column.addWidget(self.besides)
        self.way.currentIndexChanged.connect(self.stack.setCurrentIndex)
        for signal in (self.way.currentIndexChanged, self.values.changed, self.ranges.changed):
            signal.connect(lambda: self.changed.emit())

    def show_base(self, preset: str, changes: Sequence[str]) -> None:
        """Say what all points begin with: a preset, and ``NAME=VALUE`` for what differs."""
        said = f"All other settings are those of the parameter panel: {preset}"
        if changes:
            named = ", ".join(change.replace("_", " ").replace("=", " ") for change in changes[:4])
            said += f" with {named}" + (" and more" if len(changes) > 4 else "")
        self.besides.setText(f"{said}.")

    def fields(self) -> dict[str, Any]:
        """What a request for a sweep says about points.

        Raises
        ------
        InputError
            Where something is missing.
        """
        match self.way.currentData():
            case "grid":
                return {"grid": _named(self.values)}
            case "list":
                file = self.file.text().strip()
                if not file:
                    raise InputError("no list of points is chosen", remedy="Choose a file.")
                return {"points": Path(file)}
        named, measure = _named(self.ranges), str(self.judge.currentData())
        if not named:
            raise InputError("no parameters to search", remedy="Add a parameter and its range.")
        return {"search": named, "trials": self.trials.value(), "minimise": measure or None}

    # ---- making

    def _list_page(self) -> QWidget:
        self.file = QLineEdit()
        self.file.setAccessibleName("List of points")
        self.file.setPlaceholderText("points.csv")
        self.file.textEdited.connect(self.changed)
        choose = QPushButton("Choose …")
        choose.setAutoDefault(False)
        choose.clicked.connect(self._ask_list)
        row = QHBoxLayout()
        row.addWidget(self.file, 1)
        row.addWidget(choose)
        page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 6, 0, 0)
        column.addLayout(row)
        column.addWidget(_muted(_ABOUT_LIST))
        column.addStretch(1)
        return page

    def _search_page(self) -> QWidget:
        self.trials = QSpinBox()
        self.trials.setRange(1, 100_000)
        self.trials.setValue(TRIALS)
        self.trials.setToolTip("Number of points to try, each with all recordings and seeds")
        self.judge = QComboBox()
        for name, words in measures_to_judge_by():
            self.judge.addItem(words, name)
        self.judge.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.judge.setToolTip(
            "The point with the best mean of this measure over all recordings and seeds wins. The "
            "default is the error of the forearms where all recordings have a reference, "
            "otherwise the unexplained fraction."
        )
        self.trials.valueChanged.connect(self.changed)
        self.judge.currentIndexChanged.connect(lambda: self.changed.emit())
        fields = QFormLayout()
        fields.addRow("Points", self.trials)
        fields.addRow("Measure", self.judge)
        page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.ranges, 1)
        column.addWidget(_muted(_ABOUT_RANGES))
        column.addLayout(fields)
        return page

    @Slot()
    def _ask_list(self) -> None:
        start = str(Path(self.file.text()).parent) if self.file.text() else ""
        chosen, _ = QFileDialog.getOpenFileName(self, "List of points", start, "Table (*.csv)")
        if chosen:
            self.file.setText(chosen)
            self.changed.emit()


def _named(values: SweepValues) -> tuple[str, ...]:
    """``NAME=a,b,c`` for each line."""
    return tuple(f"{name}={texts}" for name, texts in values.varied())


def _muted(words: str = "") -> QLabel:
    label = QLabel(words)
    label.setProperty("role", "muted")
    label.setWordWrap(True)
    return label
