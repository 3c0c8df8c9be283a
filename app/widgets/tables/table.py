"""The tables of the workbench: one model, whose columns and cells are data, and its views."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from PySide6 import QtCore, QtGui, QtWidgets
from PySide6.QtCore import Qt

from stereotrack_core.tables import Table

from ..redraw import takes_key
from ..style.building import label, vbox
from ..style.theme import current_theme

Index: TypeAlias = QtCore.QModelIndex | QtCore.QPersistentModelIndex
RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
TOP = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop
LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
VALUE = Qt.ItemDataRole.UserRole  # role of what rows are sorted by
STRETCH = -1  # width of a column that has the room that others leave
_COLOURS = (Qt.ItemDataRole.ForegroundRole, Qt.ItemDataRole.BackgroundRole)
_NOWHERE = QtCore.QModelIndex()
_MEASURED_ROWS = 50
"""Rows by whose words a column's width is found; measuring thousands would take its time."""


@dataclass(frozen=True)
class Column:
    """A heading with its tip, and how its cells are written."""

    heading: str
    tip: str = ""
    align: Qt.AlignmentFlag = LEFT
    even: bool = False  # in letters of one width
    width: int = 0  # pixels; 0: as its words are wide, :data:`STRETCH`: what is left


@dataclass(frozen=True)
class Cell:
    """What one cell shows."""

    text: str = ""
    tip: str = ""
    colour: str = ""
    """Colour of the theme that it is written in, such as ``muted``, or ``#rrggbb``; empty: text."""
    swatch: str | QtGui.QPixmap | None = None
    """``#rrggbb`` of a square before the text, or a picture; empty leaves room for a square."""
    bold: bool = False
    background: str = ""
    said: str = ""  # what a screen reader says in place of the text
    value: Any = None
    """What rows are sorted by where that is not the text, or what the program calls the row."""
    ticked: bool | None = None  # in a tree: whether a box before it is ticked; None: it has none
    editable: bool = False  # in a tree: whether a person can change the text


CellRow: TypeAlias = Sequence[Cell]


class TableModel(QtCore.QAbstractTableModel):
    """Rows of any kind under columns; `cells` says what a row shows, where rows are not cells."""

    def __init__(self, columns: Iterable[Column], cells: Callable[[Any], CellRow]) -> None:
        super().__init__()
        self.columns = tuple(columns)
        self.rows: Sequence[Any] = ()
        self._cells_of = cells
        self._cells: dict[int, Sequence[Cell]] = {}
        self._roles: dict[tuple[int, int], dict[int, Any]] = {}
        self._even = QtGui.QFontDatabase.systemFont(QtGui.QFontDatabase.SystemFont.FixedFont)

    def show(self, rows: Sequence[Any], columns: Iterable[Column] | None = None) -> None:
        """Show these; what is selected stays where there are as many rows and columns as before."""
        wanted = self.columns if columns is None else tuple(columns)
        if len(rows) == len(self.rows) and wanted == self.columns:
            self.rows = rows
            self.look_again()
            return
        self.beginResetModel()
        self.rows, self.columns = rows, wanted
        self._cells, self._roles = {}, {}
        self.endResetModel()

    def look_again(self) -> None:
        """Say which rows show something else now; of those that nobody asked for nothing is."""
        before, self._cells, self._roles = self._cells, {}, {}
        changed = [row for row, cells in before.items() if self.row_cells(row) != cells]
        if changed:
            last = self.index(max(changed), len(self.columns) - 1)
            self.dataChanged.emit(self.index(min(changed), 0), last)

    def row_cells(self, row: int) -> CellRow:
        if row not in self._cells:
            self._cells[row] = self._cells_of(self.rows[row])
        return self._cells[row]

    def cell(self, row: int, column: int) -> Cell:
        return self.row_cells(row)[column]

    def rowCount(self, parent: Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self.columns)

    def headerData(
        self,
        section: int,
        orientation: Qt.Orientation,
        role: int = Qt.ItemDataRole.DisplayRole,
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        column = self.columns[section]
        said = {
            Qt.ItemDataRole.DisplayRole: column.heading,
            Qt.ItemDataRole.ToolTipRole: column.tip,
            Qt.ItemDataRole.TextAlignmentRole: LEFT if column.align == TOP else column.align,
        }
        return said.get(Qt.ItemDataRole(role))

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        place = index.row(), index.column()
        if place not in self._roles:  # asked for seven times whenever a cell is painted
            self._roles[place] = self._roles_of(self.cell(*place), place[1])
        shown = self._roles[place].get(role)
        if shown and role in _COLOURS:
            return QtGui.QColor(getattr(current_theme(), shown, shown))
        return shown

    def _roles_of(self, cell: Cell, column: int) -> dict[int, Any]:
        roles = Qt.ItemDataRole
        return {
            roles.DisplayRole: cell.text,
            roles.ToolTipRole: cell.tip,
            roles.AccessibleTextRole: cell.said or None,
            roles.TextAlignmentRole: self.columns[column].align,
            roles.DecorationRole: None if cell.swatch is None else swatch(cell.swatch),
            roles.ForegroundRole: cell.colour or None,
            roles.BackgroundRole: cell.background or None,
            roles.FontRole: self.font(cell, column),
            VALUE: cell.text if cell.value is None else cell.value,
        }

    def font(self, cell: Cell, column: int) -> QtGui.QFont | None:
        """Letters of a cell; None for those of the table."""
        even = self.columns[column].even
        if not even and not cell.bold:
            return None
        font = QtGui.QFont(self._even) if even else QtGui.QFont()
        font.setBold(cell.bold)
        return font


class RowDelegate(QtWidgets.QStyledItemDelegate):
    """Rows a little higher than their text, chosen as a whole: no single cell is framed."""

    def initStyleOption(self, option: QtWidgets.QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        option.state &= ~QtWidgets.QStyle.StateFlag.State_HasFocus
        if not option.icon.isNull():  # Qt would tint it in a selected row
            icon = QtGui.QIcon(option.icon)
            icon.addPixmap(icon.pixmap(option.decorationSize), QtGui.QIcon.Mode.Selected)
            option.icon = icon

    def sizeHint(self, option: QtWidgets.QStyleOptionViewItem, index: Index) -> QtCore.QSize:
        lines = str(index.data() or "").count("\n") + 1
        height = lines * option.fontMetrics.lineSpacing() + 6
        return QtCore.QSize(super().sizeHint(option, index).width(), height)


def dress_list(tree: QtWidgets.QTreeView, name: str, widths: Sequence[int] = ()) -> None:
    """Make a list of rows that are read, with columns of these widths, see :class:`Column`."""
    tree.setAccessibleName(name)
    tree.setRootIsDecorated(False)
    tree.setUniformRowHeights(True)
    tree.setAllColumnsShowFocus(True)
    tree.setEditTriggers(QtWidgets.QTreeView.EditTrigger.NoEditTriggers)
    header, modes = tree.header(), QtWidgets.QHeaderView.ResizeMode
    header.setStretchLastSection(False)
    header.setMinimumSectionSize(24)
    header.setResizeContentsPrecision(_MEASURED_ROWS)
    for column, width in enumerate(widths):
        header.setSectionResizeMode(column, modes.Interactive if width else modes.ResizeToContents)
        if width > 0:
            header.resizeSection(column, width)


def fit_list(tree: QtWidgets.QTreeView, widths: Sequence[int], least: int) -> None:
    """Give the column that stretches what the others leave, and `least` pixels at least."""
    if STRETCH in widths:
        header, place = tree.header(), widths.index(STRETCH)
        others = header.length() - header.sectionSize(place)
        header.resizeSection(place, max(least, tree.viewport().width() - others))


class CellTable(QtWidgets.QTreeView):
    """Rows of cells; Ctrl+C copies those that are selected, or all.

    A screen reader calls it `name`; `columns` and `cells` are those of :class:`TableModel`. The
    column that stretches has `least` pixels at least. If it `sorts`, a click on a heading does; if
    `single`, one row at most is selected.
    """

    def __init__(
        self,
        name: str,
        columns: Iterable[Column] = (),
        cells: Callable[[Any], CellRow] = tuple,
        *,
        least: int = 72,
        sorts: bool = False,
        single: bool = False,
    ) -> None:
        super().__init__()
        self.cells = TableModel(columns, cells)
        self.sorted = QtCore.QSortFilterProxyModel(self)
        """The rows, sorted and filtered; shown if the table sorts."""
        self._least = least
        self.most = 0
        """Rows up to which it is as high as its rows; 0: it takes the height that it is given."""
        if sorts:
            self.sorted.setSortRole(VALUE)
            self.sorted.setSourceModel(self.cells)
        self.setModel(self.sorted if sorts else self.cells)
        self.setSortingEnabled(sorts)
        self.setFrameShape(QtWidgets.QTreeView.Shape.NoFrame)
        self.setAlternatingRowColors(True)
        modes = QtWidgets.QTreeView.SelectionMode
        self.setSelectionMode(modes.SingleSelection if single else modes.ExtendedSelection)
        self.setItemDelegate(RowDelegate(self))
        self._dress(name)

    def show_rows(self, rows: Sequence[Any], columns: Iterable[Column] | None = None) -> None:
        before = self.cells.columns
        self.cells.show(rows, columns)
        if self.cells.columns != before:
            self._dress(self.accessibleName())
        self._fit()

    def sizeHintForColumn(self, column: int) -> int:
        """Width of the words of the first rows, for which Qt would ask cell by cell."""
        frame = QtWidgets.QStyle.PixelMetric.PM_FocusFrameHMargin
        margin = self.style().pixelMetric(frame, None, self) + 1
        widest = 0
        for row in range(min(len(self.cells.rows), _MEASURED_ROWS)):
            cell = self.cells.cell(row, column)
            metrics = QtGui.QFontMetricsF(self.cells.font(cell, column) or self.font())
            lines = map(metrics.horizontalAdvance, cell.text.split("\n"))
            width = 2 * margin + math.ceil(max(lines))  # rounded down it would cut the last letter
            if cell.swatch is not None:
                width += 2 * margin + swatch(cell.swatch).deviceIndependentSize().toSize().width()
            widest = max(widest, width)
        return widest

    def selected(self) -> list[int]:
        """Places of the selected rows in what was shown, ascending."""
        return sorted(map(self.place_of, self.selectionModel().selectedRows()))

    def place_of(self, index: QtCore.QModelIndex) -> int:
        """Place of a row in what was shown; -1 for none."""
        sorts = self.model() is self.sorted
        return self.sorted.mapToSource(index).row() if sorts else index.row()

    def copied_text(self) -> str:
        """The selected rows, or all, with tabs between their cells, for a spreadsheet."""
        rows = map(self.cells.row_cells, self.selected() or range(len(self.cells.rows)))
        return "\n".join("\t".join(cell.text for cell in row) for row in rows)

    def event(self, event: QtCore.QEvent) -> bool:
        keys = {Qt.Key.Key_Return, Qt.Key.Key_Enter}
        activates = takes_key(event, lambda key: key.key() in keys and not key.modifiers())
        return activates or super().event(event)

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        if event.matches(QtGui.QKeySequence.StandardKey.Copy):
            QtGui.QGuiApplication.clipboard().setText(self.copied_text())
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _dress(self, name: str) -> None:
        dress_list(self, name, [column.width for column in self.cells.columns])

    def _fit(self) -> None:
        fit_list(self, [column.width for column in self.cells.columns], self._least)
        if self.most:
            rows = min(len(self.cells.rows), self.most)
            bar = self.horizontalScrollBar().sizeHint().height()
            under = bar if self.header().length() > self.viewport().width() else 0
            row = max(self.sizeHintForRow(0), 0)
            self.setFixedHeight(self.header().sizeHint().height() + rows * row + under + 2)


def swatch(colour: str | QtGui.QPixmap, size: int = 10) -> QtGui.QPixmap:
    """Return a square of that colour; a transparent one for none keeps words in line."""
    if isinstance(colour, QtGui.QPixmap):
        return colour
    result = QtGui.QPixmap(size, size)
    result.fill(QtGui.QColor(colour) if colour else Qt.GlobalColor.transparent)
    return result


class PlainTable(QtWidgets.QWidget):
    """A table under its title, `most` rows of it at once; nothing where there is none.

    `choose` is called with the first cell of the row that a person has chosen.
    """

    def __init__(
        self,
        name: str,
        most: int = 8,
        role: str = "heading",
        choose: Callable[[str], object] = lambda _text: None,
    ) -> None:
        super().__init__()
        self._choose = choose
        self.view = CellTable(name)
        self.view.most = most
        self.heading = label(name, role)
        self.setLayout(vbox(self.heading, self.view, spacing=2))
        self.view.selectionModel().currentRowChanged.connect(self._on_row)
        self.hide()

    def show_table(self, table: Table | None) -> None:
        if table is None:
            self.hide()
            return
        columns = [
            Column(one.removeprefix(">"), align=RIGHT if one.startswith(">") else LEFT)
            for one in table.columns
        ]
        if columns[-1].align == LEFT:
            columns[-1] = replace(columns[-1], width=STRETCH)
        rows = [[Cell(text, text) for text in row] for row in table.rows]
        self.show_cells(table.title, columns, rows)

    def show_cells(self, title: str, columns: Sequence[Column], rows: Sequence[CellRow]) -> None:
        self.heading.setText(title)
        self.view.setAccessibleName(title)
        self.view.show_rows(rows, columns)
        self.show()

    def _on_row(self) -> None:
        row = self.view.currentIndex().row()
        if 0 <= row < len(self.view.cells.rows):
            self._choose(self.view.cells.cell(row, 0).text)
