"""How well clicks fix each limb, and the clicked lengths beside the subject's."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFontDatabase
from PySide6.QtWidgets import (
    QCheckBox,
    QHeaderView,
    QLabel,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import current_theme
from .cells import RIGHT
from .landmark_rows import BodyRow


class BodyPanel(QWidget):
    """A line of words, the limbs, the lengths; and whether measured depth is used.

    Attributes
    ----------
    with_depth : QCheckBox
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.with_depth = QCheckBox("Use depth")
        self.with_depth.setToolTip(
            "Fit the body to the measured points as well as to the clicks, where the recording "
            "has depth."
        )
        self.words = QLabel()
        self.words.setWordWrap(True)
        self.words.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.words.setContentsMargins(6, 2, 6, 2)
        self.tree = QTreeWidget()
        self.tree.setColumnCount(3)
        self.tree.setHeaderHidden(True)
        self.tree.setRootIsDecorated(False)
        self.tree.setIndentation(10)
        self.tree.setToolTip(
            "± is the standard deviation of the limb direction, assuming correct clicks."
        )
        self.tree.setFrameShape(QTreeWidget.Shape.NoFrame)
        self.tree.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.tree.setSelectionMode(QTreeWidget.SelectionMode.NoSelection)
        self.tree.setAccessibleName("Uncertainty of the body fit")
        header = self.tree.header()
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.Stretch)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 2, 0, 0)
        column.setSpacing(2)
        column.addWidget(self.words)
        column.addWidget(self.tree, 1)
        column.addWidget(self.with_depth)
        self._digits = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)

    def show_body(
        self, words: Sequence[str], limbs: Sequence[BodyRow], lengths: Sequence[BodyRow]
    ) -> None:
        """Show the most important words first, then every limb and length."""
        self.words.setText("\n".join(words))
        self.words.setVisible(bool(words))
        rows = [*limbs, *lengths]
        while self.tree.topLevelItemCount() > len(rows):
            self.tree.takeTopLevelItem(self.tree.topLevelItemCount() - 1)
        while self.tree.topLevelItemCount() < len(rows):
            self.tree.addTopLevelItem(QTreeWidgetItem(["", "", ""]))
        for place, row in enumerate(rows):
            item = self.tree.topLevelItem(place)
            if item is not None:
                self._fill(item, row)

    def _fill(self, item: QTreeWidgetItem, row: BodyRow) -> None:
        theme = current_theme()
        for column, text in enumerate((row.label, row.value, row.words)):
            item.setText(column, text)
        item.setToolTip(2, row.words)
        item.setFont(1, self._digits)
        item.setTextAlignment(1, RIGHT)
        swatch = LIMB_COLOURS.get(row.limb)
        item.setData(0, Qt.ItemDataRole.DecorationRole, QColor(swatch) if swatch else None)
        item.setForeground(1, QColor(theme.warning if row.doubtful else theme.text))
        item.setForeground(2, QColor(theme.muted))
