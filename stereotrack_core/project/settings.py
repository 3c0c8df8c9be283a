"""How the person looks at the project: kept, but no part of the history."""

from __future__ import annotations

import json
from typing import Any

from stereotrack_core.project.access import Access


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no number")


class ViewSettings:
    """Values by name, JSON-serialisable: the frame shown last, switches, filters."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def get(self, name: str, default: Any = None) -> Any:
        """Value of that name, or `default`.

        The default is returned as well where the value is of another kind than that, or nothing
        can be made of it: nothing is lost with how somebody looked at the project.
        """
        row = self._access.row("SELECT value FROM view_setting WHERE name = ?", (name,))
        try:
            value = None if row is None else json.loads(row[0], parse_constant=_refuse)
        except (ValueError, RecursionError):
            value = None
        kinds = (int, float) if isinstance(default, float) else type(default)
        return value if default is None or isinstance(value, kinds) else default

    def set(self, name: str, value: Any) -> None:
        """Keep a value; None forgets it."""
        text = json.dumps(value)
        with self._access.writing() as database:
            if value is None:
                database.execute("DELETE FROM view_setting WHERE name = ?", (name,))
            else:
                database.execute("INSERT OR REPLACE INTO view_setting VALUES (?, ?)", (name, text))
