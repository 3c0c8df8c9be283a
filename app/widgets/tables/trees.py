"""Rows under rows: statistics of limbs stretch by stretch, and the cameras of the rig."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QAction, QColor
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View

from ..style.building import action_button, hbox, label, vbox
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


class StatisticsPanel(QWidget):
    """A row per limb under a row per stretch, with words and buttons above."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = label("", "muted")
        self.tree = CellTree("Limb statistics")
        self.tree.setFrameShape(QTreeWidget.Shape.NoFrame)
        self.tree.setAlternatingRowColors(True)
        self.tree.setIndentation(8)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.tree.header().setStyleSheet("QHeaderView::section { padding: 3px 4px; }")
        self._buttons = hbox(spacing=0)
        top = hbox((self.words, 1), self._buttons, margins=(8, 4, 4, 0))
        self.setLayout(vbox(top, (self.tree, 1), spacing=2))
        self.show_statistics("", (), ())

    def add_action_button(self, action: QAction) -> None:
        """Offer a command above the table."""
        self._buttons.addWidget(action_button(action), 0, Qt.AlignmentFlag.AlignTop)

    def show_statistics(
        self, words: str, columns: Sequence[Column], rows: Sequence[TreeRow]
    ) -> None:
        """Show these stretches; no rows stand for nothing to show."""
        self.words.setText(words if rows else "Run the tracker to see the statistics of each limb.")
        self.tree.setVisible(bool(rows))
        if rows and self.tree.show_rows((Column("all arms; each limb"), *columns), rows):
            header = self.tree.header()
            header.setMinimumSectionSize(36)
            header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
            header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)


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
