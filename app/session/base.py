"""What every part of the session works with."""

from .changes import Changes
from .document import DocumentPresenter
from .edits import EditStack
from .jobs import Processes, TaskList
from .messages import Preferences, Tell
from .runs import RunList
from .view_state import ViewState


class Base:
    """The open recording, its runs and edits, and the services."""

    def __init__(
        self,
        changes: Changes,
        tell: Tell,
        tasks: TaskList,
        view_state: ViewState,
        settings: Preferences,
        processes: Processes | None = None,
    ) -> None:
        self.changes, self.tell, self.tasks = changes, tell, tasks
        self.later = changes.loop.later
        """Make a timer that calls a function once, so many milliseconds after its start."""
        self.view_state, self.settings = view_state, settings
        self.processes = processes or Processes()
        self.runs = RunList(changes.tell)
        self.document = DocumentPresenter(changes, tasks, tell)
        self.edits = EditStack(changes.tell, tell)
        """Everything that a person did, to be undone and redone in one order."""
