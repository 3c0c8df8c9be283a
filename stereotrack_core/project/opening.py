"""Open a project file: who may, on which drive, in which format, and what to tell about it."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.project.connection import connect, connect_for_reading
from stereotrack_core.project.database import (
    beside,
    check_header,
    code_of,
    copy_files,
    is_in_place,
    making_sense,
)
from stereotrack_core.project.owner import (
    Mount,
    Owner,
    ProjectLock,
    in_use,
    is_held,
    lock_path,
    myself,
    network_type,
    read_owner,
    write_owner,
)
from stereotrack_core.project.validity import check_rows, check_whole

_UNCERTAIN = (
    "Close it there. If that program is certainly no longer running, force unlock the project."
)


@dataclass(frozen=True, eq=False)
class Opened:
    """An open project file.

    Attributes
    ----------
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
    """Open the file as its only writer.

    With `take_over`, also a project on a network drive that another machine has not given back;
    for `mounts` see :func:`network_type`.

    Raises
    ------
    InputError
        Where another program has it, it is no project, or one of another version.
    ProjectDamaged
        Where it contradicts itself.
    """
    check_header(path)
    locked = lock_path(path).exists()
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
                ours = lock.holds and (network is None or left.host == myself().host)
                if not (take_over or ours):  # else it is gone for certain
                    raise in_use(path, left, _UNCERTAIN)
                check_whole(database, path)
            check_rows(database, path)
            status = path.stat()
            identity = None if network else (status.st_dev, status.st_ino)
            stack.callback(_give_back, database, path, identity)
            write_owner(database, myself())
        notes = _notes_of_end(path, left, locked)
        return Opened(path, database, False, notes, stack.pop_all(), identity)
    raise AssertionError  # the stack swallows no exception


def open_for_reading(path: Path) -> Opened:
    """Open the file without a way to write to it, also while another program writes.

    Where an unfinished edit would have to be taken back first, a temporary copy is read; the file
    itself stays as it is.

    Raises
    ------
    InputError
        Where it is no project, cannot be read, or is one of another version.
    ProjectDamaged
        Where it contradicts itself.
    """
    check_header(path)
    locked, held = lock_path(path).exists(), is_held(path)
    with ExitStack() as stack, making_sense(path):
        try:
            database = connect_for_reading(path)
        except sqlite3.OperationalError as error:
            if code_of(error) not in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY):
                raise
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            copy = _copy(path, Path(folder))
            connect(copy).close()  # takes the edit back
            database = connect_for_reading(copy)
        stack.callback(database.close)
        check_rows(database, path)
        left = None if held else read_owner(database)
        if left is not None:
            check_whole(database, path)
        return Opened(path, database, True, _notes_of_end(path, left, locked), stack.pop_all())
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
            f"it cannot be copied for reading ({error.strerror})",
            where=str(path),
            remedy="Check that you may read it, and that the drive of temporary files has free "
            "space.",
        ) from error
    copy.chmod(0o600)
    return copy


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


def _notes_of_end(path: Path, left: Owner | None, locked: bool) -> tuple[Finding, ...]:
    """What to tell about a file that was not closed, or copied while it was open."""
    if left is None:
        return ()
    who = f"process {left.process} on {left.host}"
    what = f"{who} did not close it; all edits are saved"
    remedy = "No action is needed. Undo works as before."
    if not locked:
        what = f"it was copied or moved while {who} had it open; all edits until then are saved"
        remedy = "No action is needed. Later edits made elsewhere are not in this file."
    return (Finding("note", str(path), what, remedy),)
