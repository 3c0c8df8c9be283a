"""Bring a project of an older format up to date, after a copy of it was made."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.project.database import check_nothing_beside, transaction, version_of
from stereotrack_core.project.failures import NONSENSE, ProjectDamaged
from stereotrack_core.project.rows import as_json, from_json
from stereotrack_core.project.schema import (
    CLICKS,
    CLICKS_OF_A_LANDMARK,
    FLAGGED_CLICKS,
    FORMAT,
    PREDICTIONS,
    PREDICTIONS_OF_A_SOURCE,
    REPEATS,
)
from stereotrack_core.project.validity import check_rows


def migrate(database: sqlite3.Connection, path: Path) -> Path | None:
    """Bring the project to the present format; None where it had that already.

    Returns
    -------
    Path or None
        The copy of the project as it was before.

    Raises
    ------
    InputError
        Where no copy can be made or a step fails; the project is unchanged then.
    """
    version = version_of(database)
    if version == FORMAT:
        return None
    copy = back_up(database, path, f"format-{version}")
    try:
        with transaction(database):
            upgrade(database)
            check_rows(database, path)
    except (*NONSENSE, sqlite3.Error, ProjectDamaged) as error:
        raise InputError(
            f"it could not be brought up to date from format {version} ({error})",
            where=str(path),
            remedy=f"Nothing was changed; a copy for repair is {copy.name!r}.",
        ) from error
    return copy


def upgrade(database: sqlite3.Connection) -> None:
    """Run the steps from the database's format to the present one, within a transaction."""
    while (version := version_of(database)) < FORMAT:
        MIGRATIONS[version](database)
        database.execute(f"PRAGMA user_version = {version + 1}")


def back_up(database: sqlite3.Connection, path: Path, word: str) -> Path:
    """Copy the project beside itself as ``name.word.stereotrack`` and read the copy back.

    Raises
    ------
    InputError
        Where the copy cannot be written or is not whole.
    """
    copy = path.with_name(f"{path.stem}.{word}{path.suffix}")
    number = 2
    while copy.exists():
        copy = path.with_name(f"{path.stem}.{word}-{number}{path.suffix}")
        number += 1
    copy_whole(database, copy)
    return copy


def copy_whole(database: sqlite3.Connection, path: Path) -> None:
    """Copy a project to another file and read the copy back; all of it is there, or nothing.

    Raises
    ------
    InputError
        Where the copy cannot be written or is not whole.
    """
    check_nothing_beside(path)
    with replacing(path) as temporary:
        target = sqlite3.connect(temporary, isolation_level=None)
        try:
            database.backup(target)
            target.execute("PRAGMA journal_mode = DELETE")
            target.execute("DELETE FROM owner")
            whole = target.execute("PRAGMA quick_check(1)").fetchone()[0] == "ok"
        finally:
            target.close()
        if not whole:
            raise InputError(
                "the copy of the project is not whole",
                where=str(path),
                remedy="Copy it to another drive; the project itself was not changed.",
            )


def _second_readings_and_origins(database: sqlite3.Connection) -> None:
    """From 1 to 2: clicks know how they came about, second readings and predictions are kept.

    The history is brought along, so that edits of that time can be undone still. A later format
    that changes one of these tables moves the statement as it is now into this step.
    """
    database.execute("ALTER TABLE click RENAME TO click_before")
    database.execute(CLICKS)
    database.execute(
        "INSERT INTO click SELECT frame, camera, landmark, x, y, visibility, flag, NULL, 'hand',"
        " who, at, 0 FROM click_before"
    )
    database.execute("DROP TABLE click_before")
    database.execute(CLICKS_OF_A_LANDMARK)
    database.execute(FLAGGED_CLICKS)
    for statement in (REPEATS, PREDICTIONS, PREDICTIONS_OF_A_SOURCE):
        database.execute(statement)
    changes = database.execute(
        "SELECT edit, place, before, after FROM edit_change WHERE changed_table = 'click'"
    ).fetchall()
    database.executemany(
        "UPDATE edit_change SET before = ?, after = ? WHERE edit = ? AND place = ?",
        [(_with_origin(before), _with_origin(after), *place) for *place, before, after in changes],
    )


def _with_origin(values: str | None) -> str | None:
    row = from_json(values)
    return None if row is None else as_json((*row[:4], None, "hand", *row[4:], 0))


MIGRATIONS: dict[int, Callable[[sqlite3.Connection], None]] = {1: _second_readings_and_origins}
"""By the format that they start from."""
