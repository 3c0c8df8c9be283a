"""The list of episodes: filters, a row for each, and what speaks for its cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QModelIndex, QSignalBlocker, Qt, Signal, Slot
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..style.limb_colours import LIMB_COLOURS, limb_words
from .cells import RIGHT, swatch
from .evidence_view import EvidenceView

_COLUMNS = ("Frames", "Limbs", "Peak", "Probable cause", "Confidence", "By")
_WIDEST = ("0000–0000", "", "100 %", "", "Confidence", "Detected by")
"""What a column has room for; those without share the rest."""

_VALUE = Qt.ItemDataRole.UserRole
_PLACE = Qt.ItemDataRole.UserRole + 1


@dataclass(frozen=True)
class EpisodeRow:
    """What the list says about one episode.

    Attributes
    ----------
    first, last : int
    limb : str
        The worst one, whose colour stands before the row.
    limbs, peak, cause, found : str
        In words; `found` in one.
    peak_value, confidence : float
        What is sorted by.
    heading : str
        All about it in a sentence.
    evidence : tuple of (str, float, str, bool)
        Cause, strength from 0 to 1, words, and whether it is that of the probable cause.
    """

    first: int
    last: int
    limb: str
    limbs: str
    peak: str
    peak_value: float
    cause: str
    confidence: float
    found: str
    heading: str
    evidence: tuple[tuple[str, float, str, bool], ...]


class EpisodesPanel(QWidget):
    """Filters above, the rows below, then words and pictures of the one that is chosen.

    Signals
    -------
    chosen : int
        A row was chosen, by its place in what was handed on; -1 for none.
    activated : int
        A row was double-clicked, or Enter was pressed on it.
    filtered : str, str, str
        Limb, cause and how found that are wanted; empty for all.
    """

    chosen = Signal(int)
    activated = Signal(int)
    filtered = Signal(str, str, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.limb, self.cause, self.found = QComboBox(), QComboBox(), QComboBox()
        self.words = QLabel()
        self.words.setProperty("role", "muted")
        self.words.setWordWrap(True)
        self.words.setContentsMargins(8, 0, 8, 0)
        self.tree = self._tree()
        self.evidence = EvidenceView()
        both = QSplitter(Qt.Orientation.Vertical)
        both.setChildrenCollapsible(False)
        both.addWidget(self.tree)
        both.addWidget(self.evidence)
        both.setStretchFactor(0, 2)
        both.setStretchFactor(1, 3)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 4, 0, 0)
        layout.setSpacing(4)
        layout.addLayout(self._filters())
        layout.addWidget(self.words)
        layout.addWidget(both, 1)
        self._rows: tuple[EpisodeRow, ...] = ()
        self.show_rows((), -1, "")

    def _filters(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setContentsMargins(6, 0, 6, 0)
        row.setSpacing(4)
        for box, name in (
            (self.limb, "Limb"), (self.cause, "Probable cause"), (self.found, "Detected by")
        ):  # fmt: skip
            box.setAccessibleName(name)
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
            box.setMinimumContentsLength(6)
            box.currentIndexChanged.connect(self._on_filter)
            row.addWidget(box, 1)
        return row

    def _tree(self) -> QTreeWidget:
        tree = QTreeWidget()
        tree.setHeaderLabels(list(_COLUMNS))
        tree.setRootIsDecorated(False)
        tree.setUniformRowHeights(True)
        tree.setAllColumnsShowFocus(True)
        tree.setSortingEnabled(True)
        tree.sortByColumn(0, Qt.SortOrder.AscendingOrder)
        tree.setAccessibleName("Failures")
        tree.setMinimumHeight(70)
        header = tree.header()
        header.setStretchLastSection(False)
        header.setMinimumSectionSize(36)
        header.setStyleSheet("QHeaderView::section { padding: 3px 4px; }")
        words = tree.fontMetrics()
        for column, widest in enumerate(_WIDEST):
            if widest:  # Qt would leave room for a sign of sorting in each of them
                header.setSectionResizeMode(column, QHeaderView.ResizeMode.Interactive)
                header.resizeSection(column, words.horizontalAdvance(widest) + 12)
            else:
                header.setSectionResizeMode(column, QHeaderView.ResizeMode.Stretch)
        tree.currentItemChanged.connect(self._on_current)
        tree.itemActivated.connect(self._on_activated)
        return tree

    # ---- what is shown

    def set_choices(
        self, limbs: Sequence[str], causes: Mapping[str, str], found: Mapping[str, str]
    ) -> None:
        """What can be filtered by: limbs, and causes and ways with their words."""
        named = {limb: limb_words(limb) for limb in limbs}
        for box, every, choices in (
            (self.limb, "all limbs", named),
            (self.cause, "all causes", causes),
            (self.found, "any detection", found),
        ):
            with QSignalBlocker(box):
                box.clear()
                box.addItem(every, "")
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
        if tuple(rows) != self._rows:
            self._rows = tuple(rows)
            with QSignalBlocker(self.tree):
                self.tree.clear()
                self.tree.addTopLevelItems([_item(i, row) for i, row in enumerate(rows)])
        self.choose(chosen)

    def choose(self, place: int) -> None:
        """Choose a row without a signal."""
        with QSignalBlocker(self.tree):
            item = self._item_at(place)
            if item is None:
                self.tree.clearSelection()
                self.tree.setCurrentIndex(QModelIndex())
            else:
                self.tree.setCurrentItem(item)
                self.tree.scrollToItem(item)
        row = self._rows[place] if 0 <= place < len(self._rows) else None
        self.evidence.show_words(
            row.heading if row is not None else "", row.evidence if row is not None else ()
        )

    def _item_at(self, place: int) -> QTreeWidgetItem | None:
        for i in range(self.tree.topLevelItemCount()):
            item = self.tree.topLevelItem(i)
            if item is not None and item.data(0, _PLACE) == place:
                return item
        return None

    # ---- what a person does

    @Slot()
    def _on_filter(self) -> None:
        self.filtered.emit(
            str(self.limb.currentData() or ""),
            str(self.cause.currentData() or ""),
            str(self.found.currentData() or ""),
        )

    def _on_current(self, item: QTreeWidgetItem | None, _old: QTreeWidgetItem | None) -> None:
        self.chosen.emit(-1 if item is None else int(item.data(0, _PLACE)))

    def _on_activated(self, item: QTreeWidgetItem, _column: int) -> None:
        self.activated.emit(int(item.data(0, _PLACE)))


class _Item(QTreeWidgetItem):
    """A row that is sorted by its values, not by its words."""

    def __lt__(self, other: QTreeWidgetItem) -> bool:
        tree = self.treeWidget()
        column = tree.sortColumn() if tree is not None else 0
        return bool(self.data(column, _VALUE) < other.data(column, _VALUE))


def _item(place: int, row: EpisodeRow) -> QTreeWidgetItem:
    sure = f"{100.0 * row.confidence:.0f} %" if row.confidence > 0 else ""
    texts = (f"{row.first}–{row.last}", row.limbs, row.peak, row.cause, sure, row.found)
    values = (row.first, row.limbs, row.peak_value, row.cause, row.confidence, row.found)
    item = _Item(list(texts))
    item.setData(0, _PLACE, place)
    for column, value in enumerate(values):
        item.setData(column, _VALUE, value)
        item.setToolTip(column, f"{row.heading} Double-click or press Enter to go there.")
    for column in (2, 4):
        item.setTextAlignment(column, RIGHT)
    item.setData(1, Qt.ItemDataRole.DecorationRole, swatch(LIMB_COLOURS[row.limb]))
    return item
