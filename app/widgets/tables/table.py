"""The tables of the workbench: one model, whose columns and cells are data, and its views."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

from PySide6.QtCore import (
    QAbstractItemModel,
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QFont, QFontDatabase, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QSizePolicy,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QTreeView,
    QWidget,
)

from stereotrack_core.tables import Table

from ..style.building import label, vbox
from ..style.theme import current_theme

Index: TypeAlias = QModelIndex | QPersistentModelIndex
RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
TOP = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop
LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
VALUE = Qt.ItemDataRole.UserRole
"""Role of what rows are sorted by."""

_NOWHERE = QModelIndex()
_Row = TypeVar("_Row")


@dataclass(frozen=True)
class Column:
    """A heading with its tip, and how its cells are written."""

    heading: str
    tip: str = ""
    align: Qt.AlignmentFlag = LEFT
    even: bool = False
    """In letters of one width."""


@dataclass(frozen=True)
class Cell:
    """What one cell shows."""

    text: str = ""
    tip: str = ""
    colour: str = ""
    """Name of the theme's colour that it is written in, such as ``muted``; empty: as text."""
    swatch: str | None = None
    """``#rrggbb`` of a square before the text; empty leaves room for one."""
    bold: bool = False
    background: str = ""
    said: str = ""
    """What a screen reader says in place of the text."""
    value: Any = None
    """What rows are sorted by where that is not the text, or what the program calls the row."""


CellRow: TypeAlias = Sequence[Cell]


def _as_it_is(row: Any) -> CellRow:
    cells: CellRow = row
    return cells


class TableModel(QAbstractTableModel, Generic[_Row]):
    """Rows of any kind under columns; `cells` says what a row shows, where rows are not cells."""

    def __init__(
        self, columns: Iterable[Column] = (), cells: Callable[[_Row], CellRow] = _as_it_is
    ) -> None:
        super().__init__()
        self.columns = tuple(columns)
        self.rows: Sequence[_Row] = ()
        self._cells_of = cells
        self._cells: dict[int, Sequence[Cell]] = {}
        self._even = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)

    def show(self, rows: Sequence[_Row], columns: Iterable[Column] | None = None) -> None:
        """Show these; what is selected stays where there are as many rows and columns as before."""
        wanted = self.columns if columns is None else tuple(columns)
        same = len(rows) == len(self.rows) and wanted == self.columns
        if not same:
            self.beginResetModel()
        self.rows, self.columns = rows, wanted
        self.forget()
        if not same:
            self.endResetModel()
        elif rows:
            self.tell(0, len(rows) - 1)

    def tell(self, first: int, last: int) -> None:
        """Say that these rows show something else now."""
        self.forget()
        self.dataChanged.emit(self.index(first, 0), self.index(last, len(self.columns) - 1))

    def forget(self) -> None:
        """Ask again what rows show."""
        self._cells.clear()

    def cell(self, row: int, column: int) -> Cell:
        """What a cell shows."""
        if row not in self._cells:
            self._cells[row] = self._cells_of(self.rows[row])
        return self._cells[row][column]

    def as_text(self, rows: Iterable[int]) -> str:
        """Rows with tabs between their cells, for a spreadsheet."""
        columns = range(len(self.columns))
        return "\n".join("\t".join(self.cell(k, c).text for c in columns) for k in rows)

    def rowCount(self, parent: Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self.columns)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        column = self.columns[section]
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return column.heading
            case Qt.ItemDataRole.ToolTipRole:
                return column.tip
            case Qt.ItemDataRole.TextAlignmentRole:
                return LEFT if column.align == TOP else column.align
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        cell, column = self.cell(index.row(), index.column()), self.columns[index.column()]
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return cell.text
            case Qt.ItemDataRole.ToolTipRole:
                return cell.tip
            case Qt.ItemDataRole.AccessibleTextRole:
                return cell.said or None
            case Qt.ItemDataRole.TextAlignmentRole:
                return column.align
            case Qt.ItemDataRole.DecorationRole if cell.swatch is not None:
                return swatch(cell.swatch)
            case Qt.ItemDataRole.ForegroundRole if cell.colour:
                return QColor(getattr(current_theme(), cell.colour))
            case Qt.ItemDataRole.BackgroundRole if cell.background:
                return QColor(getattr(current_theme(), cell.background))
            case Qt.ItemDataRole.FontRole if column.even or cell.bold:
                return self._font(cell, column)
            case _ if role == VALUE:
                return cell.text if cell.value is None else cell.value
        return None

    def _font(self, cell: Cell, column: Column) -> QFont:
        font = QFont(self._even) if column.even else QFont()
        font.setBold(cell.bold)
        return font


class RowDelegate(QStyledItemDelegate):
    """Rows a little higher than their text, chosen as a whole: no single cell is framed."""

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        option.state &= ~QStyle.StateFlag.State_HasFocus

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(super().sizeHint(option, index).width(), option.fontMetrics.height() + 6)


def dress_table(table: QTableView, name: str, room: int = 8) -> None:
    """Make a table of rows that are read: no grid, no row numbers, `room` pixels beside words."""
    table.setAccessibleName(name)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setFrameShape(QTableView.Shape.NoFrame)
    table.setShowGrid(False)
    table.setAlternatingRowColors(True)
    table.setWordWrap(False)
    table.setTabKeyNavigation(False)
    table.verticalHeader().hide()
    table.verticalHeader().setDefaultSectionSize(table.fontMetrics().height() + room)
    table.horizontalHeader().setHighlightSections(False)


def new_table(
    model: QAbstractItemModel, name: str, room: int = 8, view: QTableView | None = None
) -> QTableView:
    """Make a view of rows that are read, or dress this one; see :func:`dress_table`."""
    table = view or QTableView()
    table.setModel(model)
    dress_table(table, name, room)
    return table


def select_cells(table: QTableView) -> None:
    """Let blocks of cells be selected instead of rows."""
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
    table.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)


def dress_list(tree: QTreeView, name: str, widths: Sequence[int | None]) -> None:
    """Make a list with columns of these widths in pixels; those without share the rest."""
    tree.setAccessibleName(name)
    tree.setRootIsDecorated(False)
    tree.setUniformRowHeights(True)
    tree.setAllColumnsShowFocus(True)
    tree.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    header = tree.header()
    header.setStretchLastSection(False)
    for column, width in enumerate(widths):
        if width is None:
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Stretch)
        else:
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Interactive)
            header.resizeSection(column, width)


def selected_rows(view: QAbstractItemView) -> list[int]:
    """Rows that are selected, ascending."""
    return sorted(index.row() for index in view.selectionModel().selectedRows())


def swatch(colour: str | None, size: int = 10) -> QPixmap:
    """Return a square of that colour; a transparent one for none keeps words in line."""
    result = QPixmap(size, size)
    result.fill(QColor(colour) if colour else Qt.GlobalColor.transparent)
    return result


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
