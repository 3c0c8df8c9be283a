"""What a sweep tries: every combination of values, the points of a list, or a search."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QFormLayout,
    QGroupBox,
    QSizePolicy,
    QStackedWidget,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.measures import MEASURES
from stereotrack_core.experiments.sweep.points import SPECIAL, TRIALS, parameter_rows

from ...widgets.forms.form_dialog import ask_to_open, line_edit, push_button
from ...widgets.forms.numbers import WholeNumberField
from ...widgets.forms.sweep_values import SweepValues
from ...widgets.style.building import choice, hbox, label, vbox

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
_ABOUT_MEASURE = (
    "The point with the best mean of this measure over all recordings and seeds wins. The "
    "default is the error of the forearms where all recordings have a reference, "
    "otherwise the unexplained fraction."
)


class SweepPoints(QGroupBox):
    """Asks which points are tried."""

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Values", parent)
        self.way = choice("Values", [way[:2] for way in _WAYS])
        for place, (_, _, about) in enumerate(_WAYS):
            self.way.setItemData(place, about, Qt.ItemDataRole.ToolTipRole)
        self.values = SweepValues(_names_to_vary(), hint_for)
        self.ranges = SweepValues(_names_to_vary(), hint_for, "from:to, or a,b,c")
        self.stack = QStackedWidget()
        for page in (self.values, self._list_page(), self._search_page()):
            self.stack.addWidget(page)
        self.besides = label("", "muted")
        self.setLayout(vbox(self.way, (self.stack, 1), self.besides, margins=(9, 9, 9, 9)))
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

    def _list_page(self) -> QWidget:
        self.file = line_edit("List of points", placeholder="points.csv")
        self.file.textEdited.connect(self.changed)
        ask = partial(ask_to_open, self, "List of points", "", "Table (*.csv)", self._take_list)
        choose = push_button("Choose …", ask)
        about, page = label(_ABOUT_LIST, "muted"), QWidget()
        page.setLayout(vbox(hbox((self.file, 1), choose), about, None, margins=(0, 6, 0, 0)))
        return page

    def _search_page(self) -> QWidget:
        self.trials = WholeNumberField(minimum=1, maximum=100_000, value=TRIALS)
        self.trials.setToolTip("Number of points to try, each with all recordings and seeds")
        best = {True: "higher is better", False: "lower is better"}
        named = [(one.name, f"{one.title}, {best[one.more_is_better]}") for one in MEASURES]
        self.judge = choice("Measure", [("", "default measure"), *named], _ABOUT_MEASURE)
        self.judge.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.trials.valueChanged.connect(self.changed)
        self.judge.currentIndexChanged.connect(lambda: self.changed.emit())
        fields, page = QFormLayout(), QWidget()
        fields.addRow("Points", self.trials)
        fields.addRow("Measure", self.judge)
        page.setLayout(vbox((self.ranges, 1), label(_ABOUT_RANGES, "muted"), fields))
        return page

    def _take_list(self, path: Path) -> None:
        self.file.setText(str(path))
        self.changed.emit()


def _named(values: SweepValues) -> tuple[str, ...]:
    """``NAME=a,b,c`` for each line."""
    return tuple(f"{name}={texts}" for name, texts in values.varied())


def _names_to_vary() -> tuple[tuple[str, str], ...]:
    """Everything that can be varied, with a sentence about it; seeds have a field of their own."""
    rows = parameter_rows().values()
    special = [(name, words) for name, words in SPECIAL.items() if name not in ("seed", "frames")]
    return (*special, *((row.name, row.help) for row in rows))


def hint_for(name: str) -> str:
    """Which values a name takes, and what it is otherwise."""
    if name in SPECIAL:
        examples = {"views": "for example NS,NOSW", "preset": "for example accurate,fast",
                    "init": "auto,tpose", "smooth": "yes,no"}  # fmt: skip
        return examples.get(name, "")
    row = parameter_rows()[name]
    default = ("yes" if row.default else "no") if row.type is bool else row.default
    if row.choices:
        return f"{', '.join(row.choices)}; default {default}"
    if row.type is bool:
        return f"yes,no; default {default}"
    shown = f"{default:g}" if isinstance(default, float) else str(default)
    return f"{row.range_text()}; default {shown}"
