"""One program at a time writes to a project; one that has crashed does not stand in the way.

The lock is the operating system's, on a file beside the project (SQLite's own locks on the project
file itself would be lost if another handle on it were closed). The system lets go of it when the
program ends in whichever way.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import IO

from stereotrack_core.errors import InputError
from stereotrack_core.file_lock import take_lock
from stereotrack_core.project.database import check_beside


def lock_path(project: Path) -> Path:
    """The file whose lock stands for the project."""
    return project.with_name(f".{project.name}.lock")


def is_held(project: Path) -> bool:
    """Whether a program has the lock now; True as well where that cannot be told."""
    try:
        with lock_path(project).open("rb") as file:
            return not take_lock(file)
    except FileNotFoundError:
        return False
    except OSError:
        return True


class ProjectLock:
    """Taken on construction, given back by :meth:`release`.

    Attributes
    ----------
    holds : bool
        False on drives that know no locks; only the note within the project tells its owner there.

    Raises
    ------
    BlockingIOError
        When another program has it.
    InputError
        When no file can be made beside the project.
    """

    def __init__(self, project: Path) -> None:
        self._path = lock_path(project)
        self.holds = True
        self._file: IO[bytes] | None = self._locked()

    def _locked(self) -> IO[bytes]:
        check_beside(self._path)
        while True:
            try:
                file = self._path.open("ab")
            except OSError as error:
                raise InputError(
                    f"nothing can be written beside the project ({error.strerror})",
                    where=str(self._path.parent),
                    remedy="Open the project for reading only, or copy it elsewhere.",
                ) from error
            try:
                self.holds = take_lock(file)
            except BlockingIOError:
                file.close()
                raise
            if not self.holds:
                return file
            if _is_still(file, self._path):
                return file
            file.close()  # its owner removed it between opening and locking

    def release(self) -> None:
        """Give the lock back; a second time does nothing."""
        if self._file is None:
            return
        if sys.platform == "win32":
            self._file.close()
            self._remove()
        else:
            self._remove()
            self._file.close()
        self._file = None

    def _remove(self) -> None:
        try:
            self._path.unlink(missing_ok=True)
        except PermissionError:
            return  # Windows: the next program already has it open


def _is_still(file: IO[bytes], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False
