"""Rows under rows, such as the cameras of the rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View

from ..style.building import vbox
from ..style.theme import current_theme
from .table import Cell, CellRow, Column, dress_list, swatch


@dataclass(frozen=True)
class TreeRow:
    """A row and those under it."""

    cells: CellRow
    rows: tuple[TreeRow, ...] = ()
    open: bool = True
    """Whether the rows under it are seen at first."""


class CellTree(QTreeWidget):
    """Rows under rows; what a person has opened or closed stays so."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._columns: tuple[Column, ...] = ()
        self._rows: tuple[TreeRow, ...] = ()
        dress_list(self, name, ())
        self.setRootIsDecorated(True)

    def show_rows(self, columns: Sequence[Column], rows: Sequence[TreeRow]) -> bool:
        """Show these; tells whether the columns are others than before."""
        anew = tuple(columns) != self._columns
        if anew:
            self._columns = tuple(columns)
            self.setColumnCount(len(columns))
            self.setHeaderLabels([column.heading for column in columns])
            for place, column in enumerate(columns):
                self.headerItem().setToolTip(place, column.tip)
                self.headerItem().setTextAlignment(place, column.align)
        if anew or tuple(rows) != self._rows:
            self._rows = tuple(rows)
            self._write()
        return anew

    def _write(self) -> None:
        heads = [self.topLevelItem(place) for place in range(self.topLevelItemCount())]
        was_open = {head.text(0): head.isExpanded() for head in heads if head is not None}
        self.clear()
        for row in self._rows:
            item = self._item(row)
            self.addTopLevelItem(item)
            item.setFirstColumnSpanned(len(row.cells) == 1)
            item.setExpanded(was_open.get(item.text(0), row.open))

    def _item(self, row: TreeRow) -> QTreeWidgetItem:
        item = QTreeWidgetItem([cell.text for cell in row.cells])
        for place, (cell, column) in enumerate(zip(row.cells, self._columns, strict=False)):
            item.setToolTip(place, cell.tip)
            item.setTextAlignment(place, column.align)
            if cell.swatch:
                item.setData(place, Qt.ItemDataRole.DecorationRole, swatch(cell.swatch))
            if cell.colour:
                item.setForeground(place, QColor(getattr(current_theme(), cell.colour)))
            if cell.bold:
                font = self.font()
                font.setBold(True)
                item.setFont(place, font)
        item.addChildren([self._item(child) for child in row.rows])
        return item

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._write()
        super().changeEvent(event)


_RIG = tuple(
    Column(heading, tip)
    for heading, tip in {
        "Camera": "View and its cameras",
        "Size": "Image size in pixels",
        "f x, f y": "Focal lengths in pixels",
        "c x, c y": "Principal point in pixels",
        "Distortion": "Lens distortion at the image corner, in pixels",
        "Position [m]": "Optical centre in world coordinates: x east, y north, z up",
        "Direction": "Compass direction and inclination of the optical axis",
    }.items()
)
_WINDS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")


class RigPanel(QWidget):
    """A row per view, and below it a row per camera: intrinsics, place and where it looks."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._found: dict[str, str] = {}
        self._recording: Recording | None = None
        self.tree = CellTree("Cameras of the rig")
        self.tree.setIndentation(14)
        self.tree.header().setStretchLastSection(True)
        self.tree.show_rows(_RIG, ())
        self.setLayout(vbox((self.tree, 1)))

    def show_findings(self, found: Mapping[str, str]) -> None:
        """Mark cameras that something is wrong with: what it is, by name."""
        self._found = dict(found)
        self._show()

    def show_rig(self, recording: Recording | None) -> None:
        """Show the cameras of a recording."""
        self._recording = recording
        self._show()
        if recording is None:
            return
        for column in range(1, len(_RIG)):
            self.tree.resizeColumnToContents(column)
        widest = max(self.fontMetrics().horizontalAdvance(name) for name in recording.cameras)
        self.tree.setColumnWidth(0, widest + 3 * self.tree.indentation() + 8)

    def _show(self) -> None:
        recording = self._recording
        views = () if recording is None else recording.views
        self.tree.show_rows(_RIG, [self._view_row(view, recording) for view in views if recording])

    def _view_row(self, view: View, recording: Recording) -> TreeRow:
        reference = recording.reference_camera(view)
        words: str = view.kind
        cameras = [reference]
        if view.left is not None:
            left = recording.cameras[view.left.camera]
            baseline = float(np.linalg.norm(left.position_world - reference.position_world))
            words = f"stereo, baseline {1000.0 * baseline:.1f} mm"
            cameras.insert(0, left)
        rows = tuple(TreeRow(_camera_cells(one, self._found.get(one.name, ""))) for one in cameras)
        return TreeRow((Cell(f"View {view.name}: {words}"),), rows)


def _camera_cells(camera: Camera, wrong: str) -> CellRow:
    """What the rig panel says about a camera, column by column."""
    K, place = camera.matrix, camera.position_world
    texts = (
        f"{camera.width} × {camera.height}",
        _pair(K[0, 0], K[1, 1]),
        f"{K[0, 2]:.1f}, {K[1, 2]:.1f}",
        f"{_corner_distortion(camera):.1f} px",
        f"{place[0]:.2f}, {place[1]:.2f}, {place[2]:.2f}",
        _direction_words(camera),
    )
    name = Cell(camera.name, wrong, "warning" if wrong else "")
    return (name, *(Cell(text) for text in texts))


def _pair(a: float, b: float) -> str:
    return f"{a:.1f}" if abs(a - b) < 0.05 else f"{a:.1f}, {b:.1f}"


def _corner_distortion(camera: Camera) -> float:
    """Pixels by which the lens displaces the picture's corner from where a pinhole has it."""
    corner = np.array([camera.width - 1.0, camera.height - 1.0])
    ideal = camera.matrix[:2, :2] @ camera.normalised(corner) + camera.matrix[:2, 2]
    return float(np.linalg.norm(ideal - corner))


def _direction_words(camera: Camera) -> str:
    """Where a camera looks, such as ``SE, 15° down``."""
    axis = camera.world_from_camera.rotation[:, 2]
    bearing = np.degrees(np.arctan2(axis[0], axis[1])) % 360.0
    wind = _WINDS[round(bearing / 45.0) % 8]
    tilt = np.degrees(np.arcsin(np.clip(axis[2], -1.0, 1.0)))
    return f"{wind}, {abs(tilt):.0f}° {'up' if tilt > 0 else 'down'}"


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
