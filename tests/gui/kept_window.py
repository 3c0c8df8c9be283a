"""A window for several tests: put back after each, made anew where something else is left of it."""

from __future__ import annotations

import gc
import threading
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QSettings
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.services.tasks.task import Processes
from app.shell.main_window import MainWindow
from app.widgets.style.theme import apply_theme
from tests.gui.hands import window_with

PATIENCE_MS = 300_000
"""Waiting ends as soon as what is waited for is there, so a busy machine may take its time."""

_PROJECTS = "projects_folder"


def show_window(qtbot: QtBot, settings: QSettings, processes: Processes) -> MainWindow:
    """A window on the screen, and the active one."""
    apply_theme(QApplication.instance(), "dark")
    gc.disable()
    made = window_with(settings, processes)
    made.resize(1366, 768)
    with qtbot.waitExposed(made):
        made.show()

    def active() -> bool:
        made.activateWindow()
        return made.isActiveWindow()

    qtbot.waitUntil(active)
    return made


def close_window(window: MainWindow) -> None:
    """Close it; nothing of it works on."""
    window.close()
    gc.enable()
    left = [t for t in threading.enumerate() if t.name in {"track", "frames read"}]
    for thread in left:
        thread.join(
            PATIENCE_MS / 1000
        )  # it has been told to end, and may be in the middle of a frame
    assert not any(thread.is_alive() for thread in left), f"threads outlive the window: {left}"


def open_recording(window: MainWindow, qtbot: QtBot, recording: Path) -> None:
    """Open it and wait until all of it is painted."""
    window.context.session.opening.open(recording)
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None, timeout=30_000)
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)


class KeptWindow:
    """Gives one test after the other a window with a recording and an empty project.

    Whether it is as when it was new is compared (:func:`state_of`) and not taken for granted.
    """

    def __init__(self, folder: Path, processes: Processes) -> None:
        self._folder, self._processes = folder, processes
        self._window: MainWindow | None = None
        self._key: tuple[Path, str] | None = None
        self._stored: dict[str, Any] = {}
        self._state: dict[str, Any] = {}
        self._made = 0

    def take(self, qtbot: QtBot, recording: Path, workspace: str, projects: Path) -> MainWindow:
        """A window with the recording, its project in `projects`; begins in `workspace`."""
        key = recording, workspace
        if self._window is not None and self._key == key and self._is_back(qtbot, projects):
            return self._window
        self.close()
        settings = QSettings(str(self._folder / f"{self._made}.ini"), QSettings.Format.IniFormat)
        settings.setValue(_PROJECTS, str(projects))
        if workspace:
            settings.setValue("workspace", workspace)
        self._made += 1
        self._window, self._key = show_window(qtbot, settings, self._processes), key
        open_recording(self._window, qtbot, recording)
        self._stored = stored_in(settings)
        self._state = state_of(self._window)
        return self._window

    def close(self) -> None:
        """Do without the window."""
        if self._window is not None:
            close_window(self._window)
            self._window.deleteLater()
            self._window = None

    def _is_back(self, qtbot: QtBot, projects: Path) -> bool:
        """Put the window back; whether it is as it was when it was new."""
        window = self._window
        assert window is not None
        session, settings = window.context.session, window.context.settings
        if not window.isVisible() or session.document.recording is None or session.runs.entries:
            return False
        session.project.close()
        session.document.visit(0)
        window.context.view_state.select(None)
        state, views = window.context.view_state, window.context.docks.views
        state.activate(next(iter(state.views)))
        for name, tile in views.tiles.items():
            state.choose_kind(self._state["views"][name][0], name)
            tile.camera.fit()
            QApplication.sendEvent(tile.camera, QEvent(QEvent.Type.Leave))
        window.context.docks.show_named(self._state["workspace"])
        chosen, advance = self._state["chosen"]
        window.features.annotate.clicking.annotating.set_advance(advance)
        settings.clear()
        for name, value in self._stored.items():
            settings.setValue(name, value)
        settings.setValue(_PROJECTS, str(projects))
        session.project._on_recording_opened()  # as for one that has just been opened
        qtbot.waitUntil(lambda: session.project.project is not None)
        window.features.annotate.clicking.annotating._choose(chosen)
        qtbot.waitUntil(window.context.tasks.settled)
        window.messages.clear()
        window.statusBar().clearMessage()
        window.activateWindow()
        return state_of(window) == self._state


def stored_in(settings: QSettings) -> dict[str, Any]:
    """Everything that the settings hold but where projects lie."""
    return {name: settings.value(name) for name in settings.allKeys() if name != _PROJECTS}


def state_of(window: MainWindow) -> dict[str, Any]:
    """What a person sees or may do, and what would be found in the project."""
    context, annotating = window.context, window.features.annotate.clicking.annotating
    document, view_state, docks = context.session.document, context.view_state, context.docks
    context.actions.refresh()
    project = context.session.project.project
    return {
        "settings": stored_in(context.settings),
        "commands": {
            command.id: (action.isEnabled(), action.isChecked(), action.text(), action.toolTip())
            for command in context.actions.commands
            for action in [context.actions.action(command.id)]
        },
        "workspace": docks.workspace,
        "panels": {name: docks.is_shown(name) for name in docks.titles()},
        "size": window.size(),
        "document": (document.frame, document.frame_count, document.playing, document.loop),
        "views": {
            name: (
                *(view_state.kinds[name], tile.camera.zoom, tile.camera.isVisible()),
                *(tile.camera.size(), tile.camera.place_of(0.0, 0.0)),
                *(tile.camera.label.words, view_state.light(name)),
            )
            for name, tile in docks.views.tiles.items()
        },
        "shown": (
            *(view_state.display, view_state.hidden, view_state.selection, view_state.threshold),
            *(view_state.active_view, view_state.point_colour, view_state.fit),
        ),
        "timeline": (docks.timeline.scale.first, docks.timeline.scale.last),
        "tracking": (context.session.track.preset, context.session.track.settings),
        "runs": [entry.name for entry in context.session.runs.entries],
        "project": project is not None and (project.history.entries(), project.clicks.all()),
        "chosen": (annotating.choice, annotating.advance),
        "messages": (window.messages.text(), window.statusBar().currentMessage()),
    }
