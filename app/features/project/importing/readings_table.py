"""What was tried to read a calibration whose unit or convention is open."""

from __future__ import annotations

from PySide6.QtWidgets import QAbstractItemView, QTableWidget, QTableWidgetItem, QWidget

from stereotrack_core.tables import Table

from ....widgets.tables.table import RIGHT


class ReadingsTable(QTableWidget):
    """A table of the core, to be read; hidden where there is none."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Readings that were tried")
        self.setToolTip("What each unit or convention would mean; choose the one that is right")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.verticalHeader().hide()
        self.hide()

    def show_table(self, table: Table | None) -> None:
        """Show the rows of a table; None hides it."""
        self.setVisible(table is not None)
        if table is None:
            return
        self.setRowCount(len(table.rows))
        self.setColumnCount(len(table.columns))
        self.setHorizontalHeaderLabels([heading.lstrip(">") for heading in table.columns])
        for row, cells in enumerate(table.rows):
            for column, (heading, text) in enumerate(zip(table.columns, cells, strict=True)):
                item = QTableWidgetItem(text)
                if heading.startswith(">"):
                    item.setTextAlignment(RIGHT)
                self.setItem(row, column, item)
        self.resizeColumnsToContents()
