"""How the person looks at the project: kept, but no part of the history."""

from __future__ import annotations

import json
from typing import Any

from stereotrack_core.project.access import Access


class ViewSettings:
    """Values by name, JSON-serialisable: the frame shown last, switches, filters."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def get(self, name: str, default: Any = None) -> Any:
        """Value of that name, or `default`."""
        row = self._access.row("SELECT value FROM view_setting WHERE name = ?", (name,))
        with self._access.making_sense():
            return default if row is None else json.loads(row[0])

    def set(self, name: str, value: Any) -> None:
        """Keep a value; None forgets it."""
        text = json.dumps(value)
        with self._access.writing() as database:
            if value is None:
                database.execute("DELETE FROM view_setting WHERE name = ?", (name,))
            else:
                database.execute("INSERT OR REPLACE INTO view_setting VALUES (?, ?)", (name, text))
