"""Files of one writer at a time: the lock, who has it, and what to tell the second one."""

from __future__ import annotations

import errno
import getpass
import json
import os
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import IO

from stereotrack_core.errors import InputError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_TAKEN = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK)
"""What the system says where another program has the lock; anything else: it knows no locks."""

_BEYOND = 2**40
"""Byte that stands for the file where bytes are locked, so that others may read those before."""

_TRIES, _TRY_SECONDS = 5, 0.1  # whoever only asks whether a lock is held has it for a moment
_MOST_OF_A_NOTE = 2000


def take_lock(file: IO[bytes]) -> bool:
    """Lock an open file until it is closed, False if impossible; BlockingIOError if it is taken."""
    try:
        if sys.platform == "win32":
            here = file.tell()
            os.lseek(file.fileno(), _BEYOND, os.SEEK_SET)
            try:
                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            finally:
                os.lseek(file.fileno(), here, os.SEEK_SET)
        else:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _TAKEN:
            raise BlockingIOError from None
        return False
    return True


def now() -> str:
    """Present time, ISO 8601, UTC."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def user() -> str:
    """Name of the person at this machine."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # no such user is known to the system
        return "somebody"


@dataclass(frozen=True)
class Owner:
    """A program that writes to a file, or did so when it crashed."""

    host: str
    process: int
    who: str
    at: str

    @staticmethod
    def myself() -> Owner:
        """The program that asks."""
        return Owner(socket.gethostname(), os.getpid(), user(), now())

    def __str__(self) -> str:
        since = self.at.replace("T", " ")[:16]
        return f"process {self.process} on {self.host}, user {self.who}, since {since} UTC"


def lock_path(path: Path) -> Path:
    """The file whose lock stands for another one, or for a folder."""
    return path.with_name(f".{path.name}.lock")


def is_held(path: Path, *, unsure: bool) -> bool:
    """Whether a program has the lock of a file now; `unsure` where that cannot be told."""
    lock = lock_path(path)
    try:
        with lock.open("r+b" if os.access(lock, os.W_OK) else "rb") as file:
            return not take_lock(file) and unsure
    except FileNotFoundError:
        return False
    except BlockingIOError:
        return True
    except OSError:
        return unsure


class FileLock:
    """The lock of a file or folder: taken on construction, given back by :meth:`release`.

    It is the operating system's, on a file beside `path` that says who has it; the system lets go
    of it when the program ends. `holds`: False on drives that know no locks. Raises BlockingIOError
    when another program has it; OSError when no file can be made beside `path`; InputError where
    something else stands there.
    """

    def __init__(self, path: Path) -> None:
        self._path = lock_path(path)
        self.holds = True
        self._file: IO[bytes] | None = self._locked()
        with suppress(OSError):  # a drive that is full
            self._file.truncate(0)
            self._file.write(json.dumps(asdict(Owner.myself())).encode())

    def _locked(self) -> IO[bytes]:
        if self._path.is_symlink() or (self._path.exists() and not self._path.is_file()):
            what = "this is not a file that the program has made"
            raise InputError(what, self._path, "Remove it.")
        while True:
            file = self._opened()
            try:
                self.holds = take_lock(file)
            except BlockingIOError:
                file.close()
                raise
            with suppress(FileNotFoundError):
                if not self.holds or os.path.samestat(os.fstat(file.fileno()), self._path.stat()):
                    return file
            file.close()  # its owner removed it between opening and locking

    def _opened(self) -> IO[bytes]:
        try:
            return self._path.open("ab", buffering=0)
        except PermissionError:
            if not (self._path.exists() and os.access(self._path.parent, os.W_OK)):
                raise
            return self._path.open("rb", buffering=0)  # that another user's process has left

    def release(self) -> None:
        """Give the lock back; a second time does nothing."""
        if self._file is None:
            return
        if sys.platform == "win32":
            self._file.close()
        with suppress(PermissionError):  # Windows: the next program already has it open
            self._path.unlink(missing_ok=True)
        self._file.close()
        self._file = None


def lock_output(path: Path) -> FileLock:
    """The lock of an output; InputError where another process has it, or nothing can be written."""
    for _ in range(_TRIES):
        try:
            return FileLock(path)
        except BlockingIOError:
            time.sleep(_TRY_SECONDS)
        except OSError as error:
            what = f"cannot write here ({error.strerror})"
            raise InputError(what, path.parent, "Choose a folder that you may write to.") from error
    raise _in_use(path)


def refuse_second(path: Path) -> None:
    """Refuse an output that another process writes to, before any work. Raises InputError."""
    if is_held(path, unsure=False):
        raise _in_use(path)


@contextmanager
def writing(path: Path | None) -> Iterator[None]:
    """Keep others from writing to an output meanwhile, if one is given; see :func:`lock_output`."""
    if path is None:
        yield
        return
    lock = lock_output(path)
    try:
        yield
    finally:
        lock.release()


def _in_use(path: Path) -> InputError:
    what = f"this output is being written by {lock_owner(path) or 'another process'}"
    remedy = "Wait until it has finished, stop it, or choose another output."
    return InputError(what, path, remedy)


def lock_owner(path: Path) -> Owner | None:
    """Who says to have the lock; None where that cannot be read."""
    try:
        with lock_path(path).open("rb") as file:
            told = json.loads(file.read(_MOST_OF_A_NOTE))
        return Owner(str(told["host"]), int(told["process"]), str(told["who"]), str(told["at"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None
