"""All views beside each other, always at the same instant."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QGridLayout

from stereotrack_core.recording.description import View

from ...session.view_state import PICTURE_KINDS, Arrangement, Display, PictureKind, kinds_of
from ..redraw import RedrawQueue
from ..style.building import choice, hbox, label, vbox
from .camera_view import CameraView, ViewActs
from .click_marks import ClickMarks
from .picture import Picture

_Places: TypeAlias = dict[str, tuple[int, int, int, int]]
"""Row, column, rows and columns of each view that is shown."""
_HEAD = 26  # pixels above each picture, about


class CameraTile(QFrame):
    """One view with its name and the choice of what it shows."""

    def __init__(self, view: View, grid: CameraGrid) -> None:
        super().__init__(grid)
        self.view = view
        self.camera = CameraView(view.name, grid)
        self.camera.setAccessibleName(f"View {view.name}")
        self.name, self.note = label(view.name, "heading", wraps=False), label(wraps=False)
        words = PICTURE_KINDS | {"image": "Right image" if view.kind == "stereo" else "Image"}
        kinds = [(kind, words[kind]) for kind in kinds_of(view)]
        self.kind = choice(
            f"Image shown in view {view.name}", kinds, "Image shown in this view",
            lambda kind: grid.choose_kind(kind, view.name),
        )  # fmt: skip
        self.kind.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        head = hbox(self.name, self.kind, (self.note, 1), margins=(8, 2, 4, 2), spacing=8)
        self.setLayout(vbox(head, (self.camera, 1), spacing=0))
        self.kind.setVisible(len(kinds) > 1)  # alone it would be a window for a moment


class CameraGrid(ViewActs):
    """The views of a recording, in rows and columns that give their pictures the most room.

    `choose_kind` is called with a kind of picture that shall be shown and the name of the view, and
    `choose_limb` with a limb that was clicked, empty beside the model.
    """

    def __init__(
        self,
        redraw: RedrawQueue,
        choose_kind: Callable[[PictureKind, str], object],
        choose_limb: Callable[[str], object],
    ) -> None:
        super().__init__(redraw, choose_limb)
        self.choose_kind = choose_kind
        self.tiles: dict[str, CameraTile] = {}
        self.active = ""  # name of the view that keys act on; empty without views
        self._aspects: Mapping[str, float] = {}
        self._whole: Mapping[str, float] = {}
        self._arrangement: Arrangement = "grid"
        self._places: _Places = {}
        self._display = Display()
        self._layout = QGridLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.setSpacing(3)

    @property
    def at_hand(self) -> str:
        """The view that the mouse was moved into or that was made active, whichever came last."""
        return self._at_hand if self._at_hand in self.visible_views() else self.active

    def active_camera(self) -> CameraView | None:
        return self.tiles[self.active].camera if self.active else None

    def set_views(self, views: Sequence[View], aspects: Mapping[str, float]) -> None:
        """Show other views; `aspects` are width by height of their upright images, by name."""
        for tile in self.tiles.values():
            self._layout.removeWidget(tile)
            tile.hide()
            tile.deleteLater()
        self.tiles, self._whole, self._aspects, self._places = {}, aspects, aspects, {}
        for view in views:
            tile = CameraTile(view, self)
            tile.camera.set_display(self._display)
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
        for tile in self.tiles.values():
            tile.camera.fit()
        self._aspects = self._whole
        self._arrange()

    def visible_views(self) -> tuple[str, ...]:
        if self._arrangement == "single" and self.active:
            return (self.active,)
        return tuple(self.tiles)

    def show_pictures(self, pictures: Sequence[Picture]) -> None:
        for picture in pictures:
            if tile := self.tiles.get(picture.view):
                tile.camera.show_picture(picture)
                note = picture.message if picture.pixels is not None else ""
                tile.note.setText(note)
                tile.note.setToolTip(note)

    def show_kinds(self, kinds: Mapping[str, PictureKind]) -> None:
        for name, kind in kinds.items():
            box = self.tiles[name].kind
            box.setCurrentIndex(box.findData(kind))

    def set_display(self, display: Display) -> None:
        self._display = display
        for tile in self.tiles.values():
            tile.camera.set_display(display)

    def set_marks(self, marks: Mapping[str, ClickMarks]) -> None:
        """Draw clicks by the name of the camera whose image they are of."""
        for tile in self.tiles.values():
            picture = tile.camera.picture
            tile.camera.set_marks(marks.get(picture.camera) if picture is not None else None)

    def set_clicking(self, clicking: bool, why_not: str = "") -> None:
        """Let the left button place clicks in all views, or say why it cannot."""
        if (clicking, why_not) != (self.clicking, self.why_no_clicks):
            self.clicking, self.why_no_clicks = clicking, why_not
            for tile in self.tiles.values():
                tile.camera.drop_click()

    def arrange(self, arrangement: Arrangement) -> None:
        self._arrangement = arrangement
        self._arrange()

    def set_active(self, name: str) -> None:
        if name not in self.tiles:
            return
        self.active = name
        for each, tile in self.tiles.items():  # mark the view that keys act on
            tile.name.setText(f"▸ {each}" if each == name and len(self.tiles) > 1 else each)
        self._arrange()
        self.point_at(name)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._arrange()

    def _arrange(self) -> None:
        """Put the tiles where their pictures get the most room; nothing moves without need."""
        shown = self.visible_views()
        large = self.active if self._arrangement == "one-and-more" and len(shown) > 1 else ""
        offered = [_places(shown, columns, large) for columns in range(1, len(shown) + 1)]
        room = self.width(), self.height()
        places = max(offered, key=lambda one: _covered(one, self._aspects, *room), default={})
        if places == self._places:
            return
        self._places = places
        wide, rows = _shares(places, self._aspects)
        # a layout keeps the lines that more views have needed before, and their shares
        lines = max(self._layout.rowCount(), self._layout.columnCount(), len(self.tiles) + 1)
        for line in range(lines):
            self._layout.setRowStretch(line, line < rows)
            self._layout.setColumnStretch(line, round(100 * wide.get(line, 0.0)))
        for name, tile in self.tiles.items():
            self._layout.removeWidget(tile)
            tile.setVisible(name in shown)
        for name, place in places.items():
            self._layout.addWidget(self.tiles[name], *place)


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
