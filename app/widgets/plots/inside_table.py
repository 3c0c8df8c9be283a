"""A small table that is as high as what it holds."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent, QWheelEvent
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..style.limb_colours import LIMB_COLOURS
from ..tables.cells import RIGHT, dress_table, make_bold, swatch
from .inside_content import Table

_NARROWEST_WORDS = 72


class _Grid(QTableWidget):
    """Scrolls with the page, not by itself."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()

    def sizeHint(self) -> QSize:
        rows = sum(self.rowHeight(i) for i in range(self.rowCount()))
        bar = self.horizontalScrollBar()
        under = bar.sizeHint().height() if self.horizontalHeader().length() > self.width() else 0
        return QSize(200, self.horizontalHeader().sizeHint().height() + rows + under + 4)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.fit()

    def fit(self) -> None:
        """Give words the room that numbers leave, and be as high as all rows."""
        header = self.horizontalHeader()
        if not header.count():
            return
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        left = self.viewport().width() - header.length() + header.sectionSize(0)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(0, max(left, _NARROWEST_WORDS))
        self.setFixedHeight(self.sizeHint().height())


class InsideTable(QWidget):
    """Title over rows of words and numbers."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title = QLabel(self)
        self._title.setProperty("role", "muted")
        self._title.setWordWrap(True)
        self.grid = _Grid(self)
        dress_table(self.grid, "", room=5)
        self.grid.setTextElideMode(Qt.TextElideMode.ElideMiddle)  # names differ at their ends
        self.grid.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.grid.horizontalHeader().setMinimumSectionSize(24)
        self.grid.horizontalHeader().setStyleSheet("QHeaderView::section { padding: 2px 5px; }")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 4, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self._title)
        layout.addWidget(self.grid)

    def show_table(self, shown: Table) -> None:
        """Show other rows."""
        self._title.setText(shown.title)
        self.grid.setAccessibleName(shown.title)
        self.grid.clearContents()
        self.grid.setColumnCount(len(shown.headings))
        self.grid.setRowCount(len(shown.rows))
        for column, heading in enumerate(shown.headings):
            item = QTableWidgetItem(heading)
            item.setToolTip(shown.tips[column] if shown.tips else heading)
            if column:
                item.setTextAlignment(RIGHT)
            self.grid.setHorizontalHeaderItem(column, item)
        for row, cells in enumerate(shown.rows):
            for column, text in enumerate(cells):
                item = QTableWidgetItem(text)
                item.setToolTip(text if not column else "")
                if column:
                    item.setTextAlignment(RIGHT)
                elif shown.limbs:
                    colour = LIMB_COLOURS.get(shown.limbs[row])
                    item.setData(Qt.ItemDataRole.DecorationRole, swatch(colour))
                if row in shown.strong:
                    make_bold(item)
                self.grid.setItem(row, column, item)
        self.grid.fit()
