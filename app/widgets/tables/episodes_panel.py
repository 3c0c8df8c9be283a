"""The list of episodes: filters, a row for each, and what speaks for its cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QModelIndex, QSignalBlocker, QSortFilterProxyModel, Qt, Signal, Slot
from PySide6.QtWidgets import QComboBox, QSplitter, QTreeView, QWidget

from ..style.building import choice, hbox, label, vbox
from ..style.limb_colours import LIMB_COLOURS, limb_words
from .evidence_view import EvidenceView
from .table import RIGHT, VALUE, Cell, Column, TableModel, dress_list

_COLUMNS = (
    Column("Frames"),
    Column("Limbs"),
    Column("Peak", align=RIGHT),
    Column("Probable cause"),
    Column("Confidence", align=RIGHT),
    Column("By"),
)
_WIDEST = ("0000–0000", "", "100 %", "", "Confidence", "Detected by")
"""What a column has room for; those without share the rest."""


@dataclass(frozen=True)
class EpisodeRow:
    """What the list says about one episode."""

    first: int
    last: int
    limb: str
    """The worst one, whose colour stands before the row."""
    limbs: str
    peak: str
    peak_value: float
    """What the peak is sorted by."""
    cause: str
    confidence: float
    found: str
    """How, in one word."""
    heading: str
    """All about it in a sentence."""
    evidence: tuple[tuple[str, float, str, bool], ...]
    """Cause, strength from 0 to 1, words, and whether it is that of the probable cause."""


class EpisodesPanel(QWidget):
    """Filters above, the rows below, then words and pictures of the one that is chosen."""

    chosen = Signal(int)
    """A row was chosen, by its place in what was handed on; -1 for none."""
    activated = Signal(int)
    """A row was double-clicked, or Enter was pressed on it."""
    filtered = Signal(str, str, str)
    """Limb, cause and how found that are wanted; empty for all."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        names = ("Limb", "Probable cause", "Detected by")
        self._boxes = self.limb, self.cause, self.found = tuple(choice(name) for name in names)
        for box in self._boxes:
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
            box.setMinimumContentsLength(6)
            box.currentIndexChanged.connect(self._on_filter)
        self.words = label("", "muted", margins=(8, 0, 8, 0))
        self.model: TableModel[EpisodeRow] = TableModel(_COLUMNS, _cells)
        self.sorted = QSortFilterProxyModel(self)
        self.sorted.setSourceModel(self.model)
        self.sorted.setSortRole(VALUE)
        self.tree = self._tree()
        self.evidence = EvidenceView()
        both = QSplitter(Qt.Orientation.Vertical)
        both.setChildrenCollapsible(False)
        both.addWidget(self.tree)
        both.addWidget(self.evidence)
        both.setStretchFactor(0, 2)
        both.setStretchFactor(1, 3)
        filters = hbox(*((box, 1) for box in self._boxes), margins=(6, 0, 6, 0), spacing=4)
        self.setLayout(vbox(filters, self.words, (both, 1), margins=(0, 4, 0, 0), spacing=4))
        self.show_rows((), -1, "")

    def _tree(self) -> QTreeView:
        tree = QTreeView()
        tree.setModel(self.sorted)
        tree.setSortingEnabled(True)
        tree.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        tree.setMinimumHeight(70)
        tree.header().setMinimumSectionSize(36)
        tree.header().setStyleSheet("QHeaderView::section { padding: 3px 4px; }")
        room = tree.fontMetrics().horizontalAdvance
        # Qt would leave room for a sign of sorting in each of them
        widths = [room(widest) + 12 if widest else None for widest in _WIDEST]
        dress_list(tree, "Failures", widths)
        tree.selectionModel().currentRowChanged.connect(
            lambda index: self.chosen.emit(self._place(index))
        )
        tree.activated.connect(lambda index: self.activated.emit(self._place(index)))
        return tree

    # ---- what is shown

    def set_choices(
        self, limbs: Sequence[str], causes: Mapping[str, str], found: Mapping[str, str]
    ) -> None:
        """What can be filtered by: limbs, and causes and ways with their words."""
        named = {limb: limb_words(limb) for limb in limbs}
        every = ("all limbs", "all causes", "any detection")
        for box, all_words, choices in zip(self._boxes, every, (named, causes, found), strict=True):
            with QSignalBlocker(box):
                box.clear()
                box.addItem(all_words, "")
                for key, words in choices.items():
                    box.addItem(words, key)

    def show_rows(self, rows: Sequence[EpisodeRow], chosen: int, words: str) -> None:
        """Show these episodes.

        Parameters
        ----------
        rows : sequence of EpisodeRow
        chosen : int
            The one that is chosen; -1 for none.
        words : str
            What is to be said about all of them.
        """
        self.words.setText(words)
        self.words.setVisible(bool(words))
        if tuple(rows) != self.model.rows:
            with QSignalBlocker(self.tree.selectionModel()):
                self.model.show(tuple(rows))
        self.choose(chosen)

    def choose(self, place: int) -> None:
        """Choose a row without a signal."""
        index = self.sorted.mapFromSource(self.model.index(place, 0))
        with QSignalBlocker(self.tree.selectionModel()):
            self.tree.setCurrentIndex(index)
            self.tree.scrollTo(index)
        self.tree.viewport().update()
        row = self.model.rows[place] if index.isValid() else None
        self.evidence.show_words(row.heading if row else "", row.evidence if row else ())

    # ---- what a person does

    @Slot()
    def _on_filter(self) -> None:
        self.filtered.emit(*(str(box.currentData() or "") for box in self._boxes))

    def _place(self, index: QModelIndex) -> int:
        """Place of a row in what was handed on."""
        return self.sorted.mapToSource(index).row()


def _cells(row: EpisodeRow) -> Sequence[Cell]:
    tip = f"{row.heading} Double-click or press Enter to go there."
    sure = f"{100.0 * row.confidence:.0f} %" if row.confidence > 0 else ""
    return (
        Cell(f"{row.first}–{row.last}", tip, value=row.first),
        Cell(row.limbs, tip, swatch=LIMB_COLOURS[row.limb]),
        Cell(row.peak, tip, value=row.peak_value),
        Cell(row.cause, tip),
        Cell(sure, tip, value=row.confidence),
        Cell(row.found, tip),
    )
