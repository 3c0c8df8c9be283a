"""Two pages of the window of a study: its settings, and the plot of its results."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QToolButton,
    QWidget,
)

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.measures import measure_named, measured
from stereotrack_core.recording.selection import frames_within
from stereotrack_core.study import store
from stereotrack_core.study.description import Study, StudyRecording, StudySettings, cell_of
from stereotrack_core.study.points import SPECIAL, parameter_rows
from stereotrack_core.study.store import effects_of, effects_words
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.worker_processes import usable_cores

from ...context import Context
from ...session.tracking import Chosen
from ...widgets.forms.form_dialog import line_edit, push_button
from ...widgets.forms.numbers import WholeNumberField
from ...widgets.plots.plots import StudyPlot
from ...widgets.style.building import (
    choice,
    hbox,
    holder,
    label,
    scrolled,
    searchable,
    show_text,
    tool_button,
    vbox,
)

_EXAMPLES = {
    "views": "for example NS,NOSW",
    "preset": "for example accurate,fast",
    "init": "auto,tpose",
    "smooth": "yes,no",
}


class SettingsForm(QWidget):
    """Shows the settings of a study and lets a person change them.

    `take_panel` takes preset and parameters of the parameter panel.
    """

    changed = Signal()

    def __init__(self, take_panel: Callable[[], object]) -> None:
        super().__init__()
        self._settings = StudySettings()
        self._lines: dict[str, tuple[QLabel, QLineEdit, QLabel, QToolButton]] = {}
        self.base = label("")
        tip = "Track with the preset and the parameters of the parameter panel"
        self._take = push_button("&Use parameter panel", take_panel, tip)
        box = QGroupBox("Values to try")
        box.setLayout(vbox((self._values(), 1), self._adder(), margins=(9, 9, 9, 9)))
        top, below = hbox((self.base, 1), self._take), hbox((box, 3), (vbox(self._runs(), None), 2))
        self.setLayout(vbox(top, (below, 1), margins=(6, 6, 6, 6)))

    def show_settings(self, settings: StudySettings) -> None:
        self._settings = settings
        changes = ", ".join(one.replace("_", " ").replace("=", " ") for one in settings.changes)
        self.base.setText(f"All runs use {settings.preset}{f' with {changes}' if changes else ''}.")
        for name in list(self._lines):
            self._remove(name)
        for text in settings.grid:
            name, _, values = text.partition("=")
            self.add(name, values)
        self.seeds.setText(settings.seeds)
        self.frames.setText(settings.frames or "")
        self.views.setText(settings.views or "")
        self.smooth.setChecked(settings.smooth)

    def settings(self) -> StudySettings:
        typed = {name: line[1].text().strip() for name, line in self._lines.items()}
        found = replace(
            self._settings,
            grid=tuple(f"{name}={values}" for name, values in typed.items() if values),
            seeds=self.seeds.text().replace(" ", "") or "0",
            frames=self.frames.text().strip() or None,
            views=self.views.text().strip() or None,
            smooth=self.smooth.isChecked(),
        )
        found.check()
        return found

    def field(self, name: str) -> QLineEdit:
        return self._lines[name][1]

    def add(self, name: str, values: str = "") -> None:
        """Add a line for the values of a name, or go to the one that is there."""
        if name not in self._lines:
            about, hint = _about(name), _hint(name)
            words = name.replace("_", " ")
            title = label(words, wraps=False)
            title.setToolTip(about)
            field = line_edit(f"Values of {words}", values, "a,b,c", f"{about} {hint}")
            field.textEdited.connect(self.changed)
            away = tool_button(f"Do not vary {words}", "close", do=lambda: self._remove(name))
            self._lines[name] = (title, field, label(hint, "muted", wraps=False), away)
            row = self._grid.rowCount()
            for column, widget in enumerate(self._lines[name]):
                self._grid.addWidget(widget, row, column)
        self.field(name).setFocus()
        self._nothing.hide()
        self.changed.emit()

    def _remove(self, name: str) -> None:
        for widget in self._lines.pop(name):
            self._grid.removeWidget(widget)
            widget.deleteLater()
        self._nothing.setVisible(not self._lines)
        self.changed.emit()

    def _values(self) -> QWidget:
        self._grid = QGridLayout()
        self._grid.setContentsMargins(4, 4, 4, 4)
        self._grid.setColumnStretch(1, 1)
        self._nothing = label("No values yet. Add a parameter.", "muted")
        scroll = scrolled(holder(vbox(self._nothing, self._grid, None)), "Values")
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        return scroll

    def _adder(self) -> QHBoxLayout:
        varied = [name for name in SPECIAL if name not in ("seed", "frames")]
        names = [(name, name.replace("_", " ")) for name in (*varied, *parameter_rows())]
        self.chooser = searchable(choice("Parameter to vary", names))
        for place, (name, _) in enumerate(names):
            self.chooser.setItemData(place, _about(name), Qt.ItemDataRole.ToolTipRole)
        self.chooser.setCurrentIndex(-1)
        line = self.chooser.lineEdit()
        if line is not None:
            line.setPlaceholderText("Search parameters")
            line.returnPressed.connect(self._add_chosen)
        add = tool_button("Vary this parameter", "add", "Add", do=self._add_chosen)
        return hbox((self.chooser, 1), add)

    def _add_chosen(self) -> None:
        place = self.chooser.findText(self.chooser.currentText().strip())
        if place >= 0:
            self.add(str(self.chooser.itemData(place)))
            self.chooser.setCurrentIndex(-1)

    def _runs(self) -> QGroupBox:
        box = QGroupBox("Runs")
        form = QFormLayout(box)
        self.seeds = line_edit("Seeds", tip="Comma-separated; every point is tracked with each")
        self.frames = line_edit("Frames", "", "all, or A:B", "Frames A up to but not including B")
        self.views = line_edit("Views", "", "all, or NS", "Views to use, as for --views")
        self.smooth = QCheckBox("S&mooth the runs")
        self.processes = WholeNumberField(
            minimum=1, maximum=256, value=usable_cores(), accessibleName="Processes"
        )
        for field in (self.seeds, self.frames, self.views):
            field.textEdited.connect(self.changed)
            form.addRow(field.accessibleName(), field)
        form.addRow("Processes", self.processes)
        self.smooth.toggled.connect(self.changed)
        form.addRow(self.smooth)
        return box


def study_of_open(context: Context, path: Path) -> Study:
    """A study of the open recording alone, with the parameter panel's settings."""
    session, study = context.session, Study(path)
    recording, project, seen = session.document.recording, session.project.path, session.keypoints
    own = "" if project is None else study.relative(project)
    folder = "" if recording is None else study.relative(recording.folder.resolve())
    row = StudyRecording(folder, own, own if seen.wanted and seen.cameras else "")
    settings, stretch = session.study.panel_settings(StudySettings()), context.view_state.selection
    if stretch:
        settings = replace(settings, frames=f"{stretch.start}:{stretch.stop}")
    return replace(study, rows=(row,), settings=settings)


def apply_to_panel(context: Context, values: Mapping[str, str]) -> None:
    """Put a point's values into the parameter panel."""
    name = values.get("preset", "")
    own = {key: value for key, value in values.items() if key not in SPECIAL and value}
    chosen = context.session.track.chosen
    if name in PRESETS:
        chosen = Chosen(name, preset(name), preset(name))
    elif not own:
        told = ", ".join(f"{one} {value}" for one, value in values.items())
        context.notifier.say(f"The parameter panel has no such parameters: {told}.", 6000)
        return
    try:
        chosen = replace(chosen, settings=chosen.settings.replaced(**own))
    except InputError as error:
        context.notifier.error(error)
        return
    said = ", ".join(f"{one.replace('_', ' ')} {value}" for one, value in own.items()) or name
    context.session.track.take(chosen, f"apply {said}")
    context.notifier.say(f"Applied: {said}.", 6000)


def present_value(context: Context, name: str) -> str:
    """Value of a parameter, or the preset, in the parameter panel; empty for anything else."""
    track = context.session.track
    if name == "preset":
        return track.preset
    value = track.settings.values().get(name)
    return "" if value is None else str(cell_of(value))


def baseline_of(context: Context, measure: str) -> float:
    """A measure of the active run over the frames of a study of the open recording alone."""
    session, study = context.session, context.session.study.study
    recording, entry = session.document.recording, session.finished_run
    run = None if entry is None else entry.run()
    if study is None or len(study.rows) != 1 or recording is None or run is None:
        return math.nan
    if study.place(study.rows[0].recording) != recording.folder.resolve():
        return math.nan
    try:
        frames = frames_within(study.settings.frames, session.document.frame_count)
    except InputError:
        return math.nan
    inside, truth = run.within(frames), session.judging.truth
    reference = None if truth is None else truth.trajectory
    whole = len(inside.frame) == len(frames)
    return measured(inside, reference).get(measure, math.nan) if whole else math.nan


def _about(name: str) -> str:
    return SPECIAL[name] if name in SPECIAL else parameter_rows()[name].help


def _hint(name: str) -> str:
    if name in SPECIAL:
        return _EXAMPLES.get(name, "")
    row = parameter_rows()[name]
    if row.type is bool:
        return f"yes,no; default {'yes' if row.default else 'no'}"
    if row.choices:
        return f"{', '.join(row.choices)}; default {row.default}"
    shown = f"{row.default:g}" if isinstance(row.default, float) else str(row.default)
    return f"{row.range_text()}; default {shown}"


_MOST_COLOURS = 8
_FAVOURITES = ("forearms", "unexplained_fraction", "keypoint_error")
_TOLD = (
    *("torso_position", "upper_arms", "forearms", "lost", "unexplained_fraction"),
    *("keypoint_error", "frames_per_second"),
)
_EFFECTS_TIP = (
    "Share of the measure's variance that the values of each parameter explain, with the range of "
    "the means. The rest is due to seeds and to parameters acting together."
)
_EMPTY = "No run is finished yet. Track the recordings to see their results here."


class ResultsPanel(QWidget):
    """Plots a table; a click on a point shows its values by name, which can be applied."""

    def __init__(self, context: Context) -> None:
        super().__init__()
        self._context = context
        self.table: store.RunTable | None = None
        self.path: Path | None = None
        self._read_at = 0
        self._chosen: dict[str, str] = {}
        self.file_label, self.averaged_label = label(_EMPTY, "muted"), label("", "muted")
        self.effects_label = label("", copied=True)
        self.effects_label.setToolTip(_EFFECTS_TIP)
        self.plot = StudyPlot(self.choose)
        self.chosen_label = label("")
        self.take_button = push_button(
            "Apply to &parameter panel", lambda: apply_to_panel(context, self._chosen)
        )
        tip = "Select the point with the best mean over recordings and seeds"
        self.best_button = push_button("&Best point", self.choose_best, tip)
        chosen = hbox((self.chosen_label, 1), self.best_button, self.take_button)
        words = (self.averaged_label, self.effects_label)
        parts = (self.file_label, self._choices(), (self.plot, 1), *words, chosen)
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
        across, second, up = (
            box.currentData() or "" for box in (self.across, self.second, self.measure)
        )
        table, second = self.table, second if second != across else ""
        if table is None or not across or not up:
            self.plot.clear()
            show_text(self.effects_label, "")
            return
        axis, curves = store.axis_of(table, across), store.curves_of(table, across, up, second)
        present, baseline = present_value(self._context, across), baseline_of(self._context, up)
        self.plot.show_curves(axis, up, curves, present, baseline)
        measure = measure_named(up)
        unit = "" if measure is None else measure.unit
        effects = effects_words(effects_of(table, up), unit)
        show_text(self.effects_label, f"Importance: {effects}." if effects else "")
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
