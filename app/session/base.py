"""Common ground of all parts of the session."""

from dataclasses import dataclass

from .changes import Changes
from .document import DocumentPresenter
from .edits import EditStack
from .jobs import Processes, TaskList
from .messages import Preferences, Tell
from .runs import RunList
from .view_state import ViewState


@dataclass(eq=False)
class Base:
    """The open recording, its runs and edits, and the services of the window, or of a test."""

    changes: Changes
    tell: Tell
    tasks: TaskList
    view_state: ViewState
    settings: Preferences
    given: Processes | None  # processes that outlive the session; None: it has its own

    def __post_init__(self) -> None:
        self.later = self.changes.loop.later
        """Make a timer that calls a function once, so many milliseconds after its start."""
        self.processes = self.given or Processes()
        self.runs = RunList(self.changes.tell)
        self.document = DocumentPresenter(self.changes, self.tasks, self.tell)
        self.edits = EditStack(self.changes.tell, self.tell)
        """Everything that a person did, to be undone and redone in one order."""
