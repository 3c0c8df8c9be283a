"""What is chosen of what is shown: frames, threshold, limb, views, overlays, light."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameSet
from stereotrack_core.tracking.estimate import Correspondences

from .changes import Part, TellChange
from .runs import RunStyle

PictureKind: TypeAlias = Literal["image", "left", "disparity", "foreground", "depth"]

PICTURE_KINDS: dict[PictureKind, str] = {
    "image": "Reference image",
    "left": "Left image",
    "disparity": "Disparity",
    "foreground": "Foreground",
    "depth": "Depth",
}
"""Kinds of pictures with their names; the reference image of a stereo view is the right one."""

_KINDS: Mapping[str, tuple[PictureKind, ...]] = {
    "stereo": ("image", "left", "disparity", "foreground", "depth"),
    "depth": ("image", "foreground", "depth"),
}
"""Pictures that a kind of view can show; others have their image alone."""


def kinds_of(view: View) -> tuple[PictureKind, ...]:
    """Kinds of pictures that a view can show, the usual one first."""
    return _KINDS.get(view.kind, ("image",))


def camera_of(view: View, kind: PictureKind) -> str:
    """Name of the camera whose image a picture is; empty for one that is computed."""
    if kind == "left" and view.left is not None:
        return view.left.camera
    return view.image.camera if kind == "image" else ""


Arrangement: TypeAlias = Literal["grid", "one-and-more", "single"]
"""All views alike, the active one large and the others small, or the active one alone."""


CLICK_OVERLAYS: Mapping[str, str] = {
    "clicks": "Clicks",
    "predictions": "Predicted points",
    "epipolar": "Epipolar curves",
    "residuals": "Residuals of the fit",
    "fit": "Model fitted to clicks",
}


@dataclass(frozen=True)
class Display:
    """How pictures are displayed, the same for all views."""

    overlays: frozenset[str] = frozenset(
        {"outline", "others", "reference", "keypoints", *CLICK_OVERLAYS}
    )
    highlighted: str = ""
    brightness: float = 0.0  # -1 to 1
    contrast: float = 1.0  # factor
    loupe: bool = False
    keep_person: bool = False
    """Whether views enlarge the person and follow it, until somebody zooms by hand."""


PointColour: TypeAlias = Literal["view", "limb", "distance"]
THRESHOLD_DEG = 45.0


class ViewState:
    """Owns what several panels show alike; panels tell it what a person does, and follow it."""

    def __init__(self, tell: TellChange, scene_shows_points: Callable[[], bool]) -> None:
        self._tell, self.scene_shows_points = tell, scene_shows_points
        self.workspace = ""  # name of the workspace that is shown; empty while nothing is open
        self.selection: range | None = None
        self.threshold = THRESHOLD_DEG  # error above which a limb counts as lost, in degrees
        self.active_view = ""  # name of the view that keys act on; empty without views
        self.views: dict[str, View] = {}
        self.kinds: dict[str, PictureKind] = {}
        self.arrangement: Arrangement = "grid"
        self.display = Display()
        self.hidden: frozenset[str] = frozenset()
        """Overlays that are not shown for now, whatever is switched on, unless asked for."""
        self.asked: frozenset[str] = frozenset()
        """Those of them that a person has asked for all the same."""
        self._strictly = False
        self.point_colour: PointColour = "view"
        self.fit: FittedBody | None = None
        """The body fitted to the clicks, which the scene shows while they are made."""
        self.drawing: StepDrawing | None = None

    def show_workspace(self, name: str) -> None:
        self.workspace = name
        self._tell(Part.WORKSPACE)

    # ---- frames and errors

    def select(self, frames: range | None) -> None:
        if frames != self.selection:
            self.selection = frames
            self._tell(Part.SELECTION)

    def set_threshold(self, degrees: float) -> None:
        if degrees != self.threshold:
            self.threshold = degrees
            self._tell(Part.THRESHOLD)

    # ---- views

    def show_views(self, views: Sequence[View]) -> None:
        """Show the images of other views; keys act on the first."""
        self.views = {view.name: view for view in views}
        self.kinds = {view.name: kinds_of(view)[0] for view in views}
        self.active_view = next(iter(self.views), "")

    def wanted(self) -> dict[str, PictureKind]:
        """Which picture each visible view shall show."""
        alone = self.arrangement == "single" and self.active_view
        return {self.active_view: self.kinds[self.active_view]} if alone else dict(self.kinds)

    def cameras(self) -> dict[str, str]:
        """The camera whose image each visible view shall show; empty for computed pictures."""
        return {name: camera_of(self.views[name], kind) for name, kind in self.wanted().items()}

    def choose_kind(self, kind: PictureKind, view: str = "") -> None:
        """Show a kind of picture in one view, or without a name in every view that has it."""
        views = self.views if not view else {view: self.views[view]} if view in self.views else {}
        chosen = {name: kind for name, each in views.items() if kind in kinds_of(each)}
        if chosen.items() - self.kinds.items():
            self.kinds |= chosen
            self._tell(Part.PICTURES)

    def arrange(self, arrangement: Arrangement) -> None:
        self.arrangement = arrangement
        self._tell(Part.PICTURES)

    def activate(self, view: str) -> None:
        """Let keys act on another view."""
        if view != self.active_view and view in self.views:
            self.active_view = view
            self._tell(Part.ACTIVE_VIEW)
            if self.arrangement != "grid":
                self._tell(Part.PICTURES)

    def activate_next(self, by: int = 1) -> None:
        """Let keys act on the view after (or before) the active one."""
        names = list(self.views)
        if names:
            self.activate(names[(names.index(self.active_view) + by) % len(names)])

    # ---- pictures

    @property
    def displayed(self) -> Display:
        """The same without overlays that are hidden for now."""
        overlays = (self.display.overlays - self.hidden) | self.asked
        return dataclasses.replace(self.display, overlays=overlays)

    def change_display(self, **changes: Any) -> None:
        self.display = dataclasses.replace(self.display, **changes)
        self._tell(Part.DISPLAY)

    def hide(self, overlays: frozenset[str], *, strictly: bool = False) -> None:
        """Show none of these overlays for now, but what a person asks for; nothing strictly."""
        if (overlays, strictly) != (self.hidden, self._strictly):
            self.hidden, self._strictly, self.asked = overlays, strictly, frozenset()
            self._tell(Part.DISPLAY)

    def toggle_overlay(self, name: str) -> None:
        """Switch an overlay; one that is hidden for now is asked for, or no longer."""
        if name not in self.hidden:
            self.change_display(overlays=self.display.overlays ^ {name})
        elif not self._strictly:
            self.asked ^= {name}
            self._tell(Part.DISPLAY)

    def set_light(self, brightness: float, contrast: float) -> None:
        """Show all views brighter or darker, within limits."""
        self.change_display(
            brightness=min(max(round(brightness, 3), -0.8), 0.8),
            contrast=min(max(round(contrast, 3), 0.25), 4.0),
        )

    def change_light(self, brightness: float = 0.0, contrast: float = 1.0) -> None:
        """Add to the brightness, and multiply the contrast."""
        self.set_light(self.display.brightness + brightness, self.display.contrast * contrast)

    def begin_anew(self) -> None:
        self.show_views(())
        self.fit = None
        self.select(None)
        self.change_display(highlighted="")

    # ---- limbs and the scene

    def highlight(self, limb: str) -> None:
        """Select a limb everywhere; the same again, or none, selects nothing."""
        self.change_display(highlighted="" if limb == self.display.highlighted else limb)
        self._tell(Part.SCENE)

    def colour_points(self, kind: PointColour) -> None:
        self.point_colour = kind
        self._tell(Part.SCENE)

    def show_fit(self, fit: FittedBody | None) -> None:
        now, then = (None if one is None else one.meshes for one in (fit, self.fit))
        self.fit = fit
        if now is not then:
            self._tell(Part.SCENE)

    def draw(self, drawing: StepDrawing | None) -> None:
        if drawing is not self.drawing:
            self.drawing = drawing
            self._tell(Part.STEP)


@dataclass(frozen=True, eq=False)
class Marked:
    """Ghosts, lines or dots of one colour."""

    name: str  # #rrggbb; of ghosts the limb
    places: FloatArray
    """Ghosts: the vertices (S, V, 3) of one cone of the model in several poses; lines: their ends
    (K, 2, 3); dots: (K, 3)."""


@dataclass(frozen=True, eq=False)
class InsideScene:
    """Marks of a step inside a frame.

    In the world, metres; or in a picture, where all places are pixels, with two numbers for three,
    and ghosts are silhouettes (K, 2).
    """

    ghosts: tuple[Marked, ...] = ()
    lines: tuple[Marked, ...] = ()
    dots: tuple[Marked, ...] = ()


@dataclass(frozen=True, eq=False)
class GhostBody:
    """The model of a run that is drawn beside the active one, as lines, dots or both."""

    style: RunStyle  # that of its lines in the plots: `dash` becomes lines, `dot` dots
    meshes: tuple[PartMesh, ...]


@dataclass(frozen=True, eq=False)
class Instant:
    """Everything known about the frame that is shown."""

    recording: Recording
    frame_set: FrameSet
    cloud: Cloud | None = None
    meshes: tuple[PartMesh, ...] = ()
    reference: FloatArray | None = None  # (9, 3), world, metres
    reference_is_old: bool = False  # whether it was fitted before the last click
    ghosts: tuple[GhostBody, ...] = ()
    correspondences: Correspondences | None = None
    inside: InsideScene | None = None
    keypoints: Keypoints | None = None


@dataclass(frozen=True, eq=False)
class StepDrawing:
    """One step as it is drawn."""

    frame: int
    words: str
    body: BodyModel
    pose: Pose  # of the model that is drawn as a whole
    scene: InsideScene
    cloud: Cloud


@dataclass(frozen=True, eq=False)
class FittedBody:
    """A body that was fitted to the clicks of a frame."""

    frame: int
    meshes: tuple[PartMesh, ...]
