"""Pictures in which points of the floor are clicked, one camera at a time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QSignalBlocker, QSize, Slot
from PySide6.QtWidgets import QTabBar, QWidget

from stereotrack_core.calibrate.align import POINTS
from stereotrack_core.geometry.camera import Camera

from ....widgets.camera.camera_view import CameraView
from ....widgets.camera.click_marks import (
    ClickAct,
    ClickMark,
    ClickMarks,
    CurveMark,
    Offer,
    PredictionMark,
)
from ....widgets.camera.picture import Display, Picture
from ....widgets.redraw import RedrawQueue
from ....widgets.style.building import vbox
from ..aligning import AligningController
from ..axes import Axes, points_in
from ..state import Calibration

COLOURS: Mapping[str, str] = {"origin": "#f0e442", "north": "#56b4e9", "floor": "#e69f00"}
"""Of the three points; bright on any picture."""


class _Tabs(QTabBar):
    """High enough for the underscores in names of cameras."""

    def tabSizeHint(self, place: int) -> QSize:
        return super().tabSizeHint(place) + QSize(0, 4)


class PointsPanel(QWidget):
    """A tab per camera above its picture, which takes the clicks."""

    def __init__(self, aligning: AligningController) -> None:
        super().__init__()
        self._aligning = aligning
        self._cameras: Mapping[str, Camera] = {}
        self._axes = Axes()
        self.tabs = _Tabs()
        self.tabs.setAccessibleName("Cameras for clicking")
        self.tabs.setExpanding(False)
        self.tabs.setDocumentMode(True)
        self.tabs.currentChanged.connect(self._on_tab)
        self.view = CameraView(RedrawQueue(self), self)
        self.view.setAccessibleName("Picture for clicking points of the floor")
        self.view.setToolTip(
            "Click to place a point, drag to move it. Wheel: zoom. Middle button and drag: move "
            "the picture. Crosses and lines: where clicks in other cameras put a point."
        )
        self.view.set_display(Display(loupe=True, loupe_in_corner=True))
        self.view.set_clicking(True)
        self.view.clicked.connect(self._on_click)
        self.setLayout(vbox(self.tabs, (self.view, 1), spacing=2))
        aligning.read.connect(self._show_picture)

    def show_state(self, state: Calibration) -> None:
        """Show the clicks and what follows from them."""
        self._cameras, self._axes = state.base, state.axes
        with QSignalBlocker(self.tabs):
            names = [self.tabs.tabData(k) for k in range(self.tabs.count())]
            if names != list(state.base):
                while self.tabs.count():
                    self.tabs.removeTab(0)
                for k, name in enumerate(state.base):
                    self.tabs.addTab(name)
                    self.tabs.setTabData(k, name)
            for k, name in enumerate(state.base):
                count = sum(name in own for own in state.axes.clicks.values())
                self.tabs.setTabText(k, f"{name}  {count}/{len(POINTS)}" if count else name)
                if name == state.axes.camera:
                    self.tabs.setCurrentIndex(k)
        self._show_picture()

    @Slot()
    def _show_picture(self) -> None:
        axes, read = self._axes, self._aligning.picture
        source = self._aligning.source_of(axes.camera)
        wanted = read is not None and (read.source, read.frame) == (source, axes.frame)
        image = read.image if read is not None and wanted else None
        message = read.problem if read is not None and wanted else "Loading image …"
        self.view.show_picture(
            Picture(axes.camera, "image", axes.frame, image, message, camera=axes.camera)
        )
        self.view.set_marks(_marks(axes, self._cameras))

    @Slot(int)
    def _on_tab(self, place: int) -> None:
        self._aligning.show_camera(str(self.tabs.tabData(place)))

    @Slot(object)
    def _on_click(self, act: ClickAct) -> None:
        if act.what == "pick":
            self._aligning.choose_point(act.key.landmark)
        else:
            self._aligning.click(act.key.landmark, *act.pixel)


def _marks(axes: Axes, cameras: Mapping[str, Camera]) -> ClickMarks:
    clicks, predictions, curves = [], [], []
    for point in POINTS:
        own, colour = axes.clicks.get(point, {}), COLOURS[point]
        places = points_in(cameras, own, axes.camera)
        if axes.camera in own:
            x, y = own[axes.camera]
            chosen = point == axes.point
            clicks.append(ClickMark(point, point, colour, x, y, chosen=chosen, held=chosen))
        if len(places) > 1:
            other = next(name for name in own if name != axes.camera)
            curves.append(CurveMark(colour, other, places))
        elif len(places):
            x, y = places[0].tolist()
            off = float(np.hypot(*(places[0] - own[axes.camera]))) if axes.camera in own else np.nan
            predictions.append(
                PredictionMark(point, point, colour, x, y, off, chosen=point == axes.point)
            )
    moves = axes.camera in axes.clicks.get(axes.point, {})
    words = f"{axes.point}: click to move it" if moves else f"{axes.point}: click to place it"
    return ClickMarks(
        axes.frame, axes.camera, tuple(clicks), tuple(predictions), tuple(curves),
        offer=Offer(axes.point, words, COLOURS[axes.point], moves),
    )  # fmt: skip
