"""Open a project file: who may, on which drive, and what to tell about it."""

import os
import sqlite3
from contextlib import ExitStack, closing, suppress
from dataclasses import astuple, dataclass
from pathlib import Path

import psutil

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.locks import FileLock, Owner, is_held, lock_owner, lock_path
from stereotrack_core.project.connection import (
    Access,
    LogWriter,
    connect,
    connect_for_reading,
    set_log,
)
from stereotrack_core.project.database import (
    ProjectInUse,
    check_header,
    check_whole,
    is_in_place,
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


_NETWORK_TYPES = frozenset(
    {
        *("9p", "afp", "afpfs", "afs", "beegfs", "ceph", "cifs", "coda", "davfs", "davfs2"),
        *("drvfs", "fuse.davfs2", "fuse.gcsfuse", "fuse.glusterfs", "fuse.rclone"),
        *("fuse.s3fs", "fuse.sshfs", "gfs2", "glusterfs", "gpfs", "lustre", "ncpfs", "nfs"),
        *("nfs4", "ocfs2", "orangefs", "smb3", "smbfs", "vboxsf", "virtiofs", "webdav"),
    }
)
"""File systems whose shared memory is not shared between the machines that write to them."""


def network_type(path: Path) -> str | None:
    """Type of the network file system of a path; None for the machine's own."""
    place = Path(os.path.realpath(path))
    if str(place).startswith("\\\\"):
        return "network share"
    mounts = psutil.disk_partitions(all=True)
    around = [one for one in mounts if place.is_relative_to(one.mountpoint)]
    nearest = max(around, key=lambda one: len(one.mountpoint), default=None)
    if nearest is None:
        return None
    if "remote" in nearest.opts.split(","):  # what psutil says of a drive of Windows
        return "network drive"
    return nearest.fstype if nearest.fstype in _NETWORK_TYPES else None


_UNCERTAIN = (
    "Close it there. If that program is certainly no longer running, force unlock the project."
)


@dataclass(frozen=True, eq=False)
class Opened:
    """An open project file."""

    access: Access
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
            raise InputError(what, where=str(path.parent), remedy=remedy) from error
        stack.callback(lock.release)
        network = network_type(path)
        with making_sense(path):
            database = stack.enter_context(closing(connect(path)))
            left = owner_of(database)
            if left is not None:
                ours = lock.holds and (network is None or left.host == Owner.myself().host)
                if not (take_over or ours):  # else it is gone for certain
                    raise _in_use(path, left, _UNCERTAIN)
            check_whole(database, path)
            status = path.stat()
            identity = None if network else (status.st_dev, status.st_ino)
            stack.callback(_give_back, database, path, identity)
            write_owner(database, Owner.myself())  # into the file: a copy without its log says so
            set_log(database, log=network is None)
            reader = log = None
            if network is None:
                reader = stack.enter_context(closing(connect_for_reading(path)))
                log = stack.enter_context(closing(LogWriter(path)))
        access = Access(database, path, identity, reader, log)
        return Opened(access, False, _notes(path, left, locked), stack.pop_all())
    raise AssertionError  # the stack swallows no exception


def open_for_reading(path: Path) -> Opened:
    """Open the file to be read, also while another writes. Raises InputError, ProjectDamaged."""
    locked, held = lock_path(path).exists(), is_held(path, unsure=True)
    with ExitStack() as stack, making_sense(path):
        database = stack.enter_context(closing(connect_for_reading(path)))
        left = None if held else owner_of(database)
        check_whole(database, path)
        return Opened(Access(database, path), True, _notes(path, left, locked), stack.pop_all())
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


def _notes(path: Path, left: Owner | None, locked: bool) -> tuple[Finding, ...]:
    """Note on a file that was not closed, or copied while open."""
    if left is None:
        return ()
    who = f"process {left.process} on {left.host}"
    what = f"{who} did not close it; all edits are saved"
    remedy = "No action is needed. Undo works as before."
    if not locked:
        what = f"it was copied or moved while {who} had it open"
        remedy = f"Its newest edits may be missing: they were in {path.name}-wal beside it."
    return (Finding("note", str(path), what, remedy),)
