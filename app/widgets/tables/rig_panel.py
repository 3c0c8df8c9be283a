"""The rig: every camera with its intrinsics, its place and where it looks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QTreeWidget, QTreeWidgetItem, QWidget

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View

from ..style.building import vbox
from ..style.theme import current_theme

_COLUMNS = {
    "Camera": "View and its cameras",
    "Size": "Image size in pixels",
    "f x, f y": "Focal lengths in pixels",
    "c x, c y": "Principal point in pixels",
    "Distortion": "Lens distortion at the image corner, in pixels",
    "Position [m]": "Optical centre in world coordinates: x east, y north, z up",
    "Direction": "Compass direction and inclination of the optical axis",
}
_WINDS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")


class RigPanel(QWidget):
    """A row per view, and below it a row per camera."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._found: dict[str, str] = {}
        self.tree = QTreeWidget()
        self.tree.setHeaderLabels(list(_COLUMNS))
        self.tree.setIndentation(14)
        self.tree.setAccessibleName("Cameras of the rig")
        for column, tip in enumerate(_COLUMNS.values()):
            header = self.tree.headerItem()
            if header is not None:
                header.setToolTip(column, tip)
        self.setLayout(vbox(self.tree))

    def show_findings(self, found: Mapping[str, str]) -> None:
        """Mark cameras that something is wrong with: what it is, by name."""
        self._found = dict(found)
        self._dress()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _dress(self) -> None:
        warning = QColor(current_theme().warning)
        for view in range(self.tree.topLevelItemCount()):
            item = self.tree.topLevelItem(view)
            for row in range(item.childCount() if item is not None else 0):
                camera = item.child(row) if item is not None else None
                if camera is not None:
                    what = self._found.get(camera.text(0), "")
                    camera.setToolTip(0, what)
                    camera.setData(0, Qt.ItemDataRole.ForegroundRole, warning if what else None)

    def show_rig(self, recording: Recording | None) -> None:
        """Show the cameras of a recording."""
        self.tree.clear()
        if recording is None:
            return
        for view in recording.views:
            item = _view_item(view, recording)
            self.tree.addTopLevelItem(item)
            item.setFirstColumnSpanned(True)
        self._dress()
        self.tree.expandAll()
        for column in range(1, len(_COLUMNS)):
            self.tree.resizeColumnToContents(column)
        widest = max(self.fontMetrics().horizontalAdvance(name) for name in recording.cameras)
        self.tree.setColumnWidth(0, widest + 3 * self.tree.indentation() + 8)


def _view_item(view: View, recording: Recording) -> QTreeWidgetItem:
    reference = recording.reference_camera(view)
    words: str = view.kind
    if view.left is not None:
        left = recording.cameras[view.left.camera]
        baseline = float(np.linalg.norm(left.position_world - reference.position_world))
        words = f"stereo, baseline {1000.0 * baseline:.1f} mm"
    item = QTreeWidgetItem([f"View {view.name}: {words}"])
    cameras = [reference]
    if view.left is not None:
        cameras.insert(0, recording.cameras[view.left.camera])
    for camera in cameras:
        item.addChild(QTreeWidgetItem(_camera_words(camera)))
    return item


def _camera_words(camera: Camera) -> Sequence[str]:
    """What the rig panel says about a camera, column by column."""
    K, place = camera.matrix, camera.position_world
    return [
        camera.name,
        f"{camera.width} × {camera.height}",
        _pair(K[0, 0], K[1, 1]),
        f"{K[0, 2]:.1f}, {K[1, 2]:.1f}",
        f"{_corner_distortion(camera):.1f} px",
        f"{place[0]:.2f}, {place[1]:.2f}, {place[2]:.2f}",
        _direction_words(camera),
    ]


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
