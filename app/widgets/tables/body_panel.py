"""How well clicks fix each limb, and the clicked lengths beside the subject's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QHeaderView, QTreeView, QWidget

from ..style.building import label, vbox
from ..style.limb_colours import LIMB_COLOURS
from .table import RIGHT, Cell, Column, TableModel, dress_list


@dataclass(frozen=True)
class BodyRow:
    """A limb or a length in the body panel."""

    limb: str
    """One of the limbs, for its colour; empty for a length."""
    label: str
    value: str
    words: str = ""
    doubtful: bool = False


class BodyPanel(QWidget):
    """A line of words, the limbs, the lengths; and whether measured depth is used."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.with_depth = QCheckBox("Use depth")
        self.with_depth.setToolTip(
            "Fit the body to the measured points as well as to the clicks, where the recording "
            "has depth."
        )
        self.words = label(margins=(6, 2, 6, 2))
        self.words.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        columns = (Column(""), Column("", "", RIGHT, even=True), Column(""))
        self.model = TableModel(columns, _cells)
        self.tree = QTreeView()
        self.tree.setModel(self.model)
        dress_list(self.tree, "Uncertainty of the body fit", (0, 0, None))
        self.tree.setHeaderHidden(True)
        self.tree.setToolTip(
            "± is the standard deviation of the limb direction, assuming correct clicks."
        )
        self.tree.setFrameShape(QTreeView.Shape.NoFrame)
        self.tree.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.tree.setSelectionMode(QTreeView.SelectionMode.NoSelection)
        for column in (0, 1):
            self.tree.header().setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        parts = (self.words, (self.tree, 1), self.with_depth)
        self.setLayout(vbox(*parts, margins=(0, 2, 0, 0), spacing=2))

    def show_body(
        self, words: Sequence[str], limbs: Sequence[BodyRow], lengths: Sequence[BodyRow]
    ) -> None:
        """Show the most important words first, then every limb and length."""
        self.words.setText("\n".join(words))
        self.words.setVisible(bool(words))
        self.model.show([*limbs, *lengths])


def _cells(row: BodyRow) -> Sequence[Cell]:
    return (
        Cell(row.label, swatch=LIMB_COLOURS.get(row.limb)),
        Cell(row.value, colour="warning" if row.doubtful else "text"),
        Cell(row.words, row.words, "muted"),
    )
