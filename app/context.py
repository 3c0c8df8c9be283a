"""What a feature may use, and nothing else."""

import gc
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QCoreApplication, QObject, QSettings, Qt, QTimer, Signal, Slot
from PySide6.QtWidgets import QMainWindow

from .services.actions import ActionRegistry
from .services.docks import Docks
from .services.failures import Notifier
from .session.changes import Changes, Part
from .session.jobs import Processes, TaskList
from .session.session import Session, Snapshot
from .session.surroundings import Loop
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

    def show(self, parts: Part, show: Callable[[Snapshot], object]) -> None:
        """Show what is known now, and again soon after one of these parts is new."""

        def piece() -> None:
            show(self.session.snapshot)

        self.session.changes.watch(parts, partial(self.docks.redraw.soon, piece))
        piece()


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
    views = CameraGrid(
        redraw, view_state.choose_kind, view_state.highlight, session.document.toggle_playing
    )
    scene, switched = SceneView(view_state.highlight), partial(changes.tell, Part.WORKSPACE)
    docks = Docks(window, settings, notifier, views, scene, switched)
    actions = ActionRegistry(window, settings, redraw, notifier.say)
    tasks.watch(redraw.settled)
    return Context(session, view_state, tasks, actions, docks, notifier, settings)


class _Post(QObject):
    """Calls functions in the window's thread, whichever thread posts them."""

    posted = Signal(object)

    def __init__(self) -> None:
        # it belongs to the program: a thread may post when the window is gone
        super().__init__(QCoreApplication.instance())
        self.posted.connect(self._call, Qt.ConnectionType.QueuedConnection)

    @Slot(object)
    def _call(self, do: Callable[[], object]) -> None:
        do()


def window_loop(window: QObject) -> Loop:
    """The event loop; timers end with the window."""
    return Loop(_Post().posted.emit, partial(later, window), is_alive)


_MANY = 50  # modules that bring so many objects that a collection would take long


class GarbageTimer(QObject):
    """Switches the automatic collection off and collects from the event loop instead.

    A collection may run the destructor of a Qt object; were it set off by an allocation in a worker
    thread, the object would be destroyed there while the window's thread still uses it.

    Nothing that modules bring is looked at again, whether they are loaded already or later on:
    that took a fifth of a second each time.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        gc.disable()
        self._keep_modules()
        self._timer = QTimer(self, interval=1000)
        self._timer.timeout.connect(self._collect)
        self._timer.start()

    def _keep_modules(self) -> None:
        self._loaded = len(sys.modules)
        gc.freeze()

    def _collect(self) -> None:
        if len(sys.modules) > self._loaded + _MANY:
            self._keep_modules()
        counts, limits = gc.get_count(), gc.get_threshold()
        due = [k for k in range(3) if limits[k] and counts[k] > limits[k]]
        if due:
            gc.collect(due[-1])
