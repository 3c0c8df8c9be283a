"""How the person looks at the project: kept, but no part of the history."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path
from threading import RLock
from typing import Any

from stereotrack_core.project.database import transaction
from stereotrack_core.project.failures import speaking


class ViewSettings:
    """Values by name, JSON-serialisable: the frame shown last, switches, filters."""

    def __init__(self, database: sqlite3.Connection, lock: RLock, path: Path) -> None:
        self._database = database
        self._lock = lock
        self._path = path

    def get(self, name: str, default: Any = None) -> Any:
        """Value of that name, or `default`."""
        with self._lock:
            row = self._database.execute(
                "SELECT value FROM view_setting WHERE name = ?", (name,)
            ).fetchone()
        return default if row is None else json.loads(row[0])

    def set(self, name: str, value: Any) -> None:
        """Keep a value; None forgets it."""
        text = json.dumps(value)
        with self._lock, speaking(self._path), transaction(self._database):
            if value is None:
                self._database.execute("DELETE FROM view_setting WHERE name = ?", (name,))
            else:
                self._database.execute(
                    "INSERT OR REPLACE INTO view_setting VALUES (?, ?)", (name, text)
                )
