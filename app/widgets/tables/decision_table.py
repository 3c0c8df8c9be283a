"""A table of clicks that contradict each other, each with its decision."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QColor, QFont
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from stereotrack_core.project.merging import Decision

from ..style.theme import current_theme
from .cells import RIGHT

_Index: TypeAlias = QModelIndex | QPersistentModelIndex
_NOWHERE = QModelIndex()
_HEADINGS = ("Frame", "Camera", "Landmark", "Mine", "Theirs", "Mean", "Distance [px]", "Annotator")
_CHOICES: dict[int, Decision] = {3: "mine", 4: "theirs", 5: "mean"}
_KEYS: dict[int, Decision] = {Qt.Key.Key_M: "mine", Qt.Key.Key_T: "theirs", Qt.Key.Key_B: "mean"}


@dataclass(frozen=True)
class DecisionRow:
    """What the table says about one click.

    Attributes
    ----------
    frame : int
    camera, landmark : str
    mine, theirs : str
        What both sides say, in words.
    distance : float or None
        Pixels between both; None where one has no place.
    has_mean : bool
    who : str
    """

    frame: int
    camera: str
    landmark: str
    mine: str
    theirs: str
    distance: float | None
    has_mean: bool
    who: str


class DecisionModel(QAbstractTableModel):
    """Rows and their decisions; what is decided is kept by somebody else.

    Signals
    -------
    decided : list of int, str
        The person wants these rows decided so.
    """

    decided = Signal(list, str)

    def __init__(self) -> None:
        super().__init__()
        self._rows: Sequence[DecisionRow] = ()
        self._decision: Callable[[int], Decision] = lambda _row: "mine"

    def show(self, rows: Sequence[DecisionRow], decision: Callable[[int], Decision]) -> None:
        """Show these rows, with the function that tells the decision of a row."""
        self.beginResetModel()
        self._rows, self._decision = rows, decision
        self.endResetModel()

    def row(self, row: int) -> DecisionRow:
        """What is said in a row."""
        return self._rows[row]

    def repaint_decisions(self) -> None:
        """The decisions may have changed."""
        if self._rows:
            last = self.index(len(self._rows) - 1, len(_HEADINGS) - 1)
            self.dataChanged.emit(self.index(0, 0), last)

    def rowCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(_HEADINGS)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return _HEADINGS[section]
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row, column = self._rows[index.row()], index.column()
        if role == Qt.ItemDataRole.DisplayRole:
            return self._text(row, column)
        if role == Qt.ItemDataRole.TextAlignmentRole and column in (0, 6):
            return RIGHT
        if role == Qt.ItemDataRole.ToolTipRole:
            return "Click Mine, Theirs or Mean to choose; double-click to go to the frame."
        choice = _CHOICES.get(column)
        if choice is None:
            return None
        return self._look_of_choice(choice, role, self._decision(index.row()) == choice)

    @staticmethod
    def _look_of_choice(choice: str, role: int, chosen: bool) -> Any:
        theme = current_theme()
        if role == Qt.ItemDataRole.AccessibleDescriptionRole:
            return f"{choice}{', chosen' if chosen else ''}"
        if role == Qt.ItemDataRole.FontRole and chosen:
            font = QFont()
            font.setBold(True)
            return font
        if role == Qt.ItemDataRole.BackgroundRole and chosen:
            return QColor(theme.selection)
        if role == Qt.ItemDataRole.ForegroundRole:
            return QColor(theme.text if chosen else theme.muted)
        return None

    @staticmethod
    def _text(row: DecisionRow, column: int) -> str:
        distance = "–" if row.distance is None else f"{row.distance:.1f}"
        mean = "mean" if row.has_mean else "–"
        texts = (str(row.frame), row.camera, row.landmark, row.mine, row.theirs, mean)
        return (*texts, distance, row.who)[column]


class DecisionTable(QTableView):
    """Contradicting clicks; a click on one side takes it, keys decide the selected rows.

    Signals
    -------
    decided : list of int, str
    visit_requested : int
        The person wants to see the click of this row.
    """

    decided = Signal(list, str)
    visit_requested = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows_model = DecisionModel()
        self.setModel(self.rows_model)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setAccessibleName("Clicks that differ")
        self.setAccessibleDescription(
            "Press M for mine, T for theirs, B for the mean of both. Applies to all selected rows."
        )
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setStretchLastSection(True)
        self._place_columns()
        self.clicked.connect(self._on_clicked)
        self.doubleClicked.connect(lambda index: self.visit_requested.emit(index.row()))

    def _place_columns(self) -> None:
        click = "000.0, 000.0"
        place = f"{click}  guessed"
        widest = ("00000", "W_right", "left shoulder", place, place, "mean", "")
        header = self.horizontalHeader()
        metrics = self.fontMetrics()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        for column, text in enumerate(widest):
            text = max(text, _HEADINGS[column], key=metrics.horizontalAdvance)
            header.resizeSection(column, metrics.horizontalAdvance(text) + 24)

    def selected_rows(self) -> list[int]:
        """Rows that are selected, ascending."""
        return sorted(index.row() for index in self.selectionModel().selectedRows())

    def keyPressEvent(self, event: Any) -> None:
        decision = _KEYS.get(event.key())
        if decision is not None and not event.modifiers():
            self.decided.emit(self.selected_rows(), decision)
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.currentIndex().isValid():
            self.visit_requested.emit(self.currentIndex().row())
        else:
            super().keyPressEvent(event)

    def _on_clicked(self, index: QModelIndex) -> None:
        decision = _CHOICES.get(index.column())
        if decision is not None:
            self.decided.emit([index.row()], decision)
