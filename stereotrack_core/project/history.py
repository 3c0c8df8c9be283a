"""Every edit that was ever made, from which undo and redo work without limit.

Runs are not noted: they come when they are complete, and are restored after a removal.
"""

import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

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

How: TypeAlias = Literal["done", "undone", "dropped"]  # in effect, taken back, or then dropped


@dataclass(frozen=True)
class Entry:
    """An edit in the history."""

    number: int
    kind: str
    words: str
    who: str
    at: str
    state: How


@dataclass(frozen=True)
class Changed:
    """An edit just made, undone or redone: its words, and its rows in their order."""

    words: str
    how: Literal["done", "undone", "redone"]
    changes: tuple[Change, ...]

    @property
    def tables(self) -> frozenset[str]:
        """Names of the tables that have changed."""
        return frozenset(change.table.name for change in self.changes)

    def frames(self, table: str = "click") -> frozenset[int]:
        """Frames whose rows of a table have changed."""
        own = (c for c in self.changes if c.table.name == table and "frame" in c.table.key)
        return frozenset(int(c.key[c.table.key.index("frame")] or 0) for c in own)


_EDITS = "SELECT number, kind, words, who, at, state FROM edit"
_NEXT = {
    "undone": f"{_EDITS} WHERE state = 'undone' ORDER BY number LIMIT 1",
    "done": f"{_EDITS} WHERE state = 'done' ORDER BY number DESC LIMIT 1",
}
_DROP = "UPDATE edit SET state = 'dropped' WHERE state = 'undone'"


class History:
    """The edits of a project; each one that is made, undone or redone is one transaction."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def to_undo(self) -> Entry | None:
        """The edit that undo would take back."""
        return self._next("done")

    def to_redo(self) -> Entry | None:
        """The edit that redo would make again."""
        return self._next("undone")

    def entries(self, limit: int = 200) -> tuple[Entry, ...]:
        """The newest edits first."""
        rows = self._access.rows(f"{_EDITS} ORDER BY number DESC LIMIT ?", (limit,))
        return tuple(Entry(*row) for row in rows)

    def changes_of(self, number: int) -> tuple[Change, ...]:
        """Changes of an edit."""
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

        One that continues the last edit, of the same kind and rows, becomes one with it.
        """
        with self._access.writing() as database:
            with making_sense(self._access.path):
                changes = without_idle(edit.changes(State(database), stamp))
            if not changes:
                return None
            store(database, edit.contents)
            for change in changes:
                change.table.write(database, change.key, change.after)
            if any(change.table is not RUN for change in changes):
                dropped = database.execute(_DROP).rowcount
                joined = continues and not dropped
                if not (joined and self._continued(database, edit.kind, changes, stamp)):
                    self._note(database, edit, changes, stamp)
            database.execute("INSERT OR IGNORE INTO annotator VALUES (?, ?)", (stamp.who, stamp.at))
        return Changed(edit.words, "done", changes)

    def undo(self) -> Changed | None:
        """Take back the last edit that is in effect; None where there is none."""
        return self._turn("done")

    def redo(self) -> Changed | None:
        """Make the edit again that was taken back last; None where there is none."""
        return self._turn("undone")

    def _turn(self, state: Literal["done", "undone"]) -> Changed | None:
        undoing = state == "done"
        with self._access.writing() as database:
            if (entry := self._next(state)) is None:
                return None
            changes = self.changes_of(entry.number)
            if undoing:
                changes = tuple(
                    Change(c.table, c.key, c.after, c.before) for c in reversed(changes)
                )
            for change in changes:
                if change.table.read(database, change.key) != change.before:
                    raise ProjectDamaged(
                        self._access.path,
                        f"the history of {change.table.name} is inconsistent with its rows",
                    )
                change.table.write(database, change.key, change.after)
            state = "undone" if undoing else "done"
            database.execute("UPDATE edit SET state = ? WHERE number = ?", (state, entry.number))
        return Changed(entry.words, "undone" if undoing else "redone", changes)

    @staticmethod
    def _note(
        database: sqlite3.Connection, edit: Edit, changes: Iterable[Change], stamp: Stamp
    ) -> None:
        number = database.execute(
            "INSERT INTO edit (kind, words, who, at, state) VALUES (?, ?, ?, ?, 'done')",
            (edit.kind, edit.words, stamp.who, stamp.at),
        ).lastrowid
        told = ((c.table.name, *map(as_json, (c.key, c.before, c.after))) for c in changes)
        rows = ((number, place, *one) for place, one in enumerate(told))
        database.executemany("INSERT INTO edit_change VALUES (?, ?, ?, ?, ?, ?)", rows)

    def _continued(
        self, database: sqlite3.Connection, kind: str, changes: tuple[Change, ...], stamp: Stamp
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
