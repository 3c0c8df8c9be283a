"""Common ground of all parts of the session."""

from dataclasses import dataclass

from .changes import Changes
from .document import DocumentPresenter
from .edits import EditStack
from .jobs import Processes, TaskList
from .messages import Preferences, Tell
from .runs import RunList
from .view_state import ViewState


@dataclass(frozen=True, eq=False)
class Services:
    """Services of the window, or of a test."""

    changes: Changes
    tell: Tell
    tasks: TaskList
    view_state: ViewState
    settings: Preferences
    processes: Processes | None = None  # None: the session has its own


class Base:
    """The open recording, its runs and edits, and the services."""

    def __init__(self, services: Services) -> None:
        changes, tell, tasks = services.changes, services.tell, services.tasks
        self.changes, self.tell, self.tasks = changes, tell, tasks
        self.later = changes.loop.later
        """Make a timer that calls a function once, so many milliseconds after its start."""
        self.view_state, self.settings = services.view_state, services.settings
        self.processes = services.processes or Processes()
        self.runs = RunList(changes.tell)
        self.document = DocumentPresenter(changes, tasks, tell)
        self.edits = EditStack(changes.tell, tell)
        """Everything that a person did, to be undone and redone in one order."""
