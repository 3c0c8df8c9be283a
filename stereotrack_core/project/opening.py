"""Open a project file: who may, on which drive, in which format, and what to tell about it."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.project.database import (
    check_header,
    check_version,
    connect,
    connect_for_reading,
    copy_files,
    transaction,
    version_of,
)
from stereotrack_core.project.failures import ProjectDamaged, ProjectInUse, code_of, speaking
from stereotrack_core.project.filesystem import Mount, network_type
from stereotrack_core.project.lock import ProjectLock
from stereotrack_core.project.migrations import migrate, upgrade
from stereotrack_core.project.owner import Owner, in_use, myself, read_owner, write_owner
from stereotrack_core.project.schema import FORMAT
from stereotrack_core.recording.finding import Finding


@dataclass(frozen=True, eq=False)
class Opened:
    """An open project file.

    Attributes
    ----------
    path : Path
    database : sqlite3.Connection
    journal : str
        ``wal``, or ``delete`` where the write-ahead log is not safe or not to be had.
    read_only : bool
    notes : tuple of Finding
        What the person should know.
    resources : ExitStack
        Closes everything.
    identity : (int, int) or None
        Device and number of the file, by which it is known; None on network drives, which do not
        keep numbers.
    """

    path: Path
    database: sqlite3.Connection
    journal: str
    read_only: bool
    notes: tuple[Finding, ...]
    resources: ExitStack
    identity: tuple[int, int] | None = None


def open_for_writing(
    path: Path, *, take_over: bool = False, mounts: Sequence[Mount] | None = None
) -> Opened:
    """Open the file as its only writer and bring it to the present format.

    Parameters
    ----------
    path : Path
    take_over : bool
        Take a project on a network drive that another machine has not given back.
    mounts : sequence of (str, str), optional
        See :func:`network_type`.

    Raises
    ------
    InputError
        Where another program has it, it is no project, or a newer program wrote it.
    ProjectDamaged
        Where it contradicts itself.
    """
    check_header(path)
    with ExitStack() as stack:
        try:
            lock = ProjectLock(path)
        except BlockingIOError:
            raise in_use(path) from None
        stack.callback(lock.release)
        network = network_type(path, mounts)
        with speaking(path):
            database, journal = connect(path, safe=network is not None)
            stack.callback(database.close)
            check_version(path, version_of(database))
            left = read_owner(database)
            if left is not None:
                gone = take_over or (lock.holds and (network is None or left.host == myself().host))
                _check_left(path, database, left, gone=gone)
            copy = migrate(database, path)
            if copy is not None:
                database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            stack.callback(_give_back, database)
            write_owner(database, myself())
        notes = (
            *_note_of_journal(path, journal, network),
            *_note_of_crash(path, left),
            *_note_of_migration(path, copy),
        )
        status = path.stat()
        identity = None if network else (status.st_dev, status.st_ino)
        return Opened(path, database, journal, False, notes, stack.pop_all(), identity)
    raise AssertionError  # the stack swallows no exception


def open_for_reading(path: Path) -> Opened:
    """Open the file without a way to write to it, also while another program writes.

    A project in a read-only folder, or of an older format, is read from a temporary copy; the
    file itself stays as it is.

    Raises
    ------
    InputError
        Where it is no project, cannot be read, or a newer program wrote it.
    ProjectDamaged
        Where it contradicts itself.
    """
    check_header(path)
    with ExitStack() as stack, speaking(path):
        notes: tuple[Finding, ...] = ()
        try:
            database = connect_for_reading(path)
            old = version_of(database) < FORMAT
            if old:
                database.close()
        except sqlite3.OperationalError as error:
            if code_of(error) not in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY):
                raise
            old = True
            notes = (_note_of_snapshot(path),)
        if old:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            database = _upgraded_copy(path, Path(folder))
        stack.callback(database.close)
        check_version(path, version_of(database))
        return Opened(path, database, "read only", True, notes, stack.pop_all())
    raise AssertionError  # the stack swallows no exception


def _give_back(database: sqlite3.Connection) -> None:
    """Say that nobody has it, and leave a single file that a read-only folder can hold.

    Where that fails, because somebody is reading or the drive is full, nothing is lost: the log
    stays beside the file, and the next program takes it for a crash.
    """
    with suppress(sqlite3.Error):
        write_owner(database, None)
        database.execute("PRAGMA journal_mode = DELETE")


def _upgraded_copy(path: Path, folder: Path) -> sqlite3.Connection:
    try:
        copy = copy_files(path, folder)
    except OSError as error:
        raise InputError(
            f"it cannot be read ({error.strerror})",
            where=str(path),
            remedy="Give yourself the right to read it.",
        ) from error
    copy.chmod(0o600)
    with closing(connect(copy, safe=True)[0]) as database:
        if version_of(database) < FORMAT:
            with transaction(database):
                upgrade(database)
    return connect_for_reading(copy)


def _check_left(path: Path, database: sqlite3.Connection, left: Owner, *, gone: bool) -> None:
    """See that the owner is gone for certain, and that all is well after its crash."""
    if not gone:
        complaint = in_use(path, left)
        raise ProjectInUse(
            complaint.what,
            where=complaint.where,
            remedy="Close it there. If that program is gone for certain, take the project over.",
        )
    verdict = database.execute("PRAGMA quick_check(1)").fetchone()[0]
    if verdict != "ok":
        raise ProjectDamaged(path, str(verdict))


def _note_of_journal(path: Path, journal: str, network: str | None) -> tuple[Finding, ...]:
    if journal == "wal":
        return ()
    reason = (
        f"it is on a network drive ({network})" if network else "its drive has no shared memory"
    )
    return (
        Finding(
            "note",
            str(path),
            f"{reason}, so edits are saved in a slower, safe way",
            "Nothing has to be done; on a drive of this machine it is faster.",
        ),
    )


def _note_of_crash(path: Path, left: Owner | None) -> tuple[Finding, ...]:
    if left is None:
        return ()
    return (
        Finding(
            "note",
            str(path),
            f"process {left.process} on {left.host} did not close it; every edit is there",
            "Nothing has to be done; undo works as before.",
        ),
    )


def _note_of_migration(path: Path, copy: Path | None) -> tuple[Finding, ...]:
    if copy is None:
        return ()
    return (
        Finding(
            "note",
            str(path),
            f"it was of an older format and was brought up to date; a copy is {copy.name!r}",
            "Keep the copy as long as you use an older program.",
        ),
    )


def _note_of_snapshot(path: Path) -> Finding:
    return Finding(
        "note",
        str(path),
        "its folder is read-only, so it is shown as it was when it was opened",
        "Copy it to a folder of yours to edit it.",
    )
