"""Large data that never changes, kept by its hash: runs and trajectories."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterable
from pathlib import Path

from stereotrack_core.project.failures import ProjectDamaged


def hash_of(data: bytes) -> str:
    """Name under which content is kept: BLAKE2b, 32 hexadecimal digits."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def store(database: sqlite3.Connection, contents: Iterable[bytes]) -> None:
    """Keep contents, each once; they stay when an edit is undone, so that it can be redone."""
    for data in contents:
        database.execute("INSERT OR IGNORE INTO content VALUES (?, ?)", (hash_of(data), data))


def fetch(database: sqlite3.Connection, path: Path, name: str) -> bytes:
    """Content of that hash, verified.

    Raises
    ------
    ProjectDamaged
        Where it is missing or is not what was stored.
    """
    row = database.execute("SELECT bytes FROM content WHERE hash = ?", (name,)).fetchone()
    if row is None or hash_of(row[0]) != name:
        raise ProjectDamaged(path, f"stored data {name} are missing or changed")
    data: bytes = row[0]
    return data
