"""What is shown is kept with the project, and shown again when it is opened again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project

from ...context import Context
from ...services.failures import message_of
from ...widgets.camera.picture import PICTURE_KINDS

_SETTING = "window"
_ALL = ""
_QUIET_MS = 1000
_BRIGHTNESS, _CONTRAST = (-0.8, 0.8), (0.25, 4.0)


class ViewMemory(QObject):
    """Keeps frame, workspace, pictures and light in the project; a read-only one is left alone."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._project: Project | None = None
        self._kept: Any = None
        self._now: dict[str, Any] | None = None
        self._timer = QTimer(self, singleShot=True, interval=_QUIET_MS)
        self._timer.timeout.connect(self._keep)
        context.session.project.opened.connect(self._on_opened)
        context.session.project.closing.connect(self._on_closing)
        for changed in (
            context.session.document.frame_changed, context.docks.workspace_changed,
            context.docks.views.kinds_changed, context.view_state.light_changed,
        ):  # fmt: skip
            changed.connect(self._note)

    @Slot()
    def _on_opened(self) -> None:
        project = self._session.project.project
        if project is None or project is self._project or not self._session.project.makes:
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
        document, docks, state = (
            self._session.document,
            self._context.docks,
            self._context.view_state,
        )
        if self._project is None or document.recording is None or not docks.workspace:
            return
        self._now = {
            "frame": document.frame,
            "workspace": docks.workspace,
            "pictures": {name: tile.kind for name, tile in docks.views.tiles.items()},
            "light": {
                _ALL: [state.display.brightness, state.display.contrast],
                **{name: list(light) for name, light in state.lights.items()},
            },
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
            self._context.notifier.say(
                f"Display settings could not be saved: {message_of(error).what}.", 6000
            )
        self._kept = now

    def _show(self, kept: Mapping[str, Any]) -> None:
        """Show what was shown last, but for what was asked for when opening."""
        document, docks = self._session.document, self._context.docks
        asked, frame = self._session.opening.asked, kept.get("frame")
        if not asked.frame and document.frame == 0 and type(frame) is int:
            document.go_to(frame)
        names = {space.name for space in docks.workspaces if not space.why_not()}
        wanted = str(kept.get("workspace")).strip().lower()
        if wanted in names - {docks.workspace} and not asked.workspace:
            docks.show_workspace(wanted)
        for name, kind in _pairs(kept.get("pictures")):
            if kind in PICTURE_KINDS:
                docks.views.show_kind(name, kind)
        self._show_light(dict(_pairs(kept.get("light"))))

    def _show_light(self, lights: Mapping[str, Any]) -> None:
        tiles = self._context.docks.views.tiles
        for name in (_ALL, *tiles):  # that of all first: it takes away the views' own
            light = _light(lights.get(name))
            if light is not None:
                self._context.view_state.set_light(*light, name)


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
