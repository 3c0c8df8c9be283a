"""What a feature may use, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QMainWindow

from .services.actions import ActionRegistry
from .services.docks import Docks
from .services.failures import Notifier
from .services.tasks.task import Processes, TaskList
from .session.session import Session
from .session.view_state import ViewState
from .widgets.forms.message import MessageBar


@dataclass(frozen=True, eq=False)
class Context:
    """The seven services of the workbench."""

    session: Session
    """What is open and what is known about it."""
    view_state: ViewState
    """What is chosen of what is shown."""
    tasks: TaskList
    """Work in the background."""
    actions: ActionRegistry
    """Everything that can be done: menus, palette, toolbars and shortcuts follow from it."""
    docks: Docks
    """Views, panels and workspaces."""
    notifier: Notifier
    """Messages and the status line."""
    settings: QSettings
    """What is kept for the next start, apart from all data."""


def make_context(
    window: QMainWindow,
    messages: MessageBar,
    settings: QSettings,
    processes: Processes | None = None,
) -> Context:
    """Make the services for a window, which holds panels and actions.

    Processes that are given, for work that lasts, may serve other windows too and outlive this one.
    """
    notifier, view_state = Notifier(messages, window.statusBar()), ViewState(window)
    tasks, docks = TaskList(notifier.error, window), Docks(window, settings, notifier)
    session = Session(notifier.show, tasks, view_state, settings, window, processes)
    actions = ActionRegistry(window, settings, docks.redraw, notifier.say)
    tasks.watch(docks.redraw.settled)
    return Context(session, view_state, tasks, actions, docks, notifier, settings)
