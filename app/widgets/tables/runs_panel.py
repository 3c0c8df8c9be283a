"""The runs of the recording: named, shown or hidden, chosen, removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QPen
from PySide6.QtWidgets import QTreeWidgetItem, QWidget

from ..style.building import empty_label, label, vbox
from ..style.colours import PEN_STYLES, LineStyle, line_pixmap
from .table import RIGHT, STRETCH, Cell, CellRow, CellTable, Column
from .trees import CellTree, TreeRow

_RUNS = (
    Column("Run", width=STRETCH),
    Column("Frames"),
    Column("Arm error"),
    Column("Time"),
    Column("Seed"),
    Column("Date"),
)
_NARROWEST_NAME = 170


@dataclass(frozen=True)
class RunRow:
    """What the list says about one run, in words."""

    name: str
    style: LineStyle
    """Of its curves and outlines."""
    visible: bool
    active: bool
    frames: str
    """Those it has."""
    score: str
    """Its median error, or how it stands."""
    hint: str
    time: str = ""
    """How long tracking took."""
    seed: str = ""
    when: str = ""
    """When it was tracked, short."""
    made: str = ""
    """Preset and changed parameters."""


class RunsPanel(QWidget):
    """A row per run; the tick shows it, a click draws its model, the name can be changed."""

    activated = Signal(int)
    shown = Signal(int, bool)
    renamed = Signal(int, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.tree = CellTree("Runs", _RUNS, least=_NARROWEST_NAME)
        self.tree.setRootIsDecorated(False)
        self.tree.setIconSize(QSize(30, 14))
        self.tree.setEditTriggers(CellTree.EditTrigger.EditKeyPressed)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.made = label("", "muted", margins=(8, 2, 8, 6))
        """Preset and settings of the active run."""
        self.made.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._none = empty_label("Run the tracker or open a run to see it listed here.")
        self.setLayout(vbox(self._none, (self.tree, 1), self.made))
        self.tree.changed.connect(self._on_changed)
        self.tree.itemClicked.connect(self._on_clicked)
        # a run that is not shown is shown, and read from the project where it has to be
        self.tree.activated.connect(lambda index: self.activated.emit(index.row()))
        self.show_rows(())

    def show_rows(self, rows: Sequence[RunRow]) -> None:
        """Show these runs."""
        self._none.setVisible(not rows)
        active = next((row for row in rows if row.active), None)
        self.made.setVisible(bool(rows))
        self.made.setText("No run is active." if active is None else active.made)
        self.tree.setVisible(bool(rows))
        for column, heading in enumerate(("time", "seed", "when"), start=3):
            self.tree.setColumnHidden(column, not any(getattr(row, heading) for row in rows))
        self.tree.show_rows([self._tree_row(place, row) for place, row in enumerate(rows)])
        with QSignalBlocker(self.tree):
            self.tree.choose(next((k for k, row in enumerate(rows) if row.active), -1))

    def _tree_row(self, place: int, row: RunRow) -> TreeRow:
        pen = QPen(self.palette().text().color(), 1.6, PEN_STYLES[row.style])
        line = line_pixmap(pen, self.devicePixelRatioF())
        name = Cell(
            row.name, row.hint, swatch=line, bold=row.active, value=place, ticked=row.visible,
            editable=True,
        )  # fmt: skip
        others = (row.frames, row.score, row.time, row.seed, row.when)
        return TreeRow((name, *(Cell(text, row.hint, bold=row.active) for text in others)))

    def _on_changed(self, place: int, ticked: bool, name: str) -> None:
        self.shown.emit(place, ticked)
        self.renamed.emit(place, name)

    def _on_clicked(self, item: QTreeWidgetItem) -> None:
        if item.checkState(0) == Qt.CheckState.Checked:
            self.activated.emit(self.tree.indexOfTopLevelItem(item))


_NOTHING = "Run the tracker to see run metrics here. Show several runs to compare them."
_COLOURS = (
    "Green is lower than the first run, so better; orange is higher. Without a colour, these "
    "frames do not show a difference: its 95 % interval contains 0, or there are too few frames "
    "for an interval."
)


class ComparisonPanel(QWidget):
    """A row per measure and a column per run; the first run is what others are compared with."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = label(_NOTHING, "muted", margins=(8, 6, 8, 2))
        self.table = CellTable("Run comparison", least=280)
        self._colours = label(_COLOURS, "muted", margins=(8, 2, 8, 4))
        self.setLayout(vbox(self.words, (self.table, 1), self._colours, spacing=2))
        self._colours.hide()
        self.table.hide()

    def show_numbers(
        self, words: str, runs: Sequence[str], rows: Sequence[CellRow], how: str = ""
    ) -> None:
        """Show the values of `runs`, or that there are none.

        Of two runs a row has the difference and a conclusion as well. `words` say what is compared,
        `how` says how the intervals are made, for the tooltip.
        """
        self.words.setText(words if runs else _NOTHING)
        self.words.setToolTip(how)
        self.table.setVisible(bool(runs and rows))
        self._colours.setVisible(bool(rows) and len(runs) > 1)
        columns = [Column("measure", "measure"), *(Column(run, run, RIGHT) for run in runs)]
        if len(runs) == 2:
            between = "difference (95 %)"
            columns += [
                Column(between, between, RIGHT),
                Column("conclusion", "conclusion", width=STRETCH),
            ]
        self.table.show_rows(rows if runs else (), columns)
