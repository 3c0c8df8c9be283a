"""The 3-D scene as an ordinary widget: rendered off-screen, painted as a picture with its words."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6 import QtGui
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PySide6.QtWidgets import QApplication, QWidget

from stereotrack_core.arrays import FloatArray

from ..redraw import RedrawQueue, later, takes_key
from ..style.building import Raised, action_button, hbox, label, menu_of, tool_button
from ..style.theme import Theme, current_theme
from .content import LAYERS, NORTH_TIP, Orbit, PointLegend, SceneContent, orbit_around

if TYPE_CHECKING:
    from .drawing import SceneRenderer


def scene_bar(
    title: str,
    layers: Sequence[QtGui.QAction],
    menus: Sequence[tuple[str, str, Sequence[QtGui.QAction]]],
) -> QWidget:
    """A row that stands where a panel has its title, with a button for each of the `layers`.

    `menus` stand behind them: text, icon and entries of each.
    """
    buttons = [action_button(action) for action in layers]
    for text, icon, actions in menus:
        buttons.append(tool_button(text, icon, text))
        buttons[-1].setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        menu_of(buttons[-1]).addActions(list(actions))
    for button in buttons:
        button.setIconSize(QSize(16, 16))
        button.setProperty("role", "plain")
    bar, heading = Raised("title"), label(title, "muted", wraps=False)
    bar.setLayout(hbox(heading, None, *buttons, margins=(8, 1, 4, 1), spacing=1))
    return bar


_REST_MS = 180
_STILL_MS = 700
"""How long the eye, and the content, have to be at rest until a fine picture is rendered: one of
each frame while a tracker runs would hold up the window."""
_FINE_SHARE = 0.03
"""Most of the time that fine pictures may take while the content changes: one takes 30 to 70 ms
where no graphics card helps, in which the window stands still."""
_COARSE_SECONDS = 0.016
"""How long it may take to render a picture while the eye or the content moves."""
_COARSEST = 4  # how often such a picture may be halved, in pixels
_TURN_PER_PIXEL = np.radians(0.4)
_TURN_PER_KEY = np.radians(7.5)
_ZOOM_KEYS = {Qt.Key.Key_Plus: 1.2, Qt.Key.Key_Equal: 1.2, Qt.Key.Key_Minus: 1 / 1.2}
_TURN_KEYS = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Up: (0, 1),
    Qt.Key.Key_Down: (0, -1),
}
_HELP = (
    "Drag to rotate, right-drag to pan, scroll to zoom, double-click to reset, click a limb to "
    "select it. Keys: + and - zoom, Alt and arrows rotate."
)


class SceneView(QWidget):
    """Shows the body, the measured points, the reference and the cameras in 3-D.

    Contents are rendered when Qt paints, so of several that come in between only the newest
    costs anything, and a hidden scene costs nothing. Where no OpenGL is to be had the widget
    says so and everything else about it keeps working. `choose_limb` is called with the limb that a
    person clicks.
    """

    def __init__(
        self, choose_limb: Callable[[str], object], redraw: RedrawQueue | None = None
    ) -> None:
        super().__init__()
        self._choose_limb, self._redraw = choose_limb, redraw or RedrawQueue(self)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setMinimumSize(160, 120)
        self.setAccessibleName("3-D scene")
        self.setAccessibleDescription(_HELP)
        self.content = SceneContent()  # what is shown, or will be at the next painting
        self._layers = dict.fromkeys(LAYERS, True) | {"ellipsoids": False}
        self._orbit: Orbit | None = None
        self._standing = "home"
        self._held: FloatArray | None = None
        self._holds = 0
        self._renderer: SceneRenderer | None = None
        self.unavailable_because = ""
        """Why nothing can be rendered; empty while nothing stands against it."""
        self._image: QtGui.QImage | None = None
        self._content_changed = True
        self._image_is_fine = False
        self._halved, self._fine_seconds = 0, 0.0
        self._press: QPointF | None = None
        self._last = QPointF()
        self._dragged, self._turning = False, True
        self._still = _REST_MS
        self._rest = later(self, self.update)
        self.destroyed.connect(partial(_close_renderer, self.__dict__))

    def sizeHint(self) -> QSize:
        return QSize(640, 480)

    @property
    def orbit(self) -> Orbit:
        return self._orbit or self._standard("home")

    def show_scene(self, content: SceneContent) -> None:
        """Show `content` from now on; the eye stays where it is."""
        self.content = content
        holds = content.parts_known()
        if self._standing and holds > self._holds:
            self._orbit = self._standard(self._standing)
        self._holds = max(holds, self._holds)
        self._changed(content=True)

    def begin_anew(self) -> None:
        """Forget what was shown and where the eye was, as another recording comes."""
        self._held, self._holds, self._orbit, self._standing = None, 0, None, "home"
        self.show_scene(SceneContent())

    def hold(self, points: FloatArray | None) -> None:
        """Let the standard views hold these points (K, 3), world, beside the body."""
        self._held = points
        self.set_view("home")

    def set_layer_visible(self, layer: str, visible: bool) -> None:
        """Draw one of :data:`~app.widgets.scene.content.LAYERS` or leave it out."""
        self._layers[layer] = visible
        self._changed(content=True)

    def layer_visible(self, layer: str) -> bool:
        return self._layers[layer]

    def set_highlighted(self, limb: str) -> None:
        if limb != self.content.highlighted:
            self.show_scene(replace(self.content, highlighted=limb))

    def set_view(self, view: str) -> None:
        """Look from one of :data:`~app.widgets.scene.content.STANDARD_VIEWS`."""
        self.set_orbit(self._standard(view))
        self._standing = view

    def set_orbit(self, orbit: Orbit) -> None:
        """Place the eye; it stays there until a standard view is asked for."""
        self._orbit, self._standing = orbit, ""
        self._changed()

    def _standard(self, view: str) -> Orbit:
        aspect = self.width() / max(self.height(), 1)
        held = [self._held] if self._held is not None else []
        return orbit_around(np.vstack([*held, self.content.body_points()]), view, aspect)

    def _changed(self, *, content: bool = False) -> None:
        self._image = None
        if content:
            self._content_changed = True
            self._still = max(_STILL_MS, round(1000.0 * self._fine_seconds / _FINE_SHARE))
            self._redraw.soon(self._prepare)
        else:
            self.update()

    def _prepare(self) -> None:
        """Hand the content to the renderer; paint it when it is its turn again."""
        renderer = self._renderer_or_none() if self._content_changed and self.is_seen() else None
        if renderer is None:
            self.repaint()
        else:
            self._hand_over(renderer)
            self._redraw.soon(self._prepare)

    def _hand_over(self, renderer: SceneRenderer) -> None:
        if self._content_changed:
            scale = self.devicePixelRatioF()
            renderer.set_content(self.content, self._layers, current_theme(), scale)
            self._content_changed = False

    def at_rest(self) -> bool:
        """Whether the picture is as good as it gets, or none can be made or seen."""
        return self._image_is_fine or bool(self.unavailable_because) or not self.is_seen()

    def is_seen(self) -> bool:
        """Whether any of it is on the screen, not behind another panel."""
        return self.isVisible() and not self.visibleRegion().isEmpty()

    def paintEvent(self, _event: QtGui.QPaintEvent) -> None:
        fine = self._image is not None and not self._image_is_fine and not self._rest.isActive()
        painter = QtGui.QPainter(self)
        if (self._image is None or fine) and not self._render(fine=fine):
            self._paint_apology(painter)
        elif self._image is not None:
            painter.setRenderHint(QtGui.QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawImage(QRectF(self.rect()), self._image)
            self._paint_names(painter)
        if self.hasFocus():
            painter.setPen(QtGui.QPen(self.palette().highlight(), 2.0))
            painter.drawRect(self.rect().adjusted(1, 1, -1, -1))
        painter.end()

    def _render(self, *, fine: bool) -> bool:
        renderer = self._renderer_or_none()
        if renderer is None:
            return False
        self._hand_over(renderer)
        scale = self.devicePixelRatioF() * (1.0 if fine else 0.5 ** (0.5 * self._halved))
        size = max(1, round(self.width() * scale)), max(1, round(self.height() * scale))
        begun = time.perf_counter()
        self._image = renderer.picture(*size, self.orbit, fine=fine)
        self._image.setDevicePixelRatio(scale)
        self._image_is_fine, seconds = fine, time.perf_counter() - begun
        if fine:
            self._fine_seconds = seconds
        else:  # what moves has as many pixels as can be rendered in time
            share = max(seconds, 1e-4) / _COARSE_SECONDS
            self._halved = min(max(self._halved + round(np.log2(share)), 0), _COARSEST)
            self._rest.start(max(self._still, self._rest.remainingTime()))
            self._still = _REST_MS
        return True

    def _renderer_or_none(self) -> SceneRenderer | None:
        if self._renderer is None and not self.unavailable_because:
            from . import drawing  # VTK takes its time to load: only where a scene is seen

            try:
                self._renderer = drawing.SceneRenderer()
            except drawing.SceneUnavailable as problem:
                self.unavailable_because = str(problem)
        return self._renderer

    def _paint_names(self, painter: QtGui.QPainter) -> None:
        area = QRectF(self.rect())
        paint_lettering(painter, self.content, self._layers, self.orbit, area, current_theme())

    def _paint_apology(self, painter: QtGui.QPainter) -> None:
        painter.fillRect(self.rect(), self.palette().base())
        painter.setPen(self.palette().placeholderText().color())
        text = f"The 3-D scene cannot be shown.\n{self.unavailable_because}\nEverything else works."
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        painter.drawText(self.rect().adjusted(16, 16, -16, -16), flags, text)

    def resizeEvent(self, _event: QtGui.QResizeEvent) -> None:
        if self._orbit is not None and self._standing:
            self._orbit = self._standard(self._standing)
        self._changed()

    def changeEvent(self, event: QEvent) -> None:
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.DevicePixelRatioChange):
            self._changed(content=True)
        super().changeEvent(event)

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        self._press = self._last = event.position()
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        self._turning = event.button() == Qt.MouseButton.LeftButton and not shift
        self._dragged = False
        event.accept()

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        if self._press is None:
            return
        far = (event.position() - self._press).manhattanLength()
        self._dragged |= far >= QApplication.startDragDistance()
        if self._dragged:
            step, self._last = event.position() - self._last, event.position()
            by = _TURN_PER_PIXEL if self._turning else 1.0 / self.height()
            move = self.orbit.turned if self._turning else self.orbit.moved
            self.set_orbit(move(-step.x() * by, step.y() * by))

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        clicked, self._press = self._press is not None and not self._dragged, None
        left = event.button() == Qt.MouseButton.LeftButton
        if clicked and left and (limb := self.limb_at(event.position())):
            self._choose_limb(limb)

    def mouseDoubleClickEvent(self, _event: QtGui.QMouseEvent) -> None:
        self._press = None
        self.set_view("home")

    def limb_at(self, position: QPointF) -> str:
        """Name the limb of the model under a position of the widget; empty for none."""
        if not self._layers["model"]:
            return ""
        from .drawing import limb_at

        ray = self.orbit.ray(position.x(), position.y(), self.width(), self.height())
        return limb_at(self.content.meshes, self.orbit.eye, ray)

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        self.set_orbit(self.orbit.zoomed(1.0015 ** event.angleDelta().y()))
        event.accept()

    def event(self, event: QEvent) -> bool:
        # what zooms the active view zooms the scene while that has the focus
        wants = takes_key(event, lambda key: self._orbit_for(key) is not None)
        return wants or super().event(event)

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        if orbit := self._orbit_for(event):
            self.set_orbit(orbit)
        else:
            super().keyPressEvent(event)

    def _orbit_for(self, event: QtGui.QKeyEvent) -> Orbit | None:
        key = Qt.Key(event.key())
        modifiers = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        if modifiers == Qt.KeyboardModifier.AltModifier and key in _TURN_KEYS:
            right, up = _TURN_KEYS[key]
            return self.orbit.turned(right * _TURN_PER_KEY, up * _TURN_PER_KEY)
        plain = modifiers & ~Qt.KeyboardModifier.ShiftModifier == Qt.KeyboardModifier.NoModifier
        return self.orbit.zoomed(_ZOOM_KEYS[key]) if plain and key in _ZOOM_KEYS else None


def _close_renderer(state: dict[str, Any], _view: object = None) -> None:
    """Give the OpenGL context back when Qt has destroyed the widget, of which this is left."""
    if (renderer := state.pop("_renderer", None)) is not None:
        renderer.close()


_AXES = (("x", "#e0605a"), ("y", "#4fa85a"), ("z", "#4d97e8"))
"""Axes of the world and their colours: x is east, y north, z up."""
_AXIS_LENGTH = 26.0
_MARGIN, _GAP, _ROW, _SWATCH = 6.0, 6.0, 18.0, 9.0


def paint_lettering(
    painter: QtGui.QPainter,
    content: SceneContent,
    layers: Mapping[str, bool],
    orbit: Orbit,
    area: QRectF,
    theme: Theme,
) -> None:
    """Write what belongs to the layers that are shown."""
    if layers["floor"]:
        _paint_axes(painter, orbit, area)
    words = [(one.name, one.position_world) for one in content.cameras if layers["cameras"]]
    if layers["floor"]:
        words.append(("N", np.array([0.0, NORTH_TIP + 0.15, 0.0])))
    places = orbit.project(np.array([at for _, at in words]), area.width(), area.height())
    written: list[QRectF] = []
    for (text, _), (x, y) in zip(words, places, strict=True):
        if not np.isfinite([x, y]).all():  # it is behind the eye
            continue
        width = painter.fontMetrics().horizontalAdvance(text)
        box = QRectF(x - 0.5 * width - 2.0, y - 10.0, width + 4.0, 20.0)
        if area.contains(box) and not any(map(box.intersects, written)):
            written.append(box)
            _write(painter, text, box, theme)
    if layers["cloud"] and len(content.cloud_points) and content.point_legend is not None:
        _paint_legend(painter, content.point_legend, area, theme)


def _write(painter: QtGui.QPainter, text: str, box: QRectF, theme: Theme) -> None:
    for ink, shift in ((theme.scene_bottom, 1.0), (theme.text, 0.0)):  # over its shadow
        painter.setPen(QtGui.QColor(ink))
        painter.drawText(box.translated(shift, shift), Qt.AlignmentFlag.AlignCenter, text)


def _paint_axes(painter: QtGui.QPainter, orbit: Orbit, area: QRectF) -> None:
    middle = area.bottomRight() - QPointF(44.0, 42.0)
    painter.save()
    painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
    flat = np.column_stack([orbit.right, -orbit.up])
    for axis in np.argsort(orbit.toward_eye):  # the nearest last
        name, colour = _AXES[axis]
        end = QPointF(*(_AXIS_LENGTH * flat[axis]))
        painter.setPen(QtGui.QPen(QtGui.QColor(colour), 2.0))
        painter.drawLine(middle, middle + end)
        box = QRectF(0.0, 0.0, 16.0, 16.0)
        box.moveCenter(middle + end * (1.0 + 9.0 / _AXIS_LENGTH))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, name)
    painter.restore()


def _paint_legend(painter: QtGui.QPainter, legend: PointLegend, area: QRectF, theme: Theme) -> None:
    """Say at the top left what the colours of the points mean, in a row for each."""
    rows: list[tuple[str, tuple[int, int, int] | None]] = [(legend.title, None), *legend.entries]
    widest = max(painter.fontMetrics().horizontalAdvance(text) for text, _ in rows)
    corner = area.topLeft() + QPointF(_MARGIN, _MARGIN)
    left = corner.x() + 2.0 * _GAP + _SWATCH
    painter.save()
    paper = QtGui.QColor(theme.base)
    paper.setAlpha(215)
    width = left - corner.x() + widest + _GAP
    painter.fillRect(QRectF(corner.x(), corner.y(), width, _ROW * len(rows) + 4.0), paper)
    painter.setPen(QtGui.QColor(theme.text))
    for place, (text, colour) in enumerate(rows):
        top = corner.y() + 2.0 + place * _ROW
        if colour is not None:
            dot = QRectF(corner.x() + _GAP, top + 0.5 * (_ROW - _SWATCH), _SWATCH, _SWATCH)
            painter.fillRect(dot, QtGui.QColor(*colour))
        start = corner.x() + _GAP if colour is None else left
        row = QRectF(start, top, width, _ROW)
        painter.drawText(row, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, text)
    painter.restore()
