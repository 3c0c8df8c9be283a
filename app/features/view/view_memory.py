"""What is shown is kept with the project, and shown again when it is opened again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project

from ...services.failures import message_of
from ...shell.window_menu import why_no_workspace
from ...shell.workspaces.layout import workspace_named
from ...widgets.camera.picture import PICTURE_KINDS

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_SETTING = "window"
_ALL = ""
_QUIET_MS = 1000
_BRIGHTNESS, _CONTRAST = (-0.8, 0.8), (0.25, 4.0)


class ViewMemory(QObject):
    """Keeps frame, workspace, pictures and light in the project; a read-only one is left alone."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = window
        self._project: Project | None = None
        self._kept: Any = None
        self._now: dict[str, Any] | None = None
        self._timer = QTimer(self, singleShot=True, interval=_QUIET_MS)
        self._timer.timeout.connect(self._keep)
        window.project.opened.connect(self._on_opened)
        window.project.closing.connect(self._on_closing)
        for changed in (
            window.document.frame_changed, window.spaces.changed, window.grid.kinds_changed,
            window.display_panel.changed,
        ):  # fmt: skip
            changed.connect(self._note)

    @Slot()
    def _on_opened(self) -> None:
        project = self._w.project.project
        if project is None or project is self._project or not self._w.project.makes:
            return  # where only a picture is made, nothing is looked up and nothing left behind
        self._project, self._now = project, None
        self._kept = project.view_settings.get(_SETTING)
        if isinstance(self._kept, dict):
            self._show(self._kept)
        self._note()

    @Slot()
    def _on_closing(self) -> None:
        self._keep()
        self._timer.stop()
        self._project = self._now = None

    @Slot()
    def _note(self, *_what: object) -> None:
        """Remember what is shown now; it is written when nothing has changed for a second."""
        w = self._w
        space = w.spaces.current
        if self._project is None or w.document.recording is None or space is None:
            return
        grid, every = w.grid, (w.grid.display.brightness, w.grid.display.contrast)
        lights = {name: grid.light(name) for name in grid.tiles}
        own = {name: list(light) for name, light in lights.items() if light != every}
        self._now = {
            "frame": w.document.frame,
            "workspace": space.name,
            "pictures": {name: tile.kind for name, tile in grid.tiles.items()},
            "light": {_ALL: list(every), **own},
        }
        self._timer.start()

    @Slot()
    def _keep(self) -> None:
        project, now = self._project, self._now
        if project is None or project.read_only or now is None or now == self._kept:
            return
        try:
            project.view_settings.set(_SETTING, now)
        except InputError as error:
            self._w.statusBar().showMessage(
                f"What is shown could not be kept: {message_of(error).what}.", 6000
            )
        self._kept = now

    def _show(self, kept: Mapping[str, Any]) -> None:
        """Show what was shown last, but for what was asked for when opening."""
        w = self._w
        asked, frame = w.files.asked, kept.get("frame")
        if not asked.frame and w.document.frame == 0 and type(frame) is int:
            w.document.go_to(frame)
        space = workspace_named(str(kept.get("workspace")))
        wanted = space is not None and space is not w.spaces.current and not asked.workspace
        if space is not None and wanted and not why_no_workspace(w, space):
            w.spaces.show(space)
        for name, kind in _pairs(kept.get("pictures")):
            if kind in PICTURE_KINDS:
                w.grid.show_kind(name, kind)
        self._show_light(dict(_pairs(kept.get("light"))))

    def _show_light(self, lights: Mapping[str, Any]) -> None:
        grid = self._w.grid
        for name in (_ALL, *grid.tiles):  # that of all first: it takes away the views' own
            light = _light(lights.get(name))
            if light is not None:
                grid.set_light(*light, name)
        self._w.display_panel.show_light(grid.active, *grid.light(grid.active))


def _pairs(stored: Any) -> list[tuple[str, Any]]:
    """Names and values of a mapping that somebody else may have written."""
    return [(str(name), value) for name, value in stored.items()] if type(stored) is dict else []


def _light(stored: Any) -> tuple[float, float] | None:
    """Brightness and contrast within what can be chosen; None for anything else."""
    if not (isinstance(stored, list) and len(stored) == 2):
        return None
    if not all(isinstance(one, int | float) and np.isfinite(one) for one in stored):
        return None
    return float(np.clip(stored[0], *_BRIGHTNESS)), float(np.clip(stored[1], *_CONTRAST))
