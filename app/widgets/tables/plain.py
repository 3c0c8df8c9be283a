"""A table of the core as it is, with its title above."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import QHeaderView, QSizePolicy, QTableView, QWidget

from stereotrack_core.tables import Table

from ..style.building import label, vbox
from .table import LEFT, RIGHT, Cell, Column, TableModel, new_table


class _Fitting(QTableView):
    """As high as its rows, up to some."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def sizeHint(self) -> QSize:
        model = self.model()
        rows = min(model.rowCount() if model is not None else 0, self._most)
        height = self.horizontalHeader().sizeHint().height() + 4
        height += rows * self.verticalHeader().defaultSectionSize()
        bar = self.horizontalScrollBar().sizeHint().height()
        return QSize(super().sizeHint().width(), height + bar)


class PlainTable(QWidget):
    """Shows one table, `most` rows of it at once; nothing where there is none."""

    chosen = Signal(str)
    """First cell of the row that a person has chosen."""

    def __init__(self, name: str, most: int = 8, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.model: TableModel[list[Cell]] = TableModel()
        self.view = new_table(self.model, name, view=_Fitting(most))
        self.view.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Maximum)
        self.view.setHorizontalScrollMode(QTableView.ScrollMode.ScrollPerPixel)
        self.heading = label(name, "heading")
        self.setLayout(vbox(self.heading, self.view, spacing=2))
        self.view.selectionModel().currentRowChanged.connect(self._on_row)
        self.hide()

    def show_table(self, table: Table | None) -> None:
        """Show this table."""
        self.setVisible(table is not None)
        if table is None:
            return
        self.heading.setText(table.title)
        columns = [
            Column(one.removeprefix(">"), align=RIGHT if one.startswith(">") else LEFT)
            for one in table.columns
        ]
        self.model.show([[Cell(text, text) for text in row] for row in table.rows], columns)
        header = self.view.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(not table.columns[-1].startswith(">"))
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.view.updateGeometry()

    def _on_row(self) -> None:
        row = self.view.currentIndex().row()
        if 0 <= row < len(self.model.rows):
            self.chosen.emit(self.model.cell(row, 0).text)
