"""All views beside each other, always at the same instant."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from PySide6.QtCore import QRectF, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QGridLayout, QWidget

from stereotrack_core.recording.description import View

from ..redraw import RedrawQueue
from ..style.building import choice, hbox, label, vbox
from .camera_view import CameraView
from .click_marks import ClickMarks
from .picture import PICTURE_KINDS, Arrangement, Display, Picture, PictureKind, kinds_of

_Places: TypeAlias = dict[str, tuple[int, int, int, int]]
"""Row, column, rows and columns of each view that is shown."""
_HEAD = 26
"""Pixels above each picture, about."""


def _kind_words(view: View, kind: PictureKind) -> str:
    """Name of a picture, said for this view."""
    if kind == "image":
        return "Right image" if view.kind == "stereo" else "Image"
    return PICTURE_KINDS[kind]


class CameraTile(QFrame):
    """One view with its name and the choice of what it shows."""

    def __init__(self, view: View, grid: CameraGrid) -> None:
        super().__init__(grid)
        self.view = view
        self.camera = CameraView(view.name, grid)
        self.camera.setAccessibleName(f"View {view.name}")
        self._name = label(view.name, "heading", wraps=False)
        kinds = [(kind, _kind_words(view, kind)) for kind in kinds_of(view)]
        name, tip = f"Image shown in view {view.name}", "Image shown in this view"
        self._kind = choice(name, kinds, tip)
        self._kind.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._note = label(wraps=False)
        head = hbox(self._name, self._kind, (self._note, 1), margins=(8, 2, 4, 2), spacing=8)
        self.setLayout(vbox(head, (self.camera, 1), spacing=0))
        self._kind.setVisible(self._kind.count() > 1)
        self._kind.activated.connect(
            lambda: grid.kind_chosen.emit(self._kind.currentData(), view.name)
        )

    def show_kind(self, kind: PictureKind) -> None:
        """Name the kind of picture that is shown."""
        self._kind.setCurrentIndex(self._kind.findData(kind))

    def set_active(self, active: bool) -> None:
        """Mark the view that keys act on."""
        self._name.setText(f"▸ {self.view.name}" if active else self.view.name)

    def show_picture(self, picture: Picture) -> None:
        """Show a picture with its message."""
        self.camera.show_picture(picture)
        note = picture.message if picture.pixels is not None else ""
        self._note.setText(note)
        self._note.setToolTip(note)


class CameraGrid(QWidget):
    """The views of a recording, in rows and columns that give their pictures the most room."""

    kind_chosen = Signal(str, str)
    """A kind of picture that shall be shown, and the name of the view."""
    hovered = Signal(str)
    """Words about the pixel under the cursor; empty when the cursor leaves."""
    limb_clicked = Signal(str)
    """A limb was clicked in a view; empty for a click beside the model."""
    activated = Signal(str)
    """Name of the view that keys shall act on."""
    at_hand_changed = Signal(str)
    """Name of the view that a click goes to, and keys about clicks act on."""
    clicked = Signal(object)
    """Action that a click in a view means, if :meth:`set_clicking` allows clicks."""
    refused = Signal(str)
    """Why a click was not taken."""
    space_tapped = Signal()
    """The space bar was pressed, but not to move the picture."""

    def __init__(self, redraw: RedrawQueue, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.redraw = redraw
        self.tiles: dict[str, CameraTile] = {}
        """Tiles by the name of their view."""
        self.active = self._at_hand = ""
        """Name of the view that keys act on; empty without views."""
        self._aspects: Mapping[str, float] = {}
        self._whole: Mapping[str, float] = {}
        self._arrangement: Arrangement = "grid"
        self._places: _Places = {}
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

    def set_views(self, views: Sequence[View], aspects: Mapping[str, float]) -> None:
        """Show other views; `aspects` are width by height of their upright images, by name."""
        for tile in self.tiles.values():
            self._layout.removeWidget(tile)
            tile.hide()
            tile.deleteLater()
        self.tiles, self._whole, self._aspects, self._places = {}, aspects, aspects, {}
        for view in views:
            tile = CameraTile(view, self)
            tile.camera.set_display(self._display_of(view.name))
            tile.camera.set_clicking(*self._clicking)
            self.tiles[view.name] = tile
        self.active = self._at_hand = ""
        if views:
            self.set_active(views[0].name)

    def set_homes(self, boxes: Mapping[str, QRectF]) -> None:
        """Begin with these parts of the pictures, in raw pixels by the name of the view."""
        homes = {}
        for name, box in boxes.items():
            if name in self.tiles and self.tiles[name].camera.set_home(box):
                turned = self.tiles[name].view.display_rotation % 180 == 90
                homes[name] = (box.height() / box.width()) ** (1 if turned else -1)
        self._aspects = {**self._whole, **homes}
        self._arrange()

    def fit(self) -> None:
        """Show whole pictures."""
        for tile in self.tiles.values():
            tile.camera.fit()
        self._aspects = self._whole
        self._arrange()

    def visible_views(self) -> tuple[str, ...]:
        """Names of the views that the arrangement shows."""
        if self._arrangement == "single" and self.active:
            return (self.active,)
        return tuple(self.tiles)

    def show_pictures(self, pictures: Sequence[Picture]) -> None:
        """Show the pictures of one instant."""
        for place, picture in enumerate(pictures):
            tile = self.tiles.get(picture.view)
            if tile is not None:
                tile.camera.legend = place == 0  # once is enough
                tile.show_picture(picture)

    def show_kinds(self, kinds: Mapping[str, PictureKind]) -> None:
        """Name the kind of picture that each view shows."""
        for name, kind in kinds.items():
            self.tiles[name].show_kind(kind)

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

    def arrange(self, arrangement: Arrangement) -> None:
        """Arrange the views in another way."""
        self._arrangement = arrangement
        self._arrange()

    def set_active(self, name: str) -> None:
        """Mark the view that keys act on."""
        if name not in self.tiles:
            return
        self.active = name
        for tile in self.tiles.values():
            tile.set_active(tile.view.name == name and len(self.tiles) > 1)
        self._arrange()
        self.point_at(name)

    def point_at(self, name: str) -> None:
        """Let clicks go to the view that the mouse is over."""
        if name != self._at_hand:
            self._at_hand = name
            self.at_hand_changed.emit(name)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._arrange()

    def _arrange(self) -> None:
        """Put the tiles where their pictures get the most room; nothing moves without need."""
        shown = self.visible_views()
        places = self._places_of(shown)
        if places == self._places:
            return
        self._places = places
        for line in range(len(self.tiles) + 1):
            self._layout.setRowStretch(line, 0)
            self._layout.setColumnStretch(line, 0)
        for name, tile in self.tiles.items():
            self._layout.removeWidget(tile)
            tile.setVisible(name in shown)
        for name, place in places.items():
            self._layout.addWidget(self.tiles[name], *place)
        wide, rows = _shares(places, self._aspects)
        for column, share in wide.items():
            self._layout.setColumnStretch(column, round(100 * share))
        for row in range(rows):
            self._layout.setRowStretch(row, 1)

    def _places_of(self, shown: Sequence[str]) -> _Places:
        large = self.active if self._arrangement == "one-and-more" and len(shown) > 1 else ""
        offered = [_places(shown, columns, large) for columns in range(1, len(shown) + 1)]
        width, height = self.width(), self.height()
        return max(offered, key=lambda one: _covered(one, self._aspects, width, height), default={})


def _places(names: Sequence[str], columns: int, large: str) -> _Places:
    """Views in so many columns; beside a large one, if there is one, which is twice as high."""
    small = [name for name in names if name != large]
    rows = max(math.ceil(len(small) / columns), 2 if large else 1)
    first: _Places = {large: (0, 0, rows, 1)} if large else {}
    begin = len(first)
    return first | {
        name: (place // columns, begin + place % columns, 1, 1) for place, name in enumerate(small)
    }


def _shares(places: _Places, aspects: Mapping[str, float]) -> tuple[dict[int, float], int]:
    """Widths of the columns in heights of a row, as their pictures have them; number of rows."""
    wide: dict[int, float] = {}
    for name, (_, column, rows, _) in places.items():
        wide[column] = max(wide.get(column, 0.0), rows * aspects[name])
    return wide, max((row + rows for row, _, rows, _ in places.values()), default=0)


def _covered(places: _Places, aspects: Mapping[str, float], width: float, height: float) -> float:
    """Pixels that are picture when views stand so."""
    wide, rows = _shares(places, aspects)
    whole, covered = sum(wide.values()), 0.0
    for name, (_, column, high, _) in places.items():
        across = width * wide[column] / whole
        down = max(height * high / rows - _HEAD, 1.0)
        covered += min(across, down * aspects[name]) * min(down, across / aspects[name])
    return covered
