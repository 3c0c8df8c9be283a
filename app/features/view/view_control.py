"""What the commands of the menu View do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...services.stored import stored_texts
from ...widgets.camera.click_marks import CLICK_OVERLAYS
from ...widgets.camera.overlays import OVERLAYS
from .scene import PointColour

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_NOBODY_KNOWN = (
    "Nothing tells yet where the person is: click two landmarks in a view, or track. The views "
    "zoom with the next frame then."
)


class ViewControl:
    """Overlays, arrangement, zoom, loupe and the layers of the scene."""

    def __init__(self, window: MainWindow) -> None:
        self._w = window

    def toggle_overlay(self, name: str) -> None:
        """Switch an overlay."""
        w = self._w
        w.follower.change_display(overlays=w.grid.display.overlays ^ {name})
        w.settings.setValue("overlays_shown", sorted(w.grid.display.overlays))

    def stored_overlays(self) -> frozenset[str] | None:
        """Overlays that were switched on last time; those that came since are as usual."""
        names = stored_texts(self._w.settings, "overlays_shown")
        if names is None:
            return None
        return frozenset(names) & frozenset((*OVERLAYS, *CLICK_OVERLAYS))

    def overlay_on(self, name: str) -> bool:
        """Whether an overlay is switched on."""
        return name in self._w.grid.display.overlays

    def arranged(self, arrangement: str) -> bool:
        """Whether the views are arranged this way."""
        return self._w.grid.arrangement == arrangement

    def toggle_loupe(self) -> None:
        """Switch the loupe."""
        self._w.follower.change_display(loupe=not self._w.grid.display.loupe)

    def toggle_loupe_corner(self) -> None:
        """Keep the loupe in a corner, or at the cursor; switches it on where it is off."""
        corner = not self._w.grid.display.loupe_in_corner
        self._w.follower.change_display(loupe_in_corner=corner, loupe=True)

    def toggle_keep_person(self) -> None:
        """Enlarge and follow the person, or show whole pictures."""
        w = self._w
        w.follower.change_display(keep_person=not w.grid.display.keep_person)
        w.settings.setValue("keep_person", w.grid.display.keep_person)
        known = any(tile.camera.person_box() is not None for tile in w.grid.tiles.values())
        if w.grid.display.keep_person and not known:
            w.statusBar().showMessage(_NOBODY_KNOWN, 6000)

    def toggle_single(self) -> None:
        """Show the active view alone, or all."""
        grid = self._w.grid
        grid.set_arrangement("grid" if grid.arrangement == "single" else "single")

    def zoom(self, factor: float) -> None:
        """Zoom the active view about its middle."""
        camera = self._w.grid.active_camera()
        if camera is not None:
            camera.zoom_by(factor)

    def zoom_fit(self) -> None:
        """Show whole pictures."""
        if self._w.grid.display.keep_person:
            self.toggle_keep_person()
        for tile in self._w.grid.tiles.values():
            tile.camera.fit()

    @property
    def point_colour(self) -> PointColour:
        """How the scene's points are coloured."""
        return self._w.follower.point_colour

    def colour_points(self, kind: PointColour) -> None:
        """Colour the scene's points in another way."""
        self._w.follower.colour_points(kind)

    def toggle_layer(self, layer: str) -> None:
        """Show or hide a part of the scene."""
        scene = self._w.scene
        scene.set_layer_visible(layer, not scene.layer_visible(layer))
        self._w.instant.tell_soon()
