"""The runs of the recording: named, shown or hidden, chosen, removed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtGui import QPen
from PySide6.QtWidgets import QTreeWidgetItem, QWidget

from ..style.building import empty_label, label, vbox
from ..style.colours import PEN_STYLES, LineStyle, line_pixmap
from .table import RIGHT, STRETCH, Cell, CellRow, CellTable, Column
from .trees import CellTree, TreeRow

_FACTS = "Frames", "Arm error", "Time", "Seed", "Date"
_RUNS = Column("Run", width=STRETCH), *map(Column, _FACTS)
_NARROWEST_NAME = 170


@dataclass(frozen=True)
class RunRow:
    """What the list says about one run, in words."""

    name: str
    style: LineStyle
    visible: bool
    active: bool
    frames: str
    score: str  # its median error, or how it stands
    hint: str
    time: str = ""
    seed: str = ""
    when: str = ""  # when it was tracked, short
    made: str = ""  # preset and changed parameters


class RunsPanel(QWidget):
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

        def on_clicked(item: QTreeWidgetItem) -> None:
            if item.checkState(0) == Qt.CheckState.Checked:
                activate(self.tree.indexOfTopLevelItem(item))

        self.tree = CellTree("Runs", _RUNS, change, least=_NARROWEST_NAME)
        self.tree.setRootIsDecorated(False)
        self.tree.setIconSize(QSize(30, 14))
        self.tree.setEditTriggers(CellTree.EditTrigger.EditKeyPressed)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.made = label("", "muted", margins=(8, 2, 8, 6), copied=True)
        self._none = empty_label("Run the tracker or open a run to see it listed here.")
        self.setLayout(vbox(self._none, (self.tree, 1), self.made))
        self.tree.itemClicked.connect(on_clicked)
        # a run that is not shown is shown, and read from the project where it has to be
        self.tree.activated.connect(lambda index: activate(index.row()))
        self.show_rows(())

    def show_rows(self, rows: Sequence[RunRow]) -> None:
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


_NOTHING = "Run the tracker to see run metrics here. Show several runs to compare them."
_COLOURS = (
    "Green is lower than the first run, so better; orange is higher. Without a colour, these "
    "frames do not show a difference: its 95 % interval contains 0, or there are too few frames "
    "for an interval."
)


class ComparisonPanel(QWidget):
    """A row per measure and a column per run; the first run is what others are compared with."""

    def __init__(self) -> None:
        super().__init__()
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
        numbers = [*runs, "difference (95 %)"] if len(runs) == 2 else runs
        columns = [Column("measure", "measure"), *(Column(one, one, RIGHT) for one in numbers)]
        if len(runs) == 2:
            columns.append(Column("conclusion", "conclusion", width=STRETCH))
        self.table.show_rows(rows if runs else (), columns)
