"""Who has a project open: told to the second program, and how a crash is noticed."""

from __future__ import annotations

import getpass
import os
import socket
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.project.connection import connect_for_reading
from stereotrack_core.project.database import transaction
from stereotrack_core.project.failures import ProjectInUse, making_sense
from stereotrack_core.project.validity import check_rows


@dataclass(frozen=True)
class Owner:
    """A program that has the project open for writing."""

    host: str
    process: int
    who: str
    at: str


def now() -> str:
    """Present time, ISO 8601, UTC."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def user() -> str:
    """Name of the person at this machine."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # no such user is known to the system
        return "somebody"


def myself() -> Owner:
    """The program that asks."""
    return Owner(socket.gethostname(), os.getpid(), user(), now())


def read_owner(database: sqlite3.Connection) -> Owner | None:
    """Who has it, or had it when it crashed."""
    row = database.execute("SELECT host, process, who, at FROM owner").fetchone()
    return None if row is None else Owner(*row)


def write_owner(database: sqlite3.Connection, owner: Owner | None) -> None:
    """Note who has it; None: nobody."""
    with transaction(database):
        database.execute("DELETE FROM owner WHERE only = 1")
        if owner is not None:
            database.execute(
                "INSERT INTO owner VALUES (1, ?, ?, ?, ?)",
                (owner.host, owner.process, owner.who, owner.at),
            )


def in_use(path: Path, owner: Owner | None = None) -> ProjectInUse:
    """The complaint of the second program, which names the first one."""
    if owner is None:
        owner = _owner_of_file(path)
    if owner is None:
        who = "another program has it open"
    else:
        who = (
            f"it is open already: process {owner.process} on {owner.host},"
            f" user {owner.who}, since {owner.at.replace('T', ' ')[:16]} UTC"
        )
    return ProjectInUse(who, where=str(path), remedy="Close it there, or open it for reading only.")


def _owner_of_file(path: Path) -> Owner | None:
    try:
        with closing(connect_for_reading(path)) as database, making_sense(path):
            check_rows(database, path, ("owner",))
            return read_owner(database)
    except (InputError, sqlite3.Error):
        return None
