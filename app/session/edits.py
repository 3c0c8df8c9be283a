"""What undo and redo do next: edits that the project stores, and those of the window, in one order.

Edits of the window (parameters, points of a calibration) are kept here until the recording is
closed. Between them stand the numbers of the edits that were stored meanwhile; what was stored
before is known by the project's history alone.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.project.history import Changed, Entry
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import RUN

from .changes import Part, TellChange
from .messages import Tell, message_of


@dataclass(frozen=True, eq=False)
class WindowEdit:
    """A command that changes something of the window alone from one value to another."""

    words: str  # what it does, as a menu shows it after "Undo"
    put: Callable[[Any], None]  # lets a value be in effect
    before: Any
    after: Any
    workspace: str = ""
    panel: str = ""
    slot: Hashable = None
    """What it changes: the next change of the same, with nothing done between, is one with it."""


@dataclass(frozen=True)
class Moved:
    """What was undone or redone."""

    words: str
    how: Literal["undone", "redone"]
    changed: Changed | None = None
    edit: WindowEdit | None = None


_Made: TypeAlias = WindowEdit | int
"""An edit of the window, or the number of one that the project stores."""


class EditStack:
    """What undo and redo do next, whether the project stores it or not."""

    def __init__(self, tell_change: TellChange, tell: Tell) -> None:
        self._tell_change, self._show = tell_change, tell
        self._project: Project | None = None
        self._done: list[_Made] = []
        self._undone: list[_Made] = []
        self._stored: tuple[Entry | None, Entry | None] = (None, None)

    def set_project(self, project: Project | None) -> None:
        """Go on with another project's edits; what was made before it came is newer than they."""
        if project is not self._project:
            if self._project is not None:
                self._done, self._undone = [], []
            self._project = project
            self._tell()

    def clear(self) -> None:
        """Forget the edits of the window, whose recording is closed."""
        self._done, self._undone = [], []
        self._tell()

    def to_undo(self) -> WindowEdit | Entry | None:
        return self._next(self._done, self._stored[0])

    def to_redo(self) -> WindowEdit | Entry | None:
        return self._next(self._undone, self._stored[1])

    def do(self, edit: WindowEdit) -> None:
        edit.put(edit.after)
        self.add(edit)

    def add(self, edit: WindowEdit) -> None:
        """Take note of an edit that is in effect; stored ones that were undone can be redone."""
        # others that were undone would come back from values that are no longer in effect
        self._undone = [made for made in self._undone if isinstance(made, int)]
        last = self._done[-1] if self._done else None
        if isinstance(last, WindowEdit) and edit.slot is not None and last.slot == edit.slot:
            self._done.pop()
            edit = replace(edit, before=last.before)
        if edit.slot is None or edit.before != edit.after:
            self._done.append(edit)
        self._tell()

    def close_last(self) -> None:
        """Let a later change of what was changed last be an edit of its own."""
        last = self._done[-1] if self._done else None
        if isinstance(last, WindowEdit):
            self._done[-1] = replace(last, slot=None)

    def undo(self) -> None:
        self._step(self._done, self._undone, "undone")

    def redo(self) -> None:
        self._step(self._undone, self._done, "redone")

    def follow(self, changed: Changed) -> None:
        """Take note of what has happened to the project."""
        if changed.tables == {RUN.name}:
            return
        self._look()
        if changed.how == "done":
            self._undone = []
            stored = self._stored[0]
            if stored is not None and stored.number not in self._done[-1:]:
                self._done.append(stored.number)
        else:
            undone = changed.how == "undone"
            source, target = (self._done, self._undone)[:: 1 if undone else -1]
            places = [k for k, made in enumerate(source) if isinstance(made, int)]
            if places:
                target.append(source.pop(places[-1]))
        self._tell_change(Part.EDITS)

    # ---- inside

    @staticmethod
    def _next(made: list[_Made], stored: Entry | None) -> WindowEdit | Entry | None:
        last = made[-1] if made else None
        return last if isinstance(last, WindowEdit) else stored

    def _step(
        self, source: list[_Made], target: list[_Made], how: Literal["undone", "redone"]
    ) -> None:
        last, project = source[-1] if source else None, self._project
        if isinstance(last, WindowEdit):
            last.put(last.before if how == "undone" else last.after)
            target.append(source.pop())
            self._tell()
            self._tell_change(Part.MOVED, Moved(last.words, how, edit=last))
        elif project is not None and not project.read_only:
            try:
                changed = project.undo() if how == "undone" else project.redo()
            except InputError as error:
                self._show(message_of(error))
                self._tell()
                return
            if changed is not None:
                self._tell_change(Part.MOVED, Moved(changed.words, how, changed))

    def _look(self) -> None:
        """Read once per edit what would otherwise be asked for with every refresh."""
        self._stored = (None, None)
        if self._project is None or self._project.read_only:
            return
        try:
            self._stored = self._project.history.to_undo(), self._project.history.to_redo()
        except InputError as error:
            self._show(message_of(error))

    def _tell(self) -> None:
        self._look()
        self._tell_change(Part.EDITS)
