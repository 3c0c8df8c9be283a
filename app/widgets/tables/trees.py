"""Rows under rows, such as the cameras of the rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import QTreeWidget, QTreeWidgetItem, QWidget

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View

from ..style.building import vbox
from ..style.theme import current_theme
from .table import STRETCH, VALUE, Cell, CellRow, Column, dress_list, fit_list, swatch


@dataclass(frozen=True)
class TreeRow:
    """A row and those under it."""

    cells: CellRow
    rows: tuple[TreeRow, ...] = ()
    open: bool = True
    """Whether the rows under it are seen at first."""


class CellTree(QTreeWidget):
    """Rows under rows; what a person has opened or closed stays so.

    What the program calls a row is the value of its first cell; None for a row that it never asks
    about.
    """

    changed = Signal(object, bool, str)
    """A person has ticked or renamed a row: its key, whether it is ticked, and its text."""
    chosen = Signal(object)
    """Key of the row that has become the current one."""

    def __init__(self, name: str, columns: Sequence[Column], least: int = 72) -> None:
        super().__init__()
        self._columns, self._least = tuple(columns), least
        self._rows: tuple[TreeRow, ...] = ()
        self.setHeaderLabels([column.heading for column in columns])
        for place, column in enumerate(columns):
            self.headerItem().setToolTip(place, column.tip)
            self.headerItem().setTextAlignment(place, column.align)
        dress_list(self, name, [column.width for column in columns])
        self.setRootIsDecorated(True)
        self.setIndentation(14)
        self.itemChanged.connect(self._on_changed)
        self.currentItemChanged.connect(self._on_current)

    def show_rows(self, rows: Sequence[TreeRow]) -> None:
        """Show these; items stay where they are, so that the current one does."""
        if tuple(rows) != self._rows:
            self._rows = tuple(rows)
            self._write()

    def item_of(self, key: object) -> QTreeWidgetItem | None:
        """The row that the program calls so."""
        every = self.findItems("", Qt.MatchFlag.MatchContains | Qt.MatchFlag.MatchRecursive)
        return next((one for one in every if one.data(0, VALUE) == key), None)

    def choose(self, key: object) -> None:
        """Make a row the current one."""
        item = self.item_of(key)
        if item is not None:
            self.setCurrentItem(item)

    def _write(self) -> None:
        with QSignalBlocker(self):
            self._fill(self.invisibleRootItem(), self._rows)
        self._fit()

    def _fill(self, parent: QTreeWidgetItem, rows: Sequence[TreeRow]) -> None:
        while parent.childCount() > len(rows):
            parent.takeChild(parent.childCount() - 1)
        known = parent.childCount()
        parent.addChildren([QTreeWidgetItem() for _ in range(len(rows) - known)])
        items = [item for place in range(len(rows)) if (item := parent.child(place)) is not None]
        for place, (item, row) in enumerate(zip(items, rows, strict=True)):
            for column, cell in enumerate(row.cells):
                _write_cell(item, column, cell, self._columns[column].align)
            self._fill(item, row.rows)
            item.setFirstColumnSpanned(len(row.cells) == 1)
            if place >= known:
                item.setExpanded(row.open)

    def _fit(self) -> None:
        fit_list(self, [column.width for column in self._columns], self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._write()
        super().changeEvent(event)

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        key = item.data(0, VALUE)
        if column == 0 and key is not None:
            self._rows = ()  # what is shown now may be refused
            self.changed.emit(key, item.checkState(0) == Qt.CheckState.Checked, item.text(0))

    def _on_current(self, item: QTreeWidgetItem | None, _before: object) -> None:
        key = None if item is None else item.data(0, VALUE)
        if key is not None:
            self.chosen.emit(key)


def _write_cell(item: QTreeWidgetItem, place: int, cell: Cell, align: Qt.AlignmentFlag) -> None:
    item.setText(place, cell.text)
    item.setToolTip(place, cell.tip)
    item.setTextAlignment(place, align)
    item.setData(place, VALUE, cell.value)
    picture = None if cell.swatch is None else swatch(cell.swatch)
    item.setData(place, Qt.ItemDataRole.DecorationRole, picture)
    colour = QColor(getattr(current_theme(), cell.colour)) if cell.colour else None
    item.setData(place, Qt.ItemDataRole.ForegroundRole, colour)
    font = item.font(place)
    font.setBold(cell.bold)
    item.setFont(place, font)
    flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
    if cell.editable:
        flags |= Qt.ItemFlag.ItemIsEditable
    if place == 0:
        on = Qt.CheckState.Checked if cell.ticked else Qt.CheckState.Unchecked
        ticks = cell.ticked is not None
        item.setFlags(flags | Qt.ItemFlag.ItemIsUserCheckable if ticks else flags)
        item.setData(0, Qt.ItemDataRole.CheckStateRole, on if ticks else None)


_RIG = tuple(
    Column(heading, tip, width=STRETCH if heading == "Direction" else 0)
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
        self._found: Mapping[str, str] = {}
        self._recording: Recording | None = None
        self.tree = CellTree("Cameras of the rig", _RIG)
        self.setLayout(vbox((self.tree, 1)))

    def show_findings(self, found: Mapping[str, str]) -> None:
        """Mark cameras that something is wrong with: what it is, by name."""
        self._found = found
        self.show_rig(self._recording)

    def show_rig(self, recording: Recording | None) -> None:
        """Show the cameras of a recording."""
        self._recording = recording
        views = () if recording is None else recording.views
        self.tree.show_rows([self._view_row(view, recording) for view in views if recording])

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
