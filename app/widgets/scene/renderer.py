"""The scene as pictures: layers that follow the content, and names over them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter

from ..style.theme import Theme
from .body import CloudLayer, EllipsoidLayer, GhostLayer, ModelLayer
from .content import SceneContent
from .inside import InsideLayer
from .orbit import FIELD_OF_VIEW, Orbit
from .surroundings import CameraLayer, FloorLayer, ReferenceLayer
from .window import SceneWindow


class SceneRenderer:
    """Draws contents one after another with the same meshes.

    Raises
    ------
    SceneUnavailable
        If no OpenGL is to be had.
    """

    def __init__(self) -> None:
        self._window = SceneWindow()
        scene = self._window.scene
        self._floor = FloorLayer(scene)
        self._cameras = CameraLayer(scene)
        self._cloud = CloudLayer(scene)
        self._model = ModelLayer(scene)
        self._ghosts = GhostLayer(scene)
        self._ellipsoids = EllipsoidLayer(self._window.above)
        self._reference = ReferenceLayer(self._window.above)
        self._inside = InsideLayer(self._window.above)
        self._scale = 1.0

    def set_content(
        self, content: SceneContent, layers: Mapping[str, bool], theme: Theme, scale: float
    ) -> None:
        """Take over what is to be shown.

        Parameters
        ----------
        content : SceneContent
        layers : mapping from a name in LAYERS to whether it is drawn
        theme : Theme
        scale : float
            Pixels of the picture for a device-independent one.
        """
        self._scale = scale
        self._window.set_background(theme.scene_top, theme.scene_bottom)
        self._floor.show(content, layers["floor"], theme, scale)
        self._cameras.show(content, layers["cameras"], theme, scale)
        self._cloud.show(content, layers["cloud"])
        self._model.show(content, layers["model"], theme)
        self._ghosts.show(content, layers["model"], theme, scale)
        self._ellipsoids.show(content, layers["ellipsoids"], theme)
        self._reference.show(content, layers["reference"], theme, scale)
        self._inside.show(content.inside, theme, scale)

    def picture(self, width: int, height: int, orbit: Orbit, *, fine: bool = False) -> QImage:
        """Render the content at `width` by `height` pixels."""
        per_metre = height / (2.0 * orbit.distance * np.tan(FIELD_OF_VIEW / 2))
        self._cloud.set_dots_to(per_metre, self._scale)
        self._reference.set_dots_to(per_metre, self._scale)
        return self._window.picture(width, height, orbit, fine=fine)

    def close(self) -> None:
        """Give the OpenGL context back."""
        self._window.close()


def paint_names(
    painter: QPainter,
    content: SceneContent,
    layers: Mapping[str, bool],
    orbit: Orbit,
    area: QRectF,
    theme: Theme,
) -> None:
    """Write the cameras' names and the N of north where they stand in the picture."""
    labels = CameraLayer.labels(content) if layers["cameras"] else []
    if layers["floor"]:
        labels.append(FloorLayer.label(content))
    if not labels:
        return
    places = orbit.project(np.stack([place for _, place in labels]), area.width(), area.height())
    for (name, _), (x, y) in zip(labels, places, strict=True):
        if not (np.isfinite(x) and np.isfinite(y)):
            continue
        width = painter.fontMetrics().horizontalAdvance(name)
        box = QRectF(x - 0.5 * width - 2.0, y - 10.0, width + 4.0, 20.0)
        if area.contains(box):
            painter.setPen(QColor(theme.scene_bottom))
            painter.drawText(box.translated(1.0, 1.0), Qt.AlignmentFlag.AlignCenter, name)
            painter.setPen(QColor(theme.text))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, name)
