"""What to click next, with the reason, and when it is enough."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    QSize,
    Qt,
    Signal,
    Slot,
)
from PySide6.QtGui import QColor, QFontMetrics, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QApplication,
    QCheckBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QTreeView,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.next_clicks import StopSign, Suggestion

from ..style.theme import current_theme
from .cells import swatch

_Index: TypeAlias = QModelIndex | QPersistentModelIndex
_NOWHERE = QModelIndex()
_HEADINGS = ("Frame", "View", "Landmark", "Gain [°]", "All [°]", "Reason")
_NUMBERS = (0, 3, 4)
_TIPS = {
    3: "Expected reduction of the angular uncertainty of this frame's limbs",
    4: "Expected reduction over all frames that benefit; the list is sorted by this",
}
_NARROW = 460
_KEPT = 1000
_NOT_FITTED = "Fit the whole recording to see suggested clicks. The most useful ones come first."


class SuggestionModel(QAbstractTableModel):
    """Suggestions as rows, best first."""

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[Suggestion, ...] = ()
        self._colours: Mapping[str, str] = {}
        self.visited: set[ClickKey] = set()

    def show(self, rows: Sequence[Suggestion], colours: Mapping[str, str]) -> None:
        """Show these; `colours` are those of the landmarks."""
        self.beginResetModel()
        self._rows, self._colours = tuple(rows), colours
        self.endResetModel()

    def suggestion(self, row: int) -> Suggestion:
        """What is suggested in a row."""
        return self._rows[row]

    def first_unvisited(self) -> int | None:
        """The best row that nobody went to yet; the best one where all were; None without rows."""
        if not self._rows:
            return None
        rows = (row for row, one in enumerate(self._rows) if one.key not in self.visited)
        found = next(rows, None)
        if found is None:
            self.visited.clear()
            return 0
        return found

    def visit(self, row: int) -> None:
        """Note that somebody went there."""
        self.visited.add(self._rows[row].key)
        self.dataChanged.emit(self.index(row, 0), self.index(row, len(_HEADINGS) - 1))

    def rowCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(_HEADINGS)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return _HEADINGS[section]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(section)
        return _TIPS.get(section) if role == Qt.ItemDataRole.ToolTipRole else None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role == Qt.ItemDataRole.SizeHintRole:
            return QSize(0, QFontMetrics(QApplication.font()).height() + 6)
        one, column = self._rows[index.row()], index.column()
        if role == Qt.ItemDataRole.DisplayRole:
            words = f"check: {one.reason}" if one.click_there else one.reason
            label = one.landmark.replace("_", " ")
            gains = (f"{one.gain_deg:.2f}", f"{one.over_frames_deg:.1f}")
            return (str(one.frame), one.camera, label, *gains, words)[column]
        if role == Qt.ItemDataRole.ToolTipRole:
            return (
                f"{one.reason}\nExpected gain of a click here: {one.gain_deg:.2f}° in this frame, "
                f"{one.over_frames_deg:.1f}° over all frames."
            )
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        if role == Qt.ItemDataRole.DecorationRole and column == 2:
            return swatch(self._colours.get(one.landmark, "#808080"))
        if role == Qt.ItemDataRole.ForegroundRole:
            theme = current_theme()
            if one.key in self.visited:
                return QColor(theme.muted)
            return QColor(theme.warning) if one.click_there and column == 5 else None
        return None


class NextPanel(QWidget):
    """A stop sign in words, the wanted accuracy, and the suggestions below.

    Signals
    -------
    visit_requested : int, str, str
        Frame, camera and landmark.
    wanted_changed : float
        Degrees.
    limited : bool
        Look only at the selected frames.
    fit_requested : ()
        The body shall be fitted to the whole recording.
    """

    visit_requested = Signal(int, str, str)
    wanted_changed = Signal(float)
    limited = Signal(bool)
    fit_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.model = SuggestionModel()
        self.sign = QLabel()
        self.sign.setWordWrap(True)
        self.wanted = QDoubleSpinBox()
        self.wanted.setRange(0.1, 45.0)
        self.wanted.setSingleStep(0.5)
        self.wanted.setDecimals(1)
        self.wanted.setValue(3.0)
        self.wanted.setPrefix("± ")
        self.wanted.setSuffix("°")
        self.wanted.setKeyboardTracking(False)
        self.wanted.setAccessibleName("Target uncertainty")
        self.wanted.setToolTip(
            "Target uncertainty. Suggestions stop when all limbs are within this angle."
        )
        self.wanted.valueChanged.connect(self.wanted_changed)
        self.limit = QCheckBox("Selected frames only")
        self.limit.setToolTip("Suggest clicks only in the frames selected in the timeline")
        self.limit.toggled.connect(self.limited)
        self.next_button = QPushButton("Go to next")
        self.next_button.clicked.connect(self.go_to_next)
        self._none = QLabel(_NOT_FITTED)
        self._none.setWordWrap(True)
        self._none.setProperty("role", "muted")
        self.fit_button = QPushButton("Fit whole recording")
        self.fit_button.clicked.connect(self.fit_requested)
        self.tree = QTreeView()
        self.reason = QLabel()
        self.reason.setWordWrap(True)
        self.reason.setContentsMargins(8, 3, 8, 4)
        self.reason.setProperty("role", "muted")
        self._dress_tree()
        self._lay_out()
        self._sign: StopSign | None = None
        self._doubted = False
        self.show_ranking((), None, {})

    def _dress_tree(self) -> None:
        self.tree.setModel(self.model)
        self.tree.setRootIsDecorated(False)
        self.tree.setUniformRowHeights(True)
        self.tree.setAllColumnsShowFocus(True)
        self.tree.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.tree.setAccessibleName("Suggested clicks")
        self.tree.clicked.connect(self._on_chosen)
        self.tree.activated.connect(self._on_chosen)
        self.tree.selectionModel().currentRowChanged.connect(self._show_reason)
        header = self.tree.header()
        header.setStretchLastSection(True)
        metrics = self.fontMetrics()
        widest_texts = ("Frame", "W_right", "right shoulder", "Gain [°]", "All [°] ")
        for column, widest in enumerate(widest_texts):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Interactive)
            swatch = 16 if column == 2 else 0
            header.resizeSection(column, metrics.horizontalAdvance(widest) + 20 + swatch)

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.addWidget(self.next_button)
        row.addWidget(self.limit)
        row.addStretch(1)
        row.addWidget(self.wanted)
        self._head = QWidget()
        head = QVBoxLayout(self._head)
        head.setContentsMargins(8, 4, 8, 4)
        head.setSpacing(4)
        head.addWidget(self.sign)
        head.addLayout(row)
        self._unfitted = QWidget()
        unfitted = QVBoxLayout(self._unfitted)
        unfitted.setContentsMargins(10, 10, 10, 10)
        unfitted.addWidget(self._none)
        unfitted.addWidget(self.fit_button, 0, Qt.AlignmentFlag.AlignLeft)
        unfitted.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self._unfitted, 1)
        layout.addWidget(self._head)
        layout.addWidget(self.tree, 1)
        layout.addWidget(self.reason)

    def show_wanted(self, degrees: float) -> None:
        """Show the wanted accuracy without a signal."""
        blocked = self.wanted.blockSignals(True)
        self.wanted.setValue(degrees)
        self.wanted.blockSignals(blocked)

    def show_ranking(
        self, rows: Sequence[Suggestion], sign: StopSign | None, colours: Mapping[str, str]
    ) -> None:
        """Show what to click next; without a stop sign nothing is fitted yet."""
        self._sign = sign
        self._unfitted.setVisible(sign is None)
        self._head.setVisible(sign is not None)
        self.tree.setVisible(sign is not None)
        current = self.tree.currentIndex()
        key = self.model.suggestion(current.row()).key if current.isValid() else None
        self.model.show(rows, colours)
        places = [place for place, one in enumerate(rows[:_KEPT]) if one.key == key]
        if places:
            self.tree.setCurrentIndex(self.model.index(places[0], 0))
        self._show_reason()
        self.reason.setVisible(sign is not None and bool(rows))
        self.next_button.setEnabled(bool(rows))
        if sign is not None:
            words = sign.words()
            self._doubted = sign.reached and any(one.click_there for one in rows)
            if self._doubted:
                words += ", once the outlying clicks are corrected"
            self.sign.setText(f"{words[:1].upper()}{words[1:]}.")
            self._dress_sign()

    @Slot()
    def go_to_next(self) -> None:
        """Go to the best place that nobody went to yet."""
        row = self.model.first_unvisited()
        if row is not None:
            self._go_to(row)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # what is left out is said below the list
        for column in (4, 5):
            self.tree.setColumnHidden(column, self.width() < _NARROW)

    @Slot()
    def _show_reason(self) -> None:
        """Write the reason of the chosen row, or of the best one, where there is room for it."""
        row = max(self.tree.currentIndex().row(), 0)
        if row < self.model.rowCount():
            one = self.model.suggestion(row)
            place = f"{one.frame}, {one.landmark.replace('_', ' ')} in {one.camera}"
            self.reason.setText(f"{place}: {self.model.index(row, 5).data()}.")

    def changeEvent(self, event: Any) -> None:
        super().changeEvent(event)
        if event.type() == event.Type.PaletteChange and self._sign is not None:
            self._dress_sign()

    def _dress_sign(self) -> None:
        theme = current_theme()
        reached = self._sign is not None and self._sign.reached
        colour = theme.text if not reached else theme.warning if self._doubted else theme.good
        sheet = f"color: {colour}; font-weight: 600;"
        if sheet != self.sign.styleSheet():
            self.sign.setStyleSheet(sheet)

    @Slot(QModelIndex)
    def _on_chosen(self, index: QModelIndex) -> None:
        self._go_to(index.row())

    def _go_to(self, row: int) -> None:
        one = self.model.suggestion(row)
        self.tree.setCurrentIndex(self.model.index(row, 0))
        self.model.visit(row)
        self.visit_requested.emit(one.frame, one.camera, one.landmark)


def _alignment(column: int) -> Qt.AlignmentFlag:
    side = Qt.AlignmentFlag.AlignRight if column in _NUMBERS else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter
