"""Panels of words and a table: metrics, body fit, checks, trials, runs, their comparison."""

import math
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from PySide6 import QtWidgets
from PySide6.QtCore import QEvent, QSignalBlocker, QSize, Qt
from PySide6.QtGui import QAction, QIcon, QPen, QResizeEvent

from stereotrack_core.counting import counted
from stereotrack_core.recording.findings import Finding

from ..style import building
from ..style.colours import LIMB_COLOURS, PEN_STYLES, LineStyle, line_pixmap
from ..style.theme import icon_named
from .table import RIGHT, STRETCH, TOP, Cell, CellRow, CellTable, Column
from .trees import CellTree, TreeRow

NumberRow: TypeAlias = tuple[str, str, str, str]
"""Limb (empty for none), label, value with its unit, and a hint in words."""

_VALUE_TIP = (
    "For a limb: its angular error, where there is a reference. After ±: the standard deviation "
    "of its direction as estimated by the filter. This is small also when the filter tracks the "
    "wrong points."
)
_NUMBERS = (
    Column("Measure"),
    Column("Value", _VALUE_TIP, RIGHT, even=True),
    Column("Remark", width=STRETCH),
)


class NumbersPanel(QtWidgets.QWidget):
    """Table of numbers, each with its limb's colour; Ctrl+C copies what is selected."""

    def __init__(self) -> None:
        super().__init__()
        self.table = CellTable("Frame metrics", _NUMBERS, _number_cells)
        words = "Run the tracker to see metrics of this frame."
        nothing = building.label(words, "muted", align=Qt.AlignmentFlag.AlignCenter)
        self._stack = QtWidgets.QStackedLayout(self)
        self._stack.addWidget(nothing)
        self._stack.addWidget(self.table)

    def show_rows(self, rows: Sequence[NumberRow]) -> None:
        """Show limb, label, value and hint of each row; selection and scroll place stay."""
        self.table.show_rows(tuple(rows))
        self._stack.setCurrentIndex(1 if rows else 0)


def _number_cells(row: NumberRow) -> Sequence[Cell]:
    limb, name, value, hint = row
    tip = hint or (_VALUE_TIP if limb else name)
    return (
        Cell(name, tip, swatch=LIMB_COLOURS.get(limb, "")),
        Cell(value, tip),
        Cell(hint, tip, "muted"),
    )


class CameraBoxes(QtWidgets.QWidget):
    """A box to tick for each camera that counts, in as many columns as there is room for."""

    def __init__(self) -> None:
        super().__init__()
        self.boxes: dict[QtWidgets.QCheckBox, QAction] = {}
        self._doubtful: Collection[str] = ()
        self._doubt = ""
        self._placed: tuple[list[QtWidgets.QCheckBox], int] = [], 0
        # as wide as the panel is, however many columns there are: it may become narrower
        self.setSizePolicy(QtWidgets.QSizePolicy.Policy.Ignored, QtWidgets.QSizePolicy.Policy.Fixed)
        self._grid = QtWidgets.QGridLayout()
        self._grid.setHorizontalSpacing(12)
        self._grid.setVerticalSpacing(2)
        caption = building.label("Cameras that count", "muted", margins=(6, 0, 6, 0))
        self.setLayout(
            building.vbox(caption, building.hbox(self._grid, None), margins=(0, 2, 0, 2), spacing=2)
        )

    def add(self, actions: Sequence[QAction]) -> None:
        """Add boxes of commands ``Use N``, which switch whether a camera counts."""
        for action in actions:
            box = QtWidgets.QCheckBox(self)
            self.boxes[box] = action
            box.clicked.connect(action.trigger)
            action.changed.connect(partial(self._show, box, action))

    def mark(self, doubtful: Collection[str], words: str) -> None:
        """Say of cameras, as people call them, that they disagree with the others."""
        if (self._doubtful, self._doubt) != (doubtful, words):
            self._doubtful, self._doubt = doubtful, words
            for box, action in self.boxes.items():
                self._show(box, action)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._lay_out()

    def _show(self, box: QtWidgets.QCheckBox, action: QAction) -> None:
        name, tip = action.text().removeprefix("Use "), action.toolTip()
        doubtful = name in self._doubtful
        box.setText(building.shortened(name, 10))
        box.setChecked(action.isChecked())
        box.setEnabled(action.isEnabled())
        box.setIcon(icon_named("warning") if doubtful else QIcon())
        box.setToolTip(f"{self._doubt}. {tip}" if doubtful else tip)
        box.setVisible(action.isVisible())
        self._lay_out()

    def _lay_out(self) -> None:
        """Place the boxes; where they stay in their places, a frame step has no time for it."""
        shown = [box for box in self.boxes if not box.isHidden()]
        widest = self._grid.horizontalSpacing()
        widest += max(map(_width_with_icon, shown), default=0)
        columns = max(self.width() // widest, 1)
        if self._placed == (shown, columns):
            return
        self._placed = shown, columns
        for place, box in enumerate(shown):
            self._grid.addWidget(box, *divmod(place, columns))
        self.setVisible(bool(shown))


def _width_with_icon(box: QtWidgets.QCheckBox) -> int:
    """Pixels, also without an icon: columns stay as many when it comes and goes."""
    icon = box.iconSize().width() + 4 if box.icon().isNull() else 0
    return box.sizeHint().width() + icon


class BodyPanel(QtWidgets.QWidget):
    """How well clicks fix each limb, the clicked lengths, and whether measured depth is used."""

    def __init__(self) -> None:
        super().__init__()
        self.cameras = CameraBoxes()
        self.with_depth = QtWidgets.QCheckBox("Use depth")
        self.with_depth.setToolTip(
            "Fit the body to the measured points as well as to the clicks, where the recording "
            "has depth."
        )
        self.words = building.label(margins=(6, 2, 6, 2), copied=True)
        columns = (Column(""), Column("", "", RIGHT, even=True), Column("", width=STRETCH))
        self.tree = CellTable("Uncertainty of the body fit", columns)
        self.tree.setHeaderHidden(True)
        self.tree.setToolTip(
            "± is the standard deviation of the limb direction, assuming correct clicks."
        )
        self.tree.setMinimumHeight(40)  # it scrolls; what is below it cannot give room
        self.tree.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.tree.setSelectionMode(CellTable.SelectionMode.NoSelection)
        self.hint = building.label("", "muted", margins=(6, 2, 6, 2))
        self.hint.hide()
        self._buttons = building.vbox(spacing=0, margins=(4, 0, 4, 2))
        above = (self.words, (self.tree, 1), self.cameras)
        parts = (*above, self.with_depth, self.hint, self._buttons)
        self.setLayout(building.vbox(*parts, margins=(0, 2, 0, 0), spacing=2))

    def add_action_buttons(self, actions: Sequence[QAction]) -> None:
        for action in actions:
            button = building.action_button(action, Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setAutoRaise(True)
            self._buttons.addWidget(button)

    def show_hint(self, words: str) -> None:
        building.show_text(self.hint, words)

    def show_body(self, words: Sequence[str], rows: Sequence[CellRow]) -> None:
        """Show the most important words first, then a row for every limb and length."""
        building.show_text(self.words, "\n".join(words))
        self.tree.show_rows(rows)


_ORDER = {"error": 0, "warning": 1, "note": 2}
_COLOURS = {"error": "error", "warning": "warning", "note": "muted"}


class FindingsPanel(QtWidgets.QWidget):
    """A verdict in words, and below it each finding: where, what, and what to do.

    `correct` is called when the button of a finding is pressed whose correction is known.
    """

    def __init__(self, correct: Callable[[Finding], object]) -> None:
        super().__init__()
        self._correct = correct
        self.verdict = building.label(margins=(8, 6, 8, 6))
        where = Column("Where", align=TOP, width=110)
        columns = where, Column("Problem and remedy", width=STRETCH), Column("", width=90)
        self.tree = CellTable("Recording checks", columns, _finding_cells, least=200)
        self.tree.setItemDelegate(QtWidgets.QStyledItemDelegate(self.tree))
        self.tree.setUniformRowHeights(False)
        self.tree.setWordWrap(True)
        self._top = building.hbox((self.verdict, 1), margins=(0, 0, 6, 0))
        self.setLayout(building.vbox(self._top, (self.tree, 1), spacing=0))

    def add_action_button(self, action: QAction) -> None:
        self._top.addWidget(building.action_button(action))

    def show_findings(self, findings: Sequence[Finding] | None) -> None:
        """Show what was found; None while it is still being looked for."""
        rows = sorted(findings or (), key=lambda found: _ORDER[found.severity])
        self.tree.setColumnHidden(2, not any(finding.correction for finding in rows))
        self.tree.show_rows(rows)
        for row, finding in enumerate(rows):
            self.tree.setIndexWidget(self.tree.cells.index(row, 2), self._button(finding))
        self.verdict.setText("Checking the recording …" if findings is None else _verdict(findings))

    def _button(self, finding: Finding) -> QtWidgets.QWidget:
        if finding.correction is None:
            return QtWidgets.QWidget()
        tip = "Say what would be changed in which file of the recording."
        button = building.tool_button(tip, text="Correct …", do=lambda: self._correct(finding))
        button.setAutoRaise(False)
        button.setAccessibleName(f"Correct {finding.where}")
        return button


def _finding_cells(found: Finding) -> Sequence[Cell]:
    words = f"{found.what}\n{found.remedy}" if found.remedy else found.what
    return Cell(found.where, found.where, _COLOURS[found.severity]), Cell(words, words), Cell()


def _verdict(findings: Sequence[Finding]) -> str:
    count = Counter(found.severity for found in findings)
    warnings = counted(count["warning"], "warning")
    if count["error"]:
        return f"Not usable yet: {counted(count['error'], 'error')}, {warnings}."
    less = warnings if count["warning"] else counted(count["note"], "note")
    return f"Usable, with {less}." if findings else "Usable; no problems found."


_WORTH_SAYING = 0.05
_COLOURS_WORDS = (
    "Green is lower than the run, so better; orange is higher. Thick curves: the selected trial."
)
_NOTHING = (
    "Change a parameter to run a trial: the selected frames are tracked again, and the trial is "
    "drawn beside the run until you discard it."
)
TRIAL_TIP = (
    "Mean over the frames of the trial, of arms also over the four segments; in brackets the "
    "difference from the run. Lower is better."
)


class TrialsPanel(QtWidgets.QWidget):
    """A row for the run and for each trial.

    `chosen` is called with the row that a person has selected, -1 for none.
    """

    def __init__(self, chosen: Callable[[int], object]) -> None:
        super().__init__()
        self.words = building.label(margins=(8, 6, 8, 0))
        self.stretch_words, self.limits = (
            building.label("", "muted", margins=(8, 0, 8, 2)) for _ in range(2)
        )
        self.progress = building.thin_progress()
        self.table = CellTable("Trials", least=172, single=True)
        self.table.selectionModel().selectionChanged.connect(lambda: chosen(self.row))
        self._nothing = building.empty_label(_NOTHING)
        self._colours = building.label(_COLOURS_WORDS, "muted", margins=(8, 2, 8, 2))
        self.buttons = building.hbox(margins=(6, 0, 6, 0))
        below = ((self._nothing, 1), (self.table, 1), self._colours, self.buttons)
        head = (self.words, self.stretch_words, self.limits, self.progress)
        self.setLayout(building.vbox(*head, *below, margins=(0, 0, 0, 4), spacing=2))
        self.show_progress(0, 0)
        self.show_table((), ())

    @property
    def row(self) -> int:
        return next(iter(self.table.selected()), -1)

    def show_words(self, words: str, stretch: str, limits: str) -> None:
        """Say what is being done or would be, on which frames, and what besides it differs."""
        building.show_text(self.words, words)
        building.show_text(self.stretch_words, stretch)
        building.show_text(self.limits, limits)

    def show_progress(self, done: int, count: int) -> None:
        """Show how many of `count` frames are done; nothing where `count` is 0."""
        self.progress.setRange(0, max(count, 1))
        self.progress.setValue(done if count else 0)

    def show_table(
        self, headings: Sequence[str], rows: Sequence[CellRow], chosen: int = -1
    ) -> None:
        """Show a name and numbers of the run and its trials, one of them chosen or -1."""
        for part in (self.table, self._colours):
            part.setVisible(bool(rows))
        self._nothing.setVisible(not rows)
        numbers = (Column(heading, TRIAL_TIP, RIGHT) for heading in headings)
        with QSignalBlocker(self.table.selectionModel()):
            self.table.show_rows(rows, (Column("Trial", TRIAL_TIP, width=STRETCH), *numbers))
            if 0 <= chosen < len(rows):
                self.choose(chosen)

    def choose(self, row: int) -> None:
        self.table.setCurrentIndex(self.table.cells.index(row, 0))


def number_cell(value: float, change: float, digits: int) -> Cell:
    """A number with its change, NaN where there is none, of which less is better."""
    if abs(change) >= _WORTH_SAYING:
        colour = "good" if change < 0 else "warning"
        return Cell(f"{value:.{digits}f} ({change:+.{digits}f})", TRIAL_TIP, colour)
    return Cell("…" if math.isnan(value) else f"{value:.{digits}f}", TRIAL_TIP)


_SCORE_TIP = (
    "Mean over frames and arm segments: the angle against the reference, or the tracker's standard "
    "deviation (±) without one. In brackets the difference from the active run, over the frames "
    "that both have."
)
_RUNS = (
    Column("Run", width=STRETCH), Column("Frames"), Column("Arms, mean", _SCORE_TIP),
    *map(Column, ("Time", "Seed", "Date")),
)  # fmt: skip
_NARROWEST_NAME = 170


@dataclass(frozen=True)
class RunRow:
    """Row of one run in the list."""

    name: Cell  # bold for the active run
    style: LineStyle
    facts: CellRow  # frames, score, time, seed and date
    made: str  # preset and changed parameters


class RunsPanel(QtWidgets.QWidget):
    """A row per run; the tick shows it, a click draws its model, the name can be changed.

    `activate`, `show_run` and `rename` are called with the place of a run among the rows.
    """

    def __init__(
        self,
        activate: Callable[[int], object],
        show_run: Callable[[int, bool], object],
        rename: Callable[[int, str], object],
    ) -> None:
        super().__init__()

        def change(place: int, ticked: bool, name: str) -> None:
            show_run(place, ticked)
            rename(place, name)

        def on_clicked(item: QtWidgets.QTreeWidgetItem) -> None:
            if item.checkState(0) == Qt.CheckState.Checked:
                activate(self.tree.indexOfTopLevelItem(item))

        self._rows: Sequence[RunRow] = ()
        self.tree = CellTree("Runs", _RUNS, change, least=_NARROWEST_NAME)
        self.tree.setRootIsDecorated(False)
        self.tree.setIconSize(QSize(30, 14))
        self.tree.setEditTriggers(CellTree.EditTrigger.EditKeyPressed)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.made = building.label("", "muted", margins=(8, 2, 8, 6), copied=True)
        self._none = building.empty_label("Run the tracker or open a run to see it listed here.")
        self.setLayout(building.vbox(self._none, (self.tree, 1), self.made))
        self.tree.itemClicked.connect(on_clicked)
        # a run that is not shown is shown, and read from the project where it has to be
        self.tree.activated.connect(lambda index: activate(index.row()))
        self.show_rows(())

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange and self._rows:
            self.show_rows(self._rows)  # lines are in the text's colour
        super().changeEvent(event)

    def show_rows(self, rows: Sequence[RunRow]) -> None:
        self._rows = rows
        self._none.setVisible(not rows)
        active = next((place for place, row in enumerate(rows) if row.name.bold), -1)
        self.made.setVisible(bool(rows))
        self.made.setText("No run is active." if active < 0 else rows[active].made)
        self.tree.setVisible(bool(rows))
        for fact in (2, 3, 4):
            self.tree.setColumnHidden(fact + 1, not any(row.facts[fact].text for row in rows))
        shown = []
        for place, row in enumerate(rows):
            pen = QPen(self.palette().text().color(), 1.6, PEN_STYLES[row.style])
            line = line_pixmap(pen, self.devicePixelRatioF())
            shown.append(TreeRow((replace(row.name, swatch=line, value=place), *row.facts)))
        self.tree.show_rows(shown)
        with QSignalBlocker(self.tree):
            self.tree.choose(active)


_NO_METRICS = "Run the tracker to see run metrics here. Show several runs to compare them."
_METRIC_COLOURS = (
    "Green is lower than the first run, so better; orange is higher. Without a colour, these "
    "frames do not show a difference: its 95 % interval contains 0, or there are too few frames "
    "for an interval."
)


class ComparisonPanel(QtWidgets.QWidget):
    """A row per measure and a column per run; the first run is what others are compared with."""

    def __init__(self) -> None:
        super().__init__()
        self.words = building.label(_NO_METRICS, "muted", margins=(8, 6, 8, 2))
        tip = "Show the errors of the arms over each named stretch."
        self.by_stretch = building.named(QtWidgets.QCheckBox("By named stretch"), tip=tip)
        self.by_stretch.hide()
        self.table = CellTable("Run comparison", least=280)
        self._colours = building.label(_METRIC_COLOURS, "muted", margins=(8, 2, 8, 4))
        box = building.hbox(self.by_stretch, margins=(8, 0, 8, 0))
        self.setLayout(building.vbox(self.words, box, (self.table, 1), self._colours, spacing=2))
        self._colours.hide()
        self.table.hide()

    def show_numbers(
        self, words: str, runs: Sequence[str], rows: Sequence[CellRow], how: str = ""
    ) -> None:
        """Show the values of `runs`, or that there are none.

        Of two runs a row has the difference and a conclusion as well. `words` say what is compared,
        `how` says how the intervals are made, for the tooltip.
        """
        self.words.setText(words if runs else _NO_METRICS)
        self.words.setToolTip(how)
        self.table.setVisible(bool(runs and rows))
        self._colours.setVisible(bool(rows) and len(runs) > 1)
        numbers = [*runs, "difference (95 %)"] if len(runs) == 2 else runs
        columns = [Column("measure", "measure"), *(Column(one, one, RIGHT) for one in numbers)]
        if len(runs) == 2:
            columns.append(Column("conclusion", "conclusion", width=STRETCH))
        self.table.show_rows(rows if runs else (), columns)
