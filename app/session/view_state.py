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
    """Owns what several panels show alike; panels tell it what a person does, and follow it."""

    selection_changed = Signal(object)
    """Other frames are selected."""
    threshold_changed = Signal(float)
    """Another error counts as a failure, in degrees."""
    active_view_changed = Signal(str)
    """Keys act on another view."""
    display_changed = Signal()
    """Overlays or loupe are others, or another limb is selected."""
    light_changed = Signal()
    """Views are brighter or darker."""
    scene_changed = Signal()
    """Colour of the points, selected limb or fitted body."""
    drawing_changed = Signal()
    """Another step inside the frame is drawn, or the run again."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.selection: range | None = None
        """Frames that are selected."""
        self.threshold = THRESHOLD_DEG
        """Error above which a limb counts as lost, in degrees."""
        self.active_view = ""
        """Name of the view that keys act on; empty without views."""
        self.display = Display()
        """How pictures are displayed."""
        self.lights: dict[str, tuple[float, float]] = {}
        """Brightness and contrast of the views that have their own."""
        self.hidden: frozenset[str] = frozenset()
        """Overlays that are not shown for now, whatever is switched on."""
        self.point_colour: PointColour = "view"
        """How the scene's points are coloured."""
        self.fit: FittedBody | None = None
        """The body fitted to the clicks, which the scene shows while they are made."""
        self.drawing: StepDrawing | None = None
        """The step inside the frame that is drawn instead of the run."""
        self.wanted: Callable[[], Mapping[str, PictureKind]] = dict
        """Which picture each visible view shall show; given by who shows them."""
        self.points_wanted: Callable[[], bool] = lambda: False
        """Whether measured points are shown somewhere."""

    # ---- frames and errors

    @Slot(object)
    def select(self, frames: range | None) -> None:
        """Select frames, or none."""
        if frames != self.selection:
            self.selection = frames
            self.selection_changed.emit(frames)

    @Slot(float)
    def set_threshold(self, degrees: float) -> None:
        """Let another error count."""
        if degrees != self.threshold:
            self.threshold = degrees
            self.threshold_changed.emit(degrees)

    # ---- pictures

    @Slot(str)
    def activate(self, view: str) -> None:
        """Let keys act on another view."""
        if view != self.active_view:
            self.active_view = view
            self.active_view_changed.emit(view)

    @property
    def displayed(self) -> Display:
        """The same without overlays that are hidden for now."""
        return dataclasses.replace(self.display, overlays=self.display.overlays - self.hidden)

    def change_display(self, **changes: Any) -> None:
        """Change how pictures are displayed."""
        self.display = dataclasses.replace(self.display, **changes)
        self.display_changed.emit()

    def hide(self, overlays: frozenset[str]) -> None:
        """Show none of these overlays for now."""
        if overlays != self.hidden:
            self.hidden = overlays
            self.display_changed.emit()

    def light(self, view: str) -> tuple[float, float]:
        """Brightness and contrast of a view: its own, or that of all."""
        return self.lights.get(view, (self.display.brightness, self.display.contrast))

    def set_light(self, brightness: float, contrast: float, view: str = "") -> None:
        """Show one view, or without a name all of them, brighter or darker."""
        if view:
            self.lights[view] = (brightness, contrast)
        else:
            self.lights.clear()
            now = dataclasses.replace(self.display, brightness=brightness, contrast=contrast)
            self.display = now
        self.light_changed.emit()

    def begin_anew(self) -> None:
        """Forget what belongs to a recording that is no longer shown."""
        self.lights.clear()
        self.fit = None
        self.select(None)
        self.change_display(highlighted="")

    # ---- limbs and the scene

    @Slot(str)
    def highlight(self, limb: str) -> None:
        """Select a limb everywhere; the same again, or none, selects nothing."""
        self.change_display(highlighted="" if limb == self.display.highlighted else limb)
        self.scene_changed.emit()

    def colour_points(self, kind: PointColour) -> None:
        """Colour the scene's points in another way."""
        self.point_colour = kind
        self.scene_changed.emit()

    def show_fit(self, fit: FittedBody | None) -> None:
        """Show another fitted body, or none."""
        now, then = (None if one is None else one.meshes for one in (fit, self.fit))
        self.fit = fit
        if now is not then:
            self.scene_changed.emit()

    def draw(self, drawing: StepDrawing | None) -> None:
        """Draw a step inside the frame, or the run again."""
        if drawing is not self.drawing:
            self.drawing = drawing
            self.drawing_changed.emit()
