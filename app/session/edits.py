"""One stack of everything that a person did, in the order in which it was done.

Edits of the project are stored there and stay; those of the window alone (parameters, trials) are
kept here until the recording is closed. Each has its place in time by the stored edit before it.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, Literal

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.locks import now
from stereotrack_core.project.history import Changed, Entry
from stereotrack_core.project.project import Project

from ..services.failures import message_of

WINDOW = "window"
"""Kind of an edit that no project stores."""


@dataclass(frozen=True)
class WindowEdit:
    """A command that changes something of the window alone from one value to another."""

    words: str
    """What it does, as a menu shows it after "Undo"."""
    put: Callable[[Any], None]
    """Lets a value be in effect."""
    before: Any
    after: Any
    workspace: str = ""
    panel: str = ""
    """Where it can be seen."""
    frame: int | None = None
    """The frame in which it can be seen."""
    slot: Hashable = None
    """What it changes: the next change of the same, with nothing done between, is one with it."""
    is_data: bool = False
    """Whether it changes data. Only such an edit ends the redo of what was undone before; a setting
    or a dismissed note takes its place before that."""


@dataclass(frozen=True)
class Moved:
    """What was undone or redone."""

    words: str
    how: Literal["undone", "redone"]
    changed: Changed | None = None
    """What it did to the project."""
    edit: WindowEdit | None = None
    """What it did to the window."""


@dataclass(frozen=True, eq=False)
class _Made:
    """An edit of the window that was made after a stored edit."""

    edit: WindowEdit
    number: int
    """Of the stored edit before it."""
    at: str
    joined: bool
    """Whether it is a part of that stored edit."""
    closed: bool = False
    """Whether later changes of its slot are edits of their own."""

    def entry(self, who: str, place: int, *, done: bool) -> Entry:
        """Itself, as the history lists it."""
        state: Literal["done", "undone"] = "done" if done else "undone"
        return Entry(self.number, WINDOW, self.edit.words, who, self.at, state, place)


class EditStack(QObject):
    """What undo and redo do next, whether the project stores it or not."""

    changed = Signal()
    """Something was done, undone or redone."""
    moved = Signal(object)
    """Moved: a person has undone or redone something."""
    message = Signal(object)
    """Why something could not be undone or redone."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._project: Project | None = None
        self._made: list[_Made] = []
        self._done = 0
        self._next: tuple[Entry | None, Entry | None] = (None, None)

    # ---- what is there

    def set_project(self, project: Project | None) -> None:
        """Go on with another project's edits; what was made before it came is newer than they."""
        if project is self._project:
            return
        if self._project is not None:
            self._forget()
        self._project = project
        if project is not None and self._made:
            if any(made.edit.is_data for made in self._made):
                self._drop_stored_redo()
            number = self._number(joined=False)
            self._made = [replace(made, number=number, joined=False) for made in self._made]
        self._tell()

    @Slot()
    def clear(self) -> None:
        """Forget the edits of the window, whose recording is closed."""
        self._forget()
        self._tell()

    def to_undo(self) -> Entry | None:
        """The edit that undo takes back; None where there is none."""
        return self._next[0]

    def to_redo(self) -> Entry | None:
        """The edit that redo makes again; None where there is none."""
        return self._next[1]

    def entries(self, limit: int = 200, before: int | None = None) -> tuple[Entry, ...]:
        """The newest edits first: so many stored ones with what the window did after them.

        Those alone whose number is less than `before`.
        """
        stored: tuple[Entry, ...] = ()
        if self._project is not None:
            stored = self._project.history.entries(limit + 1, before)
        lowest = 0
        if len(stored) > limit:
            stored = stored[:limit]
            lowest = stored[-1].number if stored else 2**62
        highest = 2**62 if before is None else before
        who = self._project.who if self._project is not None else ""
        own = (
            made.entry(who, place, done=place <= self._done)
            for place, made in enumerate(self._made, start=1)
            if lowest <= made.number < highest and not made.joined
        )
        return tuple(sorted((*stored, *own), key=lambda entry: entry.order, reverse=True))

    # ---- what a person does

    def do(self, edit: WindowEdit, *, joined: bool = False) -> None:
        """Make an edit of the window; where it is joined it is a part of the last stored edit."""
        edit.put(edit.after)
        undone = self._made[self._done :]
        if edit.is_data:
            undone = []
            self._drop_stored_redo()
        # settings that were undone would come back from values that are no longer in effect
        undone = [made for made in undone if made.edit.is_data or made.joined]
        done = self._made[: self._done]
        last = done[-1] if done else None
        if last is not None and not joined and self._continues(last, edit):
            done.pop()
            edit = replace(edit, before=last.edit.before)
        if joined or edit.slot is None or edit.before != edit.after:
            done.append(_Made(edit, self._number(joined=joined), now(), joined))
        self._made, self._done = [*done, *undone], len(done)
        self._tell()

    def close_last(self) -> None:
        """Let a later change of what was changed last be an edit of its own."""
        self._close(self._done - 1)

    def withdraw(self, edit: WindowEdit) -> None:
        """Forget an edit whose effect the program has ended."""
        place = next((k for k, made in enumerate(self._made) if made.edit is edit), None)
        if place is not None:
            del self._made[place]
            self._done -= place < self._done
            self._close(place - 1)
            self._tell()

    @Slot()
    def undo(self) -> None:
        """Undo the last edit, and tell where it can be seen."""
        moved = self.step(back=True)
        if moved is not None:
            self.moved.emit(moved)

    @Slot()
    def redo(self) -> None:
        """Redo the edit that was undone last, and tell where it can be seen."""
        moved = self.step(back=False)
        if moved is not None:
            self.moved.emit(moved)

    def step(self, *, back: bool) -> Moved | None:
        """Undo or redo one edit; None where there is none, or it cannot be done."""
        made, stored = self._at_hand(back=back)
        if made is None and stored is None:
            return None
        changed: Changed | None = None
        try:
            if stored is not None and self._project is not None:
                changed = self._project.undo() if back else self._project.redo()
            if made is not None:
                made.edit.put(made.edit.before if back else made.edit.after)
                self._done += -1 if back else 1
            if not back:
                self._keep_again()
        except InputError as error:
            self.message.emit(message_of(error))
            self._tell()
            return None
        self._tell()
        how: Literal["undone", "redone"] = "undone" if back else "redone"
        if stored is not None:
            return Moved(stored.words, how, changed)
        return Moved(made.edit.words, how, edit=made.edit) if made is not None else None

    @Slot(object)
    def follow(self, changed: Changed) -> None:
        """Take note of what has happened to the project."""
        if changed.how == "done" and not changed.leaves_redo:
            del self._made[self._done :]
        self._tell()

    # ---- inside

    def _close(self, place: int) -> None:
        if place >= 0:
            self._made[place] = replace(self._made[place], closed=True)

    def _at_hand(self, *, back: bool) -> tuple[_Made | None, Entry | None]:
        """What is undone (or redone) next: of the window, of the project, or both as one."""
        stored = self._stored(back=back)
        place = self._done - 1 if back else self._done
        made = self._made[place] if 0 <= place < len(self._made) else None
        if made is None or stored is None:
            return made, stored
        if made.joined and made.number == stored.number:
            return made, stored
        made_later = made.number >= stored.number
        return (made, None) if made_later == back else (None, stored)

    def _keep_again(self) -> None:
        """Redo the keeping of runs, which nobody asked for, with what was done before it."""
        made, stored = self._at_hand(back=False)
        while made is None and stored is not None and stored.state == "let go":
            if self._project is None or self._project.redo() is None:
                return
            made, stored = self._at_hand(back=False)

    def _stored(self, *, back: bool) -> Entry | None:
        """What the project would undo or redo; None as well where its history cannot be read."""
        if self._project is None or self._project.read_only:
            return None
        history = self._project.history
        try:
            return history.to_undo() if back else history.to_redo()
        except InputError as error:
            self.message.emit(message_of(error))
            return None

    def _continues(self, last: _Made, edit: WindowEdit) -> bool:
        same = edit.slot is not None and last.edit.slot == edit.slot and not last.closed
        return same and self._at_hand(back=True) == (last, None)

    def _number(self, *, joined: bool) -> int:
        """Number of the stored edit after which an edit of the window is made."""
        if self._project is None:
            return 0
        last = self._project.history.to_undo() if joined else None
        if last is not None:
            return last.number
        following = self._stored(back=False)
        return self._project.history.newest() if following is None else following.number - 1

    def _drop_stored_redo(self) -> None:
        if self._project is not None:
            try:
                self._project.drop_redo()
            except InputError as error:
                self.message.emit(message_of(error))

    def _forget(self) -> None:
        self._made, self._done = [], 0

    def _tell(self) -> None:
        """Read once per edit what would otherwise be asked for with every refresh."""
        found: list[Entry | None] = []
        for back in (True, False):
            made, stored = self._at_hand(back=back)
            found.append(stored)
            if made is not None and stored is None:
                found[-1] = made.entry("", self._done + (not back), done=back)
        self._next = (found[0], found[1])
        self.changed.emit()
