"""What a feature may use, and nothing else."""

from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QMainWindow

from .services.actions import ActionRegistry
from .services.docks import Docks
from .services.failures import Notifier
from .services.tasks.task import Processes, TaskList
from .session.changes import Changes, Part
from .session.session import Session
from .session.view_state import ViewState
from .widgets.camera.camera_grid import CameraGrid
from .widgets.forms.message import MessageBar
from .widgets.redraw import RedrawQueue
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


def make_context(
    window: QMainWindow,
    messages: MessageBar,
    settings: QSettings,
    processes: Processes | None = None,
) -> Context:
    """Make the services for a window, which holds panels and actions.

    Processes that are given, for work that lasts, may serve other windows too and outlive this one.
    """
    notifier, changes = Notifier(messages, window.statusBar()), Changes(window)
    tasks, redraw = TaskList(notifier.error, window), RedrawQueue(window)

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
