"""Open a project file: who may, on which drive, in which format, and what to tell about it."""

import ctypes
import os
import re
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.locks import FileLock, Owner, is_held, lock_owner, lock_path
from stereotrack_core.project import connection
from stereotrack_core.project.database import (
    ProjectInUse,
    bring_up_to_date,
    check_header,
    check_whole,
    is_in_place,
    lend_missing,
    making_sense,
    transaction,
)


def owner_of(database: sqlite3.Connection) -> Owner | None:
    """Program that has the project open for writing, or had it when it crashed."""
    row = database.execute("SELECT host, process, who, at FROM owner").fetchone()
    return None if row is None else Owner(*row)


def write_owner(database: sqlite3.Connection, owner: Owner | None) -> None:
    """Note who has it; None: nobody."""
    with transaction(database):
        database.execute("DELETE FROM owner WHERE only = 1")
        if owner is not None:
            database.execute("INSERT INTO owner VALUES (1, ?, ?, ?, ?)", astuple(owner))


def _in_use(path: Path, owner: Owner | None, remedy: str) -> ProjectInUse:
    """The complaint of the second program, which names the first one."""
    what = f"it is already open: {owner or 'another program'}"
    return ProjectInUse(what, where=str(path), remedy=remedy)


_MOUNTS = Path("/proc/self/mounts")
_DRIVE_REMOTE = 4  # what Windows' GetDriveTypeW says of a drive of the network
_NETWORK_TYPES = frozenset(
    {
        *("9p", "afp", "afpfs", "afs", "beegfs", "ceph", "cifs", "coda", "davfs", "davfs2"),
        *("drvfs", "fuse.davfs2", "fuse.gcsfuse", "fuse.glusterfs", "fuse.rclone"),
        *("fuse.s3fs", "fuse.sshfs", "gfs2", "glusterfs", "gpfs", "lustre", "ncpfs", "nfs"),
        *("nfs4", "ocfs2", "orangefs", "smb3", "smbfs", "vboxsf", "virtiofs", "webdav"),
    }
)
"""File systems whose shared memory is not shared between the machines that write to them."""

Mount = tuple[str, str]  # where a file system is mounted, and its type


def network_type(path: Path) -> str | None:
    """Type of the network file system of a path; None for the machine's own."""
    place = os.path.realpath(path)
    if sys.platform == "win32":
        return _windows_type(place)
    found = ("", "")
    for mounted, kind in machine_mounts():
        inside = place == mounted or place.startswith(mounted.rstrip("/") + "/")
        if inside and len(mounted) >= len(found[0]):
            found = (mounted, kind)
    return found[1] if found[1] in _NETWORK_TYPES else None


def machine_mounts() -> tuple[Mount, ...]:
    """Mounts of this machine; none if it does not tell."""
    try:
        if sys.platform == "darwin":
            listed = subprocess.run(
                ["/sbin/mount"], capture_output=True, text=True, check=False, timeout=5
            )
            return mounts_of_macos(listed.stdout)
        return mounts_of_linux(_MOUNTS.read_text(encoding="utf-8", errors="surrogateescape"))
    except (OSError, subprocess.TimeoutExpired):
        return ()


def mounts_of_linux(text: str) -> tuple[Mount, ...]:
    """Mounts in the layout of ``/proc/mounts``, where spaces in paths are written as octal."""
    unescaped = partial(re.sub, r"\\(040|011|012|134)", lambda code: chr(int(code[1], 8)))
    rows = (line.split(" ") for line in text.splitlines())
    return tuple((unescaped(row[1]), row[2]) for row in rows if len(row) >= 3)


def mounts_of_macos(text: str) -> tuple[Mount, ...]:
    """Mounts as ``mount`` prints them: ``device on /place (type, options)``."""
    mounts = []
    for line in text.splitlines():
        place, _, options = line.partition(" on ")[2].rpartition(" (")
        if place:
            mounts.append((place, options.split(",")[0].rstrip(")")))
    return tuple(mounts)


def _windows_type(place: str) -> str | None:
    if place.startswith("\\\\"):
        return "network share"
    library = getattr(ctypes, "windll", None)
    drive = os.path.splitdrive(place)[0] + "\\"
    if library is not None and library.kernel32.GetDriveTypeW(drive) == _DRIVE_REMOTE:
        return "network drive"
    return None


_UNCERTAIN = (
    "Close it there. If that program is certainly no longer running, force unlock the project."
)


@dataclass(frozen=True, eq=False)
class Opened:
    """An open project file."""

    access: connection.Access
    read_only: bool
    notes: tuple[Finding, ...]  # what the person should know
    resources: ExitStack  # closes everything


def open_for_writing(path: Path, *, take_over: bool = False) -> Opened:
    """Open the file as its only writer. Raises InputError, ProjectDamaged.

    With `take_over`, also a project on a network drive that another machine has not given back.
    """
    check_header(path)
    locked = lock_path(path).exists()
    with ExitStack() as stack:
        try:
            lock = FileLock(path)
        except BlockingIOError:
            raise _in_use(path, lock_owner(path), "Close it there to edit it here.") from None
        except OSError as error:
            what = f"cannot write beside the project ({error.strerror})"
            remedy = "Open the project read-only, or copy it elsewhere."
            raise InputError(what, path.parent, remedy) from error
        stack.callback(lock.release)
        network = network_type(path)
        with making_sense(path):
            database = stack.enter_context(closing(connection.connect(path)))
            left = owner_of(database)
            if left is not None:
                ours = lock.holds and (network is None or left.host == Owner.myself().host)
                if not (take_over or ours):  # else it is gone for certain
                    raise _in_use(path, left, _UNCERTAIN)
            check_whole(database, path)
            status = path.stat()
            identity = None if network else (status.st_dev, status.st_ino)
            stack.callback(_give_back, database, path, identity)
            earlier = bring_up_to_date(database, path)
            write_owner(database, Owner.myself())  # into the file: a copy without its log says so
            connection.set_log(database, log=network is None)
            reader = log = None
            if network is None:
                reader = stack.enter_context(closing(connection.connect_for_reading(path)))
                log = stack.enter_context(closing(connection.LogWriter(path)))
        notes = tuple(_notes(path, left, locked, earlier))
        access = connection.Access(database, path, identity, reader, log)
        return Opened(access, False, notes, stack.pop_all())
    raise AssertionError  # the stack swallows no exception


def open_for_reading(path: Path) -> Opened:
    """Open the file to be read, also while another writes. Raises InputError, ProjectDamaged."""
    locked, held = lock_path(path).exists(), is_held(path, unsure=True)
    with ExitStack() as stack, making_sense(path):
        database = stack.enter_context(closing(connection.connect_for_reading(path)))
        left = None if held else owner_of(database)
        lend_missing(database)
        check_whole(database, path)
        notes = tuple(_notes(path, left, locked))
        return Opened(connection.Access(database, path), True, notes, stack.pop_all())
    raise AssertionError  # the stack swallows no exception


def _give_back(database: sqlite3.Connection, path: Path, identity: tuple[int, int] | None) -> None:
    """Say that nobody has it, and leave a single file.

    Where that fails nothing is lost: the next program takes it for a crash. A file that was moved
    away is left alone, as its journal would lie where it was.
    """
    if not is_in_place(path, identity):
        return
    with suppress(sqlite3.Error):
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
        database.execute("PRAGMA journal_mode = DELETE")
        write_owner(database, None)


def _notes(
    path: Path, left: Owner | None, locked: bool, earlier: Path | None = None
) -> Iterator[Finding]:
    """Notes on a file that was not closed, copied while open, or brought up to date."""
    if left is not None:
        who = f"process {left.process} on {left.host}"
        what = f"{who} did not close it; all edits are saved"
        remedy = "No action is needed. Undo works as before."
        if not locked:
            what = f"it was copied or moved while {who} had it open"
            remedy = f"Its newest edits may be missing: they were in {path.name}-wal beside it."
        yield Finding("note", str(path), what, remedy)
    if earlier is not None:
        what = "it was made by an earlier version of the program and now has the present format"
        remedy = f"No action is needed. The earlier version opens the copy {earlier.name}."
        yield Finding("note", str(path), what, remedy)
