"""The toolbars of the window, made from its commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QToolBar

from ..features.view.scene import POINT_COLOURS
from ..features.view.view_menu import SCENE_LAYERS, SCENE_SIDES
from ..widgets.camera.click_marks import CLICK_OVERLAYS
from ..widgets.forms.toolbars import add_toolbar
from ..widgets.scene.bar import SceneBar
from .window_panels import TITLES
from .workspaces.layout import WORKSPACES, Workspace

if TYPE_CHECKING:
    from .main_window import MainWindow

_OVERLAYS = ("outline", "reference", "points", "correspondences")


class WindowBars:
    """Workspaces, playback, tracker or annotation, and views; and the bar of the scene.

    Attributes
    ----------
    workspaces, play, track, annotate, view : QToolBar
    """

    def __init__(self, window: MainWindow) -> None:
        self._w = window
        spaces = tuple(f"workspace_{space.name}" for space in WORKSPACES)
        self.workspaces = add_toolbar(window, "Workspaces", self._named(spaces), words=True)
        go = ("first", "previous", "play", "next", "last")
        self.play = add_toolbar(window, "Playback", self._named(go), widgets=[window.transport])
        track = ("run", "pause", "step", "iterate", "run_here", "stop")
        self.track = add_toolbar(window, "Tracker", self._named(track))
        edit = self._named(("undo", "redo", "accept"))
        clicks = self._named(tuple(f"overlay_{name}" for name in CLICK_OVERLAYS))
        self.annotate = add_toolbar(window, "Annotation", [*edit, None, *clicks])
        other = ("arrange_grid", "arrange_one-and-more", "arrange_single", "keep_person", "loupe")
        overlays = self._named(tuple(f"overlay_{name}" for name in _OVERLAYS))
        self.view = add_toolbar(window, "Views", [*overlays, None, *self._named(other)])
        self._make_scene_bar()

    @property
    def all(self) -> tuple[QToolBar, ...]:
        """All toolbars of the window."""
        return (self.workspaces, self.play, self.track, self.annotate, self.view)

    def show_for(self, workspace: Workspace | None) -> None:
        """Show what a workspace needs; None: nothing."""
        annotating = workspace is not None and workspace.name == "annotate"
        for bar in self.all:
            fits = {self.annotate: annotating, self.track: not annotating}.get(bar, True)
            bar.setVisible(workspace is not None and fits)

    def _named(self, names: tuple[str, ...]) -> list[QAction]:
        return [self._w.actions_book.action(name) for name in names]

    def _make_scene_bar(self) -> None:
        layers = self._named(tuple(f"scene_{layer}" for layer in SCENE_LAYERS))
        sides = self._named(tuple(f"scene_from_{side}" for side in SCENE_SIDES))
        colours = self._named(tuple(f"points_{kind}" for kind in POINT_COLOURS))
        menus = [("Colour of the points", "theme", colours), ("Standard views", "scene", sides)]
        self._w.docks["scene"].setTitleBarWidget(SceneBar(TITLES["scene"], layers, menus))
