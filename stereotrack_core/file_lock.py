"""A file that one program at a time writes to; the system lets go of it however that one ends."""

from __future__ import annotations

import errno
import os
import sys
from typing import IO

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_TAKEN = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK)
"""What the system says where another program has the lock; anything else: it knows no locks."""

_BEYOND = 2**40
"""Byte that stands for the file where bytes are locked, so that others may read those before."""


def take_lock(file: IO[bytes]) -> bool:
    """Lock an open file until it is closed; False on a drive that knows no locks.

    Raises BlockingIOError when another program has the lock.
    """
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
