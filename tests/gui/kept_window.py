"""A window for several tests: put back after each, made anew where something else is left of it."""

import gc
import threading
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeAlias

from PySide6.QtCore import QEvent, QSettings
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.context import GarbageTimer
from app.session.changes import Part
from app.session.jobs import Processes
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


def open_recording(window: MainWindow, qtbot: QtBot, recording: Path, **wanted: Any) -> None:
    """Open it and wait until all of it is painted."""
    window.context.session.open(recording, **wanted)
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None)
    qtbot.waitUntil(window.context.tasks.settled)


_Key: TypeAlias = tuple[Path, str]
"""The recording that is open, and the workspace that a window begins with."""


@dataclass(frozen=True)
class _First:
    """How a new window was with a recording."""

    stored: dict[str, Any]
    state: dict[str, Any]


class KeptWindow:
    """Gives one test after the other a window with a recording and an empty project.

    Whether it is as a new one was is compared (:func:`state_of`) and not taken for granted; where
    it is not, a new one is made.
    """

    def __init__(self, folder: Path, processes: Processes) -> None:
        self._folder, self._processes = folder, processes
        self._window: MainWindow | None = None
        self._key: _Key = (Path(), "")
        self._first: dict[_Key, _First] = {}
        self._made = 0

    def take(self, qtbot: QtBot, recording: Path, workspace: str, projects: Path) -> MainWindow:
        """A window with the recording, its project in `projects`; begins in `workspace`."""
        key = recording, workspace
        if self._window is not None:
            if key in self._first and self._is_back(self._window, qtbot, key, projects):
                return self._window
            self.close()
        self._made += 1
        settings = QSettings(str(self._folder / f"{self._made}.ini"), QSettings.Format.IniFormat)
        _begin(settings, workspace, projects)
        window = self._window = show_window(qtbot, settings, self._processes)
        GarbageTimer(window)  # it may be there for long
        open_recording(window, qtbot, recording)
        self._key = key
        self._first[key] = _First(stored_in(settings), state_of(window))
        return window

    def close(self) -> None:
        """Do without the window."""
        if self._window is not None:
            close_window(self._window)
            self._window.deleteLater()
            self._window = None

    def _is_back(self, window: MainWindow, qtbot: QtBot, key: _Key, projects: Path) -> bool:
        """Put the window back; whether it is as a new one was."""
        session, first = window.context.session, self._first[key]
        if not window.isVisible() or session.asked.project is not None:
            return False
        session.track.stop()
        window.messages.clear()
        qtbot.waitUntil(window.context.tasks.settled)
        _put_back_choices(window, first.state)
        document = session.document
        if self._key[0] == key[0] and document.recording is not None:
            _with_another_project(window, qtbot, first, projects)
        else:
            session.document.close()
            _begin(window.context.settings, key[1], projects)
            open_recording(window, qtbot, key[0])
        _put_back_views(window, first.state)
        _put_back_choice(window, first.state)
        qtbot.waitUntil(window.context.tasks.settled)
        window.messages.clear()
        window.statusBar().clearMessage()
        window.activateWindow()
        self._key = key
        return state_of(window) == first.state


def _begin(settings: QSettings, workspace: str, projects: Path) -> None:
    settings.clear()
    settings.setValue(_PROJECTS, str(projects))
    if workspace:
        settings.setValue("workspace", workspace)


def _put_back_choices(window: MainWindow, state: dict[str, Any]) -> None:
    """What is chosen of how things are done and shown, whatever is open."""
    session, view_state = window.context.session, window.context.view_state
    if (session.track.preset, session.track.settings) != state["tracking"]:
        session.track.choose(*state["tracking"])
    session.track.first_pose, session.track.follow = state["tracker"]
    tune = window.features.tune
    tune.parameters.search.clear()
    tune.trials.live, display = state["live"], state["shown"][0]
    view_state.set_light(display.brightness, display.contrast)
    view_state.select(None)
    view_state.show_fit(None)
    view_state.change_display(**{f.name: getattr(display, f.name) for f in fields(display)})
    view_state.set_threshold(state["shown"][3])
    view_state.colour_points(state["shown"][5])


def _put_back_views(window: MainWindow, state: dict[str, Any]) -> None:
    view_state = window.context.view_state
    if view_state.arrangement != state["arrangement"]:
        view_state.arrange(state["arrangement"])
    view_state.activate(next(iter(view_state.views)))
    for name, tile in window.context.docks.views.tiles.items():
        view_state.choose_kind(state["views"][name][0], name)
        tile.camera.fit()
        QApplication.sendEvent(tile.camera, QEvent(QEvent.Type.Leave))


def _put_back_choice(window: MainWindow, state: dict[str, Any]) -> None:
    annotating, (choice, advance) = window.features.annotate.clicking.annotating, state["chosen"]
    annotating.set_advance(advance)
    annotating.choose(choice.landmark)
    annotating.let_go()


def _with_another_project(window: MainWindow, qtbot: QtBot, first: _First, projects: Path) -> None:
    """Go on with the recording that is open, and an empty project."""
    session, docks = window.context.session, window.context.docks
    session.changes.tell(Part.LEAVING)  # what works on the runs stops
    session.project.close()
    session.runs.clear()
    session.document.loop = None
    session.document.visit(0)
    docks.timeline.set_visible_range(*first.state["timeline"])
    if docks.workspace != first.state["workspace"]:
        docks.show_named(first.state["workspace"])
    if panels_of(window) != first.state["panels"]:
        docks.reset()
    settings = window.context.settings
    settings.clear()
    for name, value in first.stored.items():
        settings.setValue(name, value)
    settings.setValue(_PROJECTS, str(projects))
    session.project.follow_recording()
    qtbot.waitUntil(lambda: session.project.project is not None)


def stored_in(settings: QSettings) -> dict[str, Any]:
    """Everything that the settings hold but where projects lie."""
    return {name: settings.value(name) for name in settings.allKeys() if name != _PROJECTS}


def panels_of(window: MainWindow) -> dict[str, tuple[bool, bool]]:
    """Which panels are there, and which of them are not behind another one."""
    every = ((name, window.context.docks.dock(name)) for name in window.context.docks.titles())
    return {name: (dock.isHidden(), dock.isVisible()) for name, dock in every}


def state_of(window: MainWindow) -> dict[str, Any]:
    """What a person sees or may do, and what would be found in the project."""
    context, annotating = window.context, window.features.annotate.clicking.annotating
    document, view_state, docks = context.session.document, context.view_state, context.docks
    tune = window.features.tune
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
        "panels": panels_of(window),
        "size": window.size(),
        "document": (document.frame, document.frame_count, document.playing, document.loop),
        "views": {
            name: (
                *(view_state.kinds[name], tile.camera.zoom, tile.camera.isVisible()),
                *(tile.camera.size(), tile.camera.place_of(0.0, 0.0)),
                tile.camera.label.words,
            )
            for name, tile in docks.views.tiles.items()
        },
        "shown": (
            *(view_state.display, view_state.hidden, view_state.selection, view_state.threshold),
            *(view_state.active_view, view_state.point_colour, view_state.fit),
        ),
        "arrangement": view_state.arrangement,
        "timeline": (docks.timeline.scale.first, docks.timeline.scale.last),
        "tracking": (context.session.track.preset, context.session.track.settings),
        "tracker": (context.session.track.first_pose, context.session.track.follow),
        "tune": (tune.parameters.search.text(), tune.parameters.against_box.currentIndex()),
        "live": tune.trials.live,
        "runs": [entry.name for entry in context.session.runs.entries],
        "project": project is not None and (project.history.entries(), project.clicks.all()),
        "chosen": (annotating.choice, annotating.advance),
        "messages": (window.messages.text(), window.statusBar().currentMessage()),
    }
