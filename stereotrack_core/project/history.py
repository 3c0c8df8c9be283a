"""Every edit that was ever made, from which undo and redo work without limit.

Keeping a run is noted here as well, but is nothing that undo takes back: a run goes into the
project by itself when it has come to its end, at a moment nobody chose. Deleting it is an edit.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.project.connection import Access
from stereotrack_core.project.database import ProjectDamaged, making_sense
from stereotrack_core.project.edit import (
    Change,
    Edit,
    Stamp,
    State,
    as_json,
    change_of,
    without_idle,
)
from stereotrack_core.project.entries import store
from stereotrack_core.project.schema import EDITED_TABLES, RUN
from stereotrack_core.project.validity import makes_sense

How: TypeAlias = Literal["done", "undone", "dropped", "kept", "let go"]
"""State of an edit: in effect, taken back, taken back and then followed by another edit; or the
keeping of a run, which stays in effect, or was let go with what made it a run."""


@dataclass(frozen=True)
class Entry:
    """An edit in the history."""

    number: int
    kind: str
    words: str
    who: str
    at: str
    state: How
    place: int = 0
    """Of an edit that no project stores: its place among those that were made after the stored edit
    of that number. 0: it is stored itself."""

    @property
    def order(self) -> tuple[int, int]:
        """Sorts edits by when they were made."""
        return self.number, self.place


@dataclass(frozen=True)
class Changed:
    """What has just happened to a project: an edit in words, and its rows in their order."""

    words: str
    how: Literal["done", "undone", "redone"]
    changes: tuple[Change, ...]
    leaves_redo: bool = False
    """Whether what was undone before can still be redone: a run was kept."""

    @property
    def tables(self) -> frozenset[str]:
        """Names of the tables that have changed."""
        return frozenset(change.table.name for change in self.changes)

    def frames(self, table: str = "click") -> frozenset[int]:
        """Frames whose rows of a table have changed."""
        return frozenset(
            int(change.key[change.table.key.index("frame")] or 0)
            for change in self.changes
            if change.table.name == table and "frame" in change.table.key
        )


_SAVE = "save"
_KEEPS_A_RUN = (
    f"kind = '{_SAVE}' AND EXISTS (SELECT 1 FROM edit_change WHERE edit = number AND place = 0"  # noqa: S608 - constants
    f" AND changed_table = '{RUN.name}' AND before IS NULL)"
)
_EDITS = (
    "SELECT number, kind, words, who, at, CASE"  # noqa: S608 - constants
    f" WHEN state = 'done' AND {_KEEPS_A_RUN} THEN 'kept'"
    f" WHEN state = 'undone' AND {_KEEPS_A_RUN} THEN 'let go' ELSE state END FROM edit"
)
_NEXT = {
    "undone": f"{_EDITS} WHERE state = 'undone' ORDER BY number LIMIT 1",
    "done": f"{_EDITS} WHERE state = 'done' AND NOT ({_KEEPS_A_RUN}) ORDER BY number DESC LIMIT 1",
}
_KEPT_AS = (
    f"{_EDITS} JOIN edit_change ON edit = number WHERE state = 'done' AND {_KEEPS_A_RUN}"
    " AND changed_key = ? ORDER BY number DESC LIMIT 1"
)
_DROP = "UPDATE edit SET state = 'dropped' WHERE state = 'undone'"
_AGAIN = (
    "SELECT 1 FROM edit JOIN edit_change ON edit = number"
    " WHERE state = 'undone' AND changed_table = ? AND changed_key = ?"
)


class History:
    """The edits of a project; each one that is made, undone or redone is one transaction."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def to_undo(self) -> Entry | None:
        """What undo would take back."""
        return self._next("done")

    def to_redo(self) -> Entry | None:
        """What redo would make again."""
        return self._next("undone")

    def newest(self) -> int:
        """Number of the edit that was made last, whatever has become of it; 0 before the first."""
        row = self._access.row("SELECT max(number) FROM edit")
        return int(row[0] or 0) if row is not None else 0

    def entries(self, limit: int = 200, before: int | None = None) -> tuple[Entry, ...]:
        """The newest edits first, of those whose number is less than `before`."""
        rows = self._access.rows(
            f"{_EDITS} WHERE number < ? ORDER BY number DESC LIMIT ?",
            (2**62 if before is None else before, limit),
        )
        return tuple(Entry(*row) for row in rows)

    def changes_of(self, number: int) -> tuple[Change, ...]:
        """What an edit has changed."""
        rows = self._access.rows(
            "SELECT changed_table, changed_key, before, after FROM edit_change WHERE edit = ?"
            " ORDER BY place",
            (number,),
        )
        with making_sense(self._access.path):
            return tuple(change_of(EDITED_TABLES[name], *texts) for name, *texts in rows)

    def _next(self, state: Literal["done", "undone"]) -> Entry | None:
        row = self._access.row(_NEXT[state])
        return None if row is None else Entry(*row)

    def apply(self, edit: Edit, stamp: Stamp, *, continues: bool = False) -> Changed | None:
        """Make an edit and note it, both or neither; None where it changes nothing.

        One that continues the last edit, being of the same kind and rows, becomes one with it
        (nudging a click ten times is undone at once).
        """
        with self._access.writing() as database:
            with making_sense(self._access.path):
                changes = without_idle(edit.changes(State(database), stamp))
            if not changes:
                return None
            store(database, edit.contents())
            for change in changes:
                change.table.write(database, change.key, change.after)
                if not makes_sense(database, change.table, change.key):
                    raise InputError(
                        f"this cannot be saved: a value of {change.table.name} is out of range",
                        where=edit.words(),
                        remedy="Nothing was changed; enter another value.",
                    )
            leaves_redo = _leaves_redo(database, edit, changes)
            dropped = 0 if leaves_redo else database.execute(_DROP).rowcount
            if not (
                continues and not dropped and self._continued(database, edit.kind, changes, stamp)
            ):
                self._note(database, edit, changes, stamp)
            database.execute("INSERT OR IGNORE INTO annotator VALUES (?, ?)", (stamp.who, stamp.at))
        return Changed(edit.words(), "done", changes, leaves_redo)

    def drop_redo(self) -> None:
        """Let what was undone stay so: something was done since that the project does not store."""
        if self.to_redo() is not None:
            with self._access.writing() as database:
                database.execute(_DROP)

    def undo(self) -> Changed | None:
        """Take back the last edit that is in effect; None where there is none."""
        return self._turn("done")

    def redo(self) -> Changed | None:
        """Make the edit again that was taken back last; None where there is none."""
        return self._turn("undone")

    def let_run_go(self, name: str) -> Changed | None:
        """Take back that a run was kept by itself, as what made it a run is undone.

        None where it was not kept that way. Redo keeps it again. InputError where it was changed
        since.
        """
        row = self._access.row(_KEPT_AS, (as_json((name,)),))
        return None if row is None else self._turned(Entry(*row), undoing=True)

    def rename_kept_run(self, name: str, new: str) -> Changed | None:
        """Let a run have been kept under another name, as its renaming before that is undone.

        None where it was not kept by itself; InputError where the name is taken.
        """
        row = self._access.row(_KEPT_AS, (as_json((name,)),))
        if row is None:
            return None
        entry = Entry(*row)
        (kept,) = self.changes_of(entry.number)
        with self._access.writing() as database:
            if RUN.read(database, (new,)) is not None or RUN.read(database, kept.key) != kept.after:
                raise InputError(
                    f"the run cannot be called {new!r} again",
                    where=name,
                    remedy="The name is in use, or the run was changed since. Rename it in Runs.",
                )
            RUN.write(database, (new,), kept.after)
            RUN.write(database, kept.key, None)
            database.execute(
                "UPDATE edit_change SET changed_key = ? WHERE edit = ?",
                (as_json((new,)), entry.number),
            )
            words = f"{entry.words.removesuffix(name)}{new}"
            database.execute("UPDATE edit SET words = ? WHERE number = ?", (words, entry.number))
        changes = (Change(RUN, kept.key, kept.after, None), Change(RUN, (new,), None, kept.after))
        return Changed(words, "done", changes, leaves_redo=True)

    def _turn(self, state: Literal["done", "undone"]) -> Changed | None:
        with self._access.alone():
            entry = self._next(state)
            return None if entry is None else self._turned(entry, undoing=state == "done")

    def _turned(self, entry: Entry, *, undoing: bool) -> Changed:
        with self._access.writing() as database:
            changes = self.changes_of(entry.number)
            if undoing:
                changes = tuple(change.reversed() for change in reversed(changes))
            for change in changes:
                if change.table.read(database, change.key) != change.before:
                    raise ProjectDamaged(
                        self._access.path,
                        f"the history of {change.table.name} is inconsistent with its rows",
                    )
                change.table.write(database, change.key, change.after)
                if not makes_sense(database, change.table, change.key):
                    raise ProjectDamaged(
                        self._access.path, f"the history has an invalid row of {change.table.name}"
                    )
            database.execute(
                "UPDATE edit SET state = ? WHERE number = ?",
                ("undone" if undoing else "done", entry.number),
            )
        return Changed(entry.words, "undone" if undoing else "redone", changes)

    @staticmethod
    def _note(
        database: sqlite3.Connection, edit: Edit, changes: Iterable[Change], stamp: Stamp
    ) -> None:
        number = database.execute(
            "INSERT INTO edit (kind, words, who, at, state) VALUES (?, ?, ?, ?, 'done')",
            (edit.kind, edit.words(), stamp.who, stamp.at),
        ).lastrowid
        database.executemany(
            "INSERT INTO edit_change VALUES (?, ?, ?, ?, ?, ?)",
            (
                (
                    *(number, place, change.table.name, as_json(change.key)),
                    *(as_json(change.before), as_json(change.after)),
                )
                for place, change in enumerate(changes)
            ),
        )

    def _continued(
        self,
        database: sqlite3.Connection,
        kind: str,
        changes: tuple[Change, ...],
        stamp: Stamp,
    ) -> bool:
        """Let the last edit lead to the rows after these changes; False where it is another."""
        last = self._next("done")
        if last is None or last.kind != kind or last.who != stamp.who:
            return False
        earlier = self.changes_of(last.number)
        if [(c.table, c.key) for c in earlier] != [(c.table, c.key) for c in changes]:
            return False
        database.executemany(
            "UPDATE edit_change SET after = ? WHERE edit = ? AND place = ?",
            ((as_json(change.after), last.number, place) for place, change in enumerate(changes)),
        )
        database.execute("UPDATE edit SET at = ? WHERE number = ?", (stamp.at, last.number))
        return True


def _leaves_redo(database: sqlite3.Connection, edit: Edit, changes: tuple[Change, ...]) -> bool:
    """Whether what was taken back can still be made again after an edit: the keeping of a run."""
    first = changes[0]
    if edit.kind != _SAVE or first.table is not RUN or first.before is not None:
        return False
    again = database.execute(_AGAIN, (RUN.name, as_json(first.key))).fetchone()
    return again is None  # else redo would find another run of that name
