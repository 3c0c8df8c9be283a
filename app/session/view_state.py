"""What is chosen of what is shown: frames, threshold, limb, overlays, light."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, Literal, TypeAlias

from PySide6.QtCore import QObject, Signal, Slot

from ..widgets.camera.picture import Display, PictureKind
from .pictures import FittedBody, StepDrawing

PointColour: TypeAlias = Literal["view", "limb", "distance"]
THRESHOLD_DEG = 45.0


class ViewState(QObject):
    """Owns what several panels show alike; panels tell it what a person does, and follow it.

    Attributes
    ----------
    wanted : callable
        Which picture each visible view shall show; given by who shows them.
    points_wanted : callable
        Whether measured points are shown somewhere.

    Signals
    -------
    selection_changed : range or None
        Other frames are selected.
    threshold_changed : float
        Another error counts as a failure, in degrees.
    active_view_changed : str
        Keys act on another view.
    display_changed : ()
        Overlays or loupe are others, or another limb is selected.
    light_changed : ()
        Views are brighter or darker.
    scene_changed : ()
        Colour of the points, selected limb or fitted body.
    drawing_changed : ()
        Another step inside the frame is drawn, or the run again.
    """

    selection_changed = Signal(object)
    threshold_changed = Signal(float)
    active_view_changed = Signal(str)
    display_changed = Signal()
    light_changed = Signal()
    scene_changed = Signal()
    drawing_changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._selection: range | None = None
        self._threshold = THRESHOLD_DEG
        self._active_view = ""
        self._display = Display()
        self._lights: dict[str, tuple[float, float]] = {}
        self._hidden: frozenset[str] = frozenset()
        self._point_colour: PointColour = "view"
        self._fit: FittedBody | None = None
        self._drawing: StepDrawing | None = None
        self.wanted: Callable[[], Mapping[str, PictureKind]] = dict
        self.points_wanted: Callable[[], bool] = lambda: False

    # ---- frames and errors

    @property
    def selection(self) -> range | None:
        """Frames that are selected."""
        return self._selection

    @Slot(object)
    def select(self, frames: range | None) -> None:
        """Select frames, or none."""
        if frames != self._selection:
            self._selection = frames
            self.selection_changed.emit(frames)

    @property
    def threshold(self) -> float:
        """Error above which a limb counts as lost, in degrees."""
        return self._threshold

    @Slot(float)
    def set_threshold(self, degrees: float) -> None:
        """Let another error count."""
        if degrees != self._threshold:
            self._threshold = degrees
            self.threshold_changed.emit(degrees)

    # ---- pictures

    @property
    def active_view(self) -> str:
        """Name of the view that keys act on; empty without views."""
        return self._active_view

    @Slot(str)
    def activate(self, view: str) -> None:
        """Let keys act on another view."""
        if view != self._active_view:
            self._active_view = view
            self.active_view_changed.emit(view)

    @property
    def display(self) -> Display:
        """How pictures are displayed."""
        return self._display

    @property
    def displayed(self) -> Display:
        """The same without overlays that are hidden for now."""
        return dataclasses.replace(self._display, overlays=self._display.overlays - self._hidden)

    @property
    def hidden(self) -> frozenset[str]:
        """Overlays that are not shown for now, whatever is switched on."""
        return self._hidden

    def change_display(self, **changes: Any) -> None:
        """Change how pictures are displayed."""
        self._display = dataclasses.replace(self._display, **changes)
        self.display_changed.emit()

    def hide(self, overlays: frozenset[str]) -> None:
        """Show none of these overlays for now."""
        if overlays != self._hidden:
            self._hidden = overlays
            self.display_changed.emit()

    @property
    def lights(self) -> Mapping[str, tuple[float, float]]:
        """Brightness and contrast of the views that have their own."""
        return self._lights

    def light(self, view: str) -> tuple[float, float]:
        """Brightness and contrast of a view: its own, or that of all."""
        return self._lights.get(view, (self._display.brightness, self._display.contrast))

    def set_light(self, brightness: float, contrast: float, view: str = "") -> None:
        """Show one view, or without a name all of them, brighter or darker."""
        if view:
            self._lights[view] = (brightness, contrast)
        else:
            self._lights.clear()
            now = dataclasses.replace(self._display, brightness=brightness, contrast=contrast)
            self._display = now
        self.light_changed.emit()

    def begin_anew(self) -> None:
        """Forget what belongs to a recording that is no longer shown."""
        self._lights.clear()
        self._fit = None
        self.select(None)
        self.change_display(highlighted="")

    # ---- limbs and the scene

    @Slot(str)
    def highlight(self, limb: str) -> None:
        """Select a limb everywhere; the same again, or none, selects nothing."""
        self.change_display(highlighted="" if limb == self._display.highlighted else limb)
        self.scene_changed.emit()

    @property
    def point_colour(self) -> PointColour:
        """How the scene's points are coloured."""
        return self._point_colour

    def colour_points(self, kind: PointColour) -> None:
        """Colour the scene's points in another way."""
        self._point_colour = kind
        self.scene_changed.emit()

    @property
    def fit(self) -> FittedBody | None:
        """The body fitted to the clicks, which the scene shows while they are made."""
        return self._fit

    def show_fit(self, fit: FittedBody | None) -> None:
        """Show another fitted body, or none."""
        now, then = (None if one is None else one.meshes for one in (fit, self._fit))
        self._fit = fit
        if now is not then:
            self.scene_changed.emit()

    @property
    def drawing(self) -> StepDrawing | None:
        """The step inside the frame that is drawn instead of the run."""
        return self._drawing

    def draw(self, drawing: StepDrawing | None) -> None:
        """Draw a step inside the frame, or the run again."""
        if drawing is not self._drawing:
            self._drawing = drawing
            self.drawing_changed.emit()
