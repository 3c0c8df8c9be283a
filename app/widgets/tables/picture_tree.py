"""Pictures of cameras, each with a tick and its error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem

from ..style.theme import current_theme
from .table import dress_list

_HEADINGS = ("Picture", "Corners", "Error (px)", "Remark")
_WIDTHS = (150, 64, 80, None)
_KEY = Qt.ItemDataRole.UserRole


@dataclass(frozen=True)
class PictureRow:
    """One picture; without corners it has no tick."""

    frame: int
    name: str
    ticked: bool = True
    corners: str = ""
    error: str = ""
    remark: str = ""
    colour: str = ""
    """Name of the theme's colour of its error; empty: as text."""


@dataclass(frozen=True)
class CameraRows:
    """The pictures of a camera, and what is said of them together."""

    camera: str
    summary: tuple[str, str, str]
    """Corners, error and remark."""
    rows: tuple[PictureRow, ...] = ()


class PictureTree(QTreeWidget):
    """A row per picture under a row per camera."""

    ticked = Signal(str, int, bool)
    """Camera and picture that a person has ticked or unticked."""
    chosen = Signal(str, int)
    """Camera and picture that is the current row."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[CameraRows, ...] = ()
        self.setColumnCount(len(_HEADINGS))
        self.setHeaderLabels(_HEADINGS)
        dress_list(self, "Pictures of the board", _WIDTHS)
        self.setRootIsDecorated(True)
        self.setIndentation(14)
        self.setAlternatingRowColors(True)
        self.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Interactive)
        self.headerItem().setToolTip(0, "Untick a picture to calculate without it")
        self.headerItem().setToolTip(2, "Root mean square error of its corners in pixels")
        self.itemChanged.connect(self._on_changed)
        self.currentItemChanged.connect(self._on_current)

    def show_pictures(self, cameras: Sequence[CameraRows]) -> None:
        """Show these; the current row, and what is closed, stays."""
        shown = tuple(cameras)
        if shown == self._shown:
            return
        before, self._shown = self._shown, shown
        with QSignalBlocker(self):
            if _keys(before) != _keys(shown):
                self._write()
            for camera, head in zip(shown, self._heads(), strict=True):
                _fill_head(head, camera)
                for item, row in zip(_children(head), camera.rows, strict=True):
                    _fill(item, row)

    def choose(self, camera: str, frame: int) -> None:
        """Make a picture the current row."""
        item = self.item_of(camera, frame)
        if item is not None:
            self.setCurrentItem(item)

    def item_of(self, camera: str, frame: int) -> QTreeWidgetItem | None:
        """The row of a picture."""
        children = (one for head in self._heads() for one in _children(head))
        return next((one for one in children if one.data(0, _KEY) == (camera, frame)), None)

    def _heads(self) -> list[QTreeWidgetItem]:
        found = (self.topLevelItem(k) for k in range(self.topLevelItemCount()))
        return [one for one in found if one is not None]

    def _write(self) -> None:
        current = self.currentItem()
        key = None if current is None else current.data(0, _KEY)
        closed = {head.text(0) for head in self._heads() if not head.isExpanded()}
        self.clear()
        for camera in self._shown:
            head = QTreeWidgetItem(self, [camera.camera])
            head.addChildren([_item(camera.camera, row) for row in camera.rows])
            head.setExpanded(camera.camera not in closed)
        if key is not None and (item := self.item_of(*key)) is not None:
            self.setCurrentItem(item)

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        key = item.data(0, _KEY)
        if column == 0 and key is not None:
            self.ticked.emit(*key, item.checkState(0) == Qt.CheckState.Checked)

    def _on_current(self, item: QTreeWidgetItem | None, _before: object) -> None:
        key = None if item is None else item.data(0, _KEY)
        if key is not None:
            self.chosen.emit(*key)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            shown, self._shown = self._shown, ()
            self.show_pictures(shown)
        super().changeEvent(event)


def _children(head: QTreeWidgetItem) -> list[QTreeWidgetItem]:
    found = (head.child(k) for k in range(head.childCount()))
    return [one for one in found if one is not None]


def _keys(cameras: Sequence[CameraRows]) -> list[tuple[str, int, bool]]:
    return [(one.camera, row.frame, bool(row.corners)) for one in cameras for row in one.rows]


def _item(camera: str, row: PictureRow) -> QTreeWidgetItem:
    item = QTreeWidgetItem([row.name])
    item.setData(0, _KEY, (camera, row.frame))
    item.setTextAlignment(1, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    item.setTextAlignment(2, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    if row.corners:
        item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
    return item


def _fill_head(item: QTreeWidgetItem, camera: CameraRows) -> None:
    for column, text in enumerate(camera.summary, start=1):
        item.setText(column, text)
        item.setToolTip(column, text)
        if column < 3:
            item.setTextAlignment(
                column, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            )
    font = item.font(0)
    font.setBold(True)
    item.setFont(0, font)


def _fill(item: QTreeWidgetItem, row: PictureRow) -> None:
    theme = current_theme()
    for column, text in enumerate((row.name, row.corners, row.error, row.remark)):
        item.setText(column, text)
        item.setToolTip(column, text)
        usual = theme.text if row.corners and row.ticked else theme.muted
        own = getattr(theme, row.colour) if row.colour and column == 2 else usual
        item.setForeground(column, QColor(own))
    if row.corners:
        item.setCheckState(0, Qt.CheckState.Checked if row.ticked else Qt.CheckState.Unchecked)
