"""The plot of a table of runs, with the values behind a point."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QWidget

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.measures import measure_named
from stereotrack_core.study import store

from ...widgets.forms.form_dialog import push_button
from ...widgets.plots.study_plot import StudyPlot
from ...widgets.style.building import choice, hbox, label, vbox

_MOST_COLOURS = 8
_FAVOURITES = ("forearms", "unexplained_fraction", "keypoint_error")
_TOLD = (
    *("torso_position", "upper_arms", "forearms", "lost", "unexplained_fraction"),
    *("keypoint_error", "frames_per_second"),
)
_EMPTY = "No run is finished yet. Track the recordings to see their results here."


class ResultsPanel(QWidget):
    """Plots a table; a click on a point shows its values by name, which can be applied."""

    def __init__(self, apply: Callable[[Mapping[str, str]], object]) -> None:
        super().__init__()
        self.table: store.RunTable | None = None
        self.path: Path | None = None
        self._read_at = 0
        self._chosen: dict[str, str] = {}
        self.file_label, self.averaged_label = label(_EMPTY, "muted"), label("", "muted")
        self.plot = StudyPlot(self.choose)
        self.chosen_label = label("")
        self.take_button = push_button(
            "Apply to &parameter panel", lambda: apply(dict(self._chosen))
        )
        tip = "Select the point with the best mean over recordings and seeds"
        self.best_button = push_button("&Best point", self.choose_best, tip)
        chosen = hbox((self.chosen_label, 1), self.best_button, self.take_button)
        parts = (self.file_label, self._choices(), (self.plot, 1), self.averaged_label, chosen)
        self.setLayout(vbox(*parts, margins=(6, 6, 6, 6)))
        self._allow()

    def show_table(self, path: Path) -> None:
        table, first = store.read_table(path), path != self.path
        self._read_at = path.stat().st_mtime_ns
        self.path, self.table = path, table
        self._fill(table, keep=not first)
        if first:
            self._chosen = {}
            self.chosen_label.setText("Click a point to see its values.")
        settled = ", ".join(f"{name} {value}" for name, value in table.settled.items())
        failed = f"; {table.failed} failed (not shown)" if table.failed else ""
        count = counted(len(table.rows), "run")
        self.file_label.setText(f"{path.name}: {count}{failed}. {settled}".strip())
        self.file_label.setToolTip(str(path))
        self._allow()
        self.draw()

    def follow(self, path: Path) -> None:
        """Show a table if it is there and has changed; one that is being written is left alone."""
        try:
            if path != self.path:
                self._clear()
            if path.is_file() and (path != self.path or path.stat().st_mtime_ns != self._read_at):
                self.show_table(path)
        except (OSError, InputError):
            return

    def draw(self) -> None:
        table, across, second, up = self._wanted()
        if table is None or not across or not up:
            self.plot.clear()
            return
        self.plot.show_curves(
            store.axis_of(table, across), up, store.curves_of(table, across, up, second)
        )
        over = [one.replace("_", " ") for one in table.varied if one not in (across, second)]
        words = "Each point is one run."
        if over:
            named = " and ".join(filter(None, (", ".join(over[:-1]), over[-1])))
            words = "Each faint point is one run; lines and error bars are the mean and standard "
            words += f"deviation over {named}."
        self.averaged_label.setText(words)

    def choose(self, rows: tuple[int, ...]) -> None:
        table = self.table
        if table is None:
            return
        common = table.common(rows)
        self._chosen = {name: value for name, value in common.items() if name != "recording"}
        values = (f"{name.replace('_', ' ')} {value}" for name, value in self._chosen.items())
        told = [_figures(table, rows, name) for name in _TOLD if name in table.measures]
        count = counted(len(rows), "run")
        self.chosen_label.setText(
            f"{', '.join(values) or 'All runs'} – {count}: {', '.join(filter(None, told))}"
        )
        self._allow()

    def choose_best(self) -> None:
        if self.table is not None:
            self.choose(self.table.best(str(self.measure.currentData())))

    # ---- inside

    def _clear(self) -> None:
        self.table = self.path = None
        self.file_label.setText(_EMPTY)
        for words in (self.chosen_label, self.averaged_label):
            words.setText("")
        self._chosen = {}
        self._allow()
        self.draw()

    def _allow(self) -> None:
        self.best_button.setEnabled(self.table is not None)
        self.take_button.setEnabled(bool(self._chosen))

    def _wanted(self) -> tuple[store.RunTable | None, str, str, str]:
        across, second = self.across.currentData() or "", self.second.currentData() or ""
        up = self.measure.currentData() or ""
        return self.table, across, second if second != across else "", up

    def _choices(self) -> QHBoxLayout:
        self.measure, self.across = choice("Measure"), choice("over")
        self.second = choice("coloured by", tip="A curve for each value")
        row = hbox()
        for box in (self.measure, self.across, self.second):
            row.addWidget(QLabel(box.accessibleName()))
            row.addWidget(box)
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
            box.activated.connect(self.draw)
        row.addStretch(1)
        return row

    def _fill(self, table: store.RunTable, *, keep: bool) -> None:
        boxes = (self.across, self.second, self.measure)
        old = [box.currentData() if keep else None for box in boxes]
        names = table.varied or tuple(table.settled)[:1]
        for box in boxes:
            box.clear()
        self.second.addItem("nothing", "")
        for name in names:
            self.across.addItem(store.words_of(name), name)
            self.second.addItem(store.words_of(name), name)
        for name in table.measures:
            self.measure.addItem(store.words_of(name), name)
        chosen = [name for name in names if name not in store.AVERAGED] or list(names)
        few = [name for name in chosen[1:] if len(table.values(name)) <= _MOST_COLOURS]
        favourite = [name for name in _FAVOURITES if name in table.measures]
        usual = ([*chosen, None][0], [*few, ""][0], [*favourite, None][0])
        for box, before, otherwise in zip(boxes, old, usual, strict=True):
            place = box.findData(before) if before is not None else -1
            box.setCurrentIndex(place if place >= 0 else max(0, box.findData(otherwise)))


def _figures(table: store.RunTable, rows: tuple[int, ...], name: str) -> str:
    """Mean and spread of a measure: ``forearms 9.1 ± 0.5 deg``."""
    measure, values = measure_named(name), table.numbers(name)[list(rows)]
    values = values[np.isfinite(values)]
    if measure is None or not values.size:
        return ""
    spread = float(values.std(ddof=1)) if values.size > 1 else math.nan
    more = f" ± {spread:.1f}" if math.isfinite(spread) else ""
    return f"{measure.short or measure.label} {values.mean():.1f}{more} {measure.unit}".strip()
