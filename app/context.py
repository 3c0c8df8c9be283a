"""What a feature may use, and nothing else."""

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QObject, QSettings, QTimer
from PySide6.QtWidgets import QMainWindow

from .services.actions import ActionRegistry
from .services.docks import Docks
from .services.failures import Notifier, Post
from .session.changes import Changes, Part
from .session.jobs import Processes, TaskList
from .session.messages import Loop
from .session.session import Session, Snapshot
from .session.view_state import ViewState
from .widgets.camera.camera_grid import CameraGrid
from .widgets.forms.message import MessageBar
from .widgets.redraw import RedrawQueue, is_alive, later
from .widgets.scene.scene_view import SceneView


@dataclass(frozen=True, eq=False)
class Context:
    """The seven services of the workbench."""

    session: Session
    view_state: ViewState
    tasks: TaskList
    actions: ActionRegistry
    """Everything that can be done: menus, palette, toolbars and shortcuts follow from it."""
    docks: Docks
    notifier: Notifier
    settings: QSettings  # what is kept for the next start, apart from all data

    def show(self, parts: Part, show: Callable[[Snapshot], object], panel: str = "") -> None:
        """Show what is known now, and again soon after one of these parts is new.

        What stands in a panel alone is shown only while that panel is seen.
        """

        def piece() -> None:
            if not panel or self.docks.is_seen(panel):
                show(self.session.snapshot)

        self.session.changes.watch(parts, partial(self.docks.redraw.soon, piece))
        if panel:
            seen = self.docks.dock(panel).visibilityChanged
            seen.connect(lambda _: self.docks.redraw.soon(piece))
        show(self.session.snapshot)


def make_context(
    window: QMainWindow,
    messages: MessageBar,
    settings: QSettings,
    processes: Processes | None = None,
) -> Context:
    """Make the services for a window, which holds panels and actions.

    Processes that are given, for work that lasts, may serve other windows too and outlive this one.
    """
    notifier, changes = Notifier(messages, window.statusBar()), Changes(window_loop(window))
    tasks = TaskList(changes.loop, notifier.error, partial(changes.tell, Part.TASKS))
    redraw = RedrawQueue(window)

    def scene_shows_points() -> bool:
        return docks.scene.is_seen() and docks.scene.layer_visible("cloud")

    view_state = ViewState(changes.tell, scene_shows_points)
    session = Session(changes, notifier.show, tasks, view_state, settings, processes)
    views = CameraGrid(redraw, view_state.choose_kind, view_state.highlight)
    scene = SceneView(view_state.highlight, redraw)
    docks = Docks(window, settings, notifier, views, scene, view_state.show_workspace)
    actions = ActionRegistry(window, settings, notifier.say)
    tasks.watch(redraw.settled)
    tasks.watch(actions.settled)
    changes.hear(Part.SAID, notifier.say)
    return Context(session, view_state, tasks, actions, docks, notifier, settings)


def window_loop(window: QObject) -> Loop:
    """The event loop; timers end with the window."""
    return Loop(Post().posted.emit, partial(later, window), is_alive)


_LONG_S = 0.002
"""Processor time after which what outlives a collection is not looked at again. What comes with a
recording and with a run's first frames took 20 to 50 ms each time."""


class GarbageTimer(QObject):
    """Switches the automatic collection off and collects from the event loop instead.

    A collection may run the destructor of a Qt object; were it set off by an allocation in a worker
    thread, the object would be destroyed there while the window's thread still uses it.

    What modules have brought and what outlives a long collection is not looked at again: a fifth of
    a second each time, in which the window stood still. Only when a recording was closed, all is.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        gc.disable()
        self.looks_at_all = False
        """Whether the next collection looks at everything, as a recording was closed."""
        gc.freeze()
        self.timer = QTimer(self, interval=1000)
        self.timer.timeout.connect(self._collect)
        self.timer.start()

    def _collect(self) -> None:
        if self.looks_at_all:
            self.looks_at_all = False
            gc.unfreeze()
            gc.collect()
            gc.freeze()
        counts, limits = gc.get_count(), gc.get_threshold()
        due = [k for k in range(3) if limits[k] and counts[k] > limits[k]]
        begun = time.thread_time()
        if due:
            gc.collect(due[-1])
        if time.thread_time() - begun > _LONG_S:
            gc.freeze()
