"""Open a project file: who may, on which drive, in which format, and what to tell about it."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.project.connection import Connection, connect, connect_for_reading
from stereotrack_core.project.database import (
    beside,
    check_header,
    copy_files,
    is_in_place,
    lacks_log,
    transaction,
    version_of,
)
from stereotrack_core.project.failures import ProjectInUse, code_of, making_sense
from stereotrack_core.project.filesystem import Mount, network_type
from stereotrack_core.project.lock import ProjectLock, is_held, lock_path
from stereotrack_core.project.migrations import migrate, upgrade
from stereotrack_core.project.owner import Owner, in_use, myself, read_owner, write_owner
from stereotrack_core.project.schema import FORMAT
from stereotrack_core.project.validity import check_rows
from stereotrack_core.project.wholeness import check_whole
from stereotrack_core.recording.finding import Finding


@dataclass(frozen=True, eq=False)
class Opened:
    """An open project file.

    Attributes
    ----------
    path : Path
    database : sqlite3.Connection
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
    lost, locked = lacks_log(path), lock_path(path).exists()
    with ExitStack() as stack:
        try:
            lock = ProjectLock(path)
        except BlockingIOError:
            raise in_use(path) from None
        stack.callback(lock.release)
        network = network_type(path, mounts)
        with making_sense(path):
            _try_what_was_left(path)
            database = connect(path)
            stack.callback(database.close)
            check_rows(database, path, ("owner",))
            left = read_owner(database)
            if left is not None:
                gone = take_over or (lock.holds and (network is None or left.host == myself().host))
                _check_gone(path, left, gone=gone)
            if left is not None or lost:
                check_whole(database, path)
            copy = migrate(database, path)
            check_rows(database, path)
            status = path.stat()
            identity = None if network else (status.st_dev, status.st_ino)
            stack.callback(_give_back, database, path, identity)
            write_owner(database, myself())
        notes = (*_notes_of_end(path, left, lost, locked), *_note_of_migration(path, copy))
        return Opened(path, database, False, notes, stack.pop_all(), identity)
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
    lost, locked, held = lacks_log(path), lock_path(path).exists(), is_held(path)
    with ExitStack() as stack, making_sense(path):
        notes: tuple[Finding, ...] = ()
        snapshot = lost
        try:
            if not snapshot:
                database = connect_for_reading(path)
                if snapshot := version_of(database) < FORMAT:
                    database.close()
        except sqlite3.OperationalError as error:
            if code_of(error) not in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY):
                raise
            snapshot = True
            if error.sqlite_errorcode != sqlite3.SQLITE_READONLY_ROLLBACK:
                notes = (_note_of_snapshot(path),)
        if snapshot:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            database = _upgraded_copy(path, Path(folder))
        stack.callback(database.close)
        check_rows(database, path)
        left = None if held else read_owner(database)
        if left is not None or lost:
            check_whole(database, path)
        notes = (*notes, *_notes_of_end(path, left, lost, locked))
        return Opened(path, database, True, notes, stack.pop_all())
    raise AssertionError  # the stack swallows no exception


def _give_back(database: sqlite3.Connection, path: Path, identity: tuple[int, int] | None) -> None:
    """Say that nobody has it, and leave a single file.

    Where that fails, because somebody is reading or the drive is full, nothing is lost: the next
    program takes it for a crash. A file that was moved away is left alone: the journal would lie
    where it was, beside whatever has its name now.
    """
    if not is_in_place(path, identity):
        return
    with suppress(sqlite3.Error):
        write_owner(database, None)
        database.execute("PRAGMA journal_mode = DELETE")


def _copy(path: Path, folder: Path) -> Path:
    try:
        copy = copy_files(path, folder)
    except OSError as error:
        raise InputError(
            f"it cannot be copied to be read ({error.strerror})",
            where=str(path),
            remedy="Give yourself the right to read it, and look whether the drive of temporary"
            " files has room.",
        ) from error
    copy.chmod(0o600)
    return copy


def _upgraded_copy(path: Path, folder: Path) -> Connection:
    copy = _copy(path, folder)
    with closing(connect(copy)) as database:
        if version_of(database) < FORMAT:
            with transaction(database):
                upgrade(database)
    return connect_for_reading(copy)


def _try_what_was_left(path: Path) -> None:
    """See what taking back an unfinished edit leads to on a copy, before it happens to the file.

    The journal that says how may be of another file: one that was here before a backup was put in
    its place, or moved away and back again.
    """
    if not beside(path):
        return
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(connect(_copy(path, Path(folder)))) as tried,
    ):
        check_whole(tried, path)


def _check_gone(path: Path, left: Owner, *, gone: bool) -> None:
    """See that the owner is gone for certain."""
    if gone:
        return
    complaint = in_use(path, left)
    raise ProjectInUse(
        complaint.what,
        where=complaint.where,
        remedy="Close it there. If that program is gone for certain, take the project over.",
    )


def _notes_of_end(path: Path, left: Owner | None, lost: bool, locked: bool) -> tuple[Finding, ...]:
    """What to tell about a file that was not closed, or copied while it was open.

    Parameters
    ----------
    path : Path
    left : Owner or None
        Who had it open.
    lost : bool
        Whether the log of an older program is not beside it.
    locked : bool
        Whether the lock of that program is still beside it, as a crash leaves it.
    """
    if lost:
        return (
            Finding(
                "warning",
                str(path),
                "it was copied or moved without its log while an older program had it open, so"
                " the last edits may be missing",
                f"Compare it with the original, or copy that again together with {path.name}-wal.",
            ),
        )
    if left is None:
        return ()
    who = f"process {left.process} on {left.host}"
    what = f"{who} did not close it; every edit is there"
    remedy = "Nothing has to be done; undo works as before."
    if not locked:
        what = f"it was copied or moved while {who} had it open; every edit until then is there"
        remedy = "Nothing has to be done; edits made elsewhere later are not in this file."
    return (Finding("note", str(path), what, remedy),)


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
