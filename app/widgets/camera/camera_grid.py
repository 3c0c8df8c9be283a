"""All views beside each other, always at the same instant."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Literal, TypeAlias

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QGridLayout, QWidget

from stereotrack_core.recording.description import View

from ..style.building import choice, hbox, label, vbox
from .camera_view import CameraView
from .click_marks import ClickMarks
from .picture import PICTURE_KINDS, Display, Picture, PictureKind

Arrangement: TypeAlias = Literal["grid", "one-and-more", "single"]
ARRANGEMENTS: tuple[Arrangement, ...] = ("grid", "one-and-more", "single")


_KINDS: Mapping[str, tuple[PictureKind, ...]] = {
    "stereo": ("image", "left", "disparity", "foreground", "depth"),
    "depth": ("image", "foreground", "depth"),
}
"""Pictures that a kind of view can show; others have their image alone."""


def camera_of(view: View, kind: PictureKind) -> str:
    """Name of the camera whose image a picture is; empty for one that is computed."""
    if kind == "left" and view.left is not None:
        return view.left.camera
    return view.image.camera if kind == "image" else ""


def _kind_words(view: View, kind: PictureKind) -> str:
    """Name of a picture, said for this view."""
    if kind == "image":
        return "Right image" if view.kind == "stereo" else "Image"
    return PICTURE_KINDS[kind]


class CameraTile(QFrame):
    """One view with its name and the choice of what it shows."""

    kind_chosen = Signal()
    activated = Signal(str)

    def __init__(self, view: View, parent: QWidget) -> None:
        super().__init__(parent)
        self.view = view
        self.camera = CameraView(self)
        self._name = label(view.name, wraps=False)
        self._name.setObjectName("tileName")
        font = self._name.font()
        font.setBold(True)
        self._name.setFont(font)
        kinds = [(kind, _kind_words(view, kind)) for kind in _KINDS.get(view.kind, ("image",))]
        name, tip = f"Image shown in view {view.name}", "Image shown in this view"
        self._kind = choice(name, kinds, tip)
        self._kind.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._note = label(wraps=False)
        self._note.setObjectName("tileNote")
        head = hbox(self._name, self._kind, (self._note, 1), margins=(8, 2, 4, 2), spacing=8)
        self.setLayout(vbox(head, (self.camera, 1), spacing=0))
        self._kind.setVisible(self._kind.count() > 1)
        self._kind.activated.connect(self.kind_chosen)
        self.camera.pressed.connect(lambda: self.activated.emit(self.view.name))

    @property
    def kind(self) -> PictureKind:
        """What the view shall show."""
        kind: PictureKind = self._kind.currentData()
        return kind

    def set_kind(self, kind: PictureKind) -> None:
        """Choose what the view shows, where it has that."""
        place = self._kind.findData(kind)
        if place >= 0:
            self._kind.setCurrentIndex(place)

    def set_active(self, active: bool) -> None:
        """Mark the view that keys act on."""
        self.setProperty("active", active)
        self._name.setText(f"▸ {self.view.name}" if active else self.view.name)

    def show_picture(self, picture: Picture) -> None:
        """Show a picture with its message."""
        self.camera.show_picture(picture)
        note = picture.message if picture.pixels is not None else ""
        self._note.setText(note)
        self._note.setToolTip(note)


class CameraGrid(QWidget):
    """The views of a recording: 2x2, one large and the others small, or one alone."""

    kinds_changed = Signal()
    """Another picture is wanted in some view."""
    hovered = Signal(str)
    """Words about the pixel under the cursor."""
    limb_clicked = Signal(str)
    """A limb was clicked in a view; empty for none."""
    active_changed = Signal(str)
    """Name of the view that keys act on."""
    at_hand_changed = Signal(str)
    """Name of the view that a click goes to, and keys about clicks act on."""
    arranged = Signal()
    """The arrangement has changed."""
    clicked = Signal(object)
    """What a person did with clicks in a view."""
    refused = Signal(str)
    """Why a click was not taken."""
    space_tapped = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.tiles: dict[str, CameraTile] = {}
        """Tiles by the name of their view."""
        self.active = self._at_hand = ""
        """Name of the view that keys act on; empty without views."""
        self.arrangement: Arrangement = "grid"
        """How the views are arranged."""
        self._display = Display()
        self._lights: Mapping[str, tuple[float, float]] = {}
        self._clicking: tuple[bool, str] = (False, "")
        self._layout = QGridLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(3)

    @property
    def at_hand(self) -> str:
        """The view that the mouse was moved into or that was made active, whichever came last."""
        return self._at_hand if self._at_hand in self.visible_views() else self.active

    def active_camera(self) -> CameraView | None:
        """The camera view that keys act on."""
        tile = self.tiles.get(self.active)
        return tile.camera if tile is not None else None

    def set_views(self, views: Sequence[View]) -> None:
        """Show other views."""
        for tile in self.tiles.values():
            self._layout.removeWidget(tile)
            tile.hide()
            tile.deleteLater()
        self.tiles = {}
        for view in views:
            tile = CameraTile(view, self)
            tile.kind_chosen.connect(self.kinds_changed)
            tile.activated.connect(self.set_active)
            tile.camera.pointed.connect(partial(self._set_at_hand, view.name))
            for signal in ("hovered", "limb_clicked", "clicked", "refused", "space_tapped"):
                getattr(tile.camera, signal).connect(getattr(self, signal))
            tile.camera.set_display(self._display_of(view.name))
            tile.camera.set_clicking(*self._clicking)
            self.tiles[view.name] = tile
        self.active = self._at_hand = views[0].name if views else ""
        self._arrange()
        self.set_active(self.active)

    def wanted(self) -> dict[str, PictureKind]:
        """What each visible view shall show."""
        return {name: self.tiles[name].kind for name in self.visible_views()}

    def visible_views(self) -> tuple[str, ...]:
        """Names of the views that the arrangement shows."""
        if self.arrangement == "single" and self.active:
            return (self.active,)
        return tuple(self.tiles)

    def show_pictures(self, pictures: Sequence[Picture]) -> None:
        """Show the pictures of one instant."""
        for place, picture in enumerate(pictures):
            tile = self.tiles.get(picture.view)
            if tile is not None:
                tile.camera.legend = place == 0  # once is enough
                tile.show_picture(picture)

    def set_kind(self, kind: PictureKind) -> None:
        """Show one kind of picture in every view that has it."""
        for tile in self.tiles.values():
            tile.set_kind(kind)
        self.kinds_changed.emit()

    def show_kind(self, view: str, kind: PictureKind) -> None:
        """Show one kind of picture in one view."""
        tile = self.tiles.get(view)
        if tile is not None and tile.kind != kind:
            tile.set_kind(kind)
            self.kinds_changed.emit()

    def set_display(
        self, display: Display, lights: Mapping[str, tuple[float, float]] | None = None
    ) -> None:
        """Change how pictures are displayed; `lights` are brightness and contrast of some views."""
        self._display, self._lights = display, lights or {}
        for name, tile in self.tiles.items():
            tile.camera.set_display(self._display_of(name))

    def _display_of(self, view: str) -> Display:
        light = self._lights.get(view)
        if light is None:
            return self._display
        return dataclasses.replace(self._display, brightness=light[0], contrast=light[1])

    # ---- clicks

    def cameras(self) -> dict[str, str]:
        """The camera whose image each visible view shall show; empty for computed pictures."""
        return {
            name: camera_of(self.tiles[name].view, kind) for name, kind in self.wanted().items()
        }

    def set_marks(self, marks: Mapping[str, ClickMarks]) -> None:
        """Draw clicks by the name of the camera whose image they are of."""
        for tile in self.tiles.values():
            picture = tile.camera.picture
            tile.camera.set_marks(marks.get(picture.camera) if picture is not None else None)

    def set_clicking(self, clicking: bool, why_not: str = "") -> None:
        """Let the left button place clicks in all views, or say why it cannot."""
        if (clicking, why_not) == self._clicking:
            return
        self._clicking = (clicking, why_not)
        for tile in self.tiles.values():
            tile.camera.set_clicking(clicking, why_not)

    def set_arrangement(self, arrangement: Arrangement) -> None:
        """Arrange the views in another way."""
        self.arrangement = arrangement
        self._arrange()
        self.arranged.emit()
        self.kinds_changed.emit()

    def set_active(self, name: str) -> None:
        """Choose the view that keys act on."""
        if name not in self.tiles:
            return
        changed, self.active = name != self.active, name
        for tile in self.tiles.values():
            tile.set_active(tile.view.name == name and len(self.tiles) > 1)
        if changed:
            if self.arrangement != "grid":
                self._arrange()
                self.kinds_changed.emit()
            self.active_changed.emit(name)
        self._set_at_hand(name)

    def _set_at_hand(self, name: str) -> None:
        if name != self._at_hand:
            self._at_hand = name
            self.at_hand_changed.emit(name)

    def activate_next(self, by: int = 1) -> None:
        """Choose the view after (or before) the active one."""
        names = list(self.tiles)
        if names:
            self.set_active(names[(names.index(self.active) + by) % len(names)])

    def _arrange(self) -> None:
        for tile in self.tiles.values():
            self._layout.removeWidget(tile)
        for line in range(8):
            self._layout.setRowStretch(line, 0)
            self._layout.setColumnStretch(line, 0)
        names = list(self.tiles)
        shown = self.visible_views()
        for name, tile in self.tiles.items():
            tile.setVisible(name in shown)
        if self.arrangement == "one-and-more" and len(names) > 1:
            self._arrange_one_and_more(names)
            return
        columns = math.ceil(math.sqrt(len(shown))) or 1
        for place, name in enumerate(shown):
            row, column = divmod(place, columns)
            self._layout.addWidget(self.tiles[name], row, column)
            self._layout.setRowStretch(row, 1)
            self._layout.setColumnStretch(column, 1)

    def _arrange_one_and_more(self, names: list[str]) -> None:
        others = [name for name in names if name != self.active]
        self._layout.addWidget(self.tiles[self.active], 0, 0, len(others), 1)
        self._layout.setColumnStretch(0, 3)
        self._layout.setColumnStretch(1, 1)
        for row, name in enumerate(others):
            self._layout.addWidget(self.tiles[name], row, 1)
            self._layout.setRowStretch(row, 1)
