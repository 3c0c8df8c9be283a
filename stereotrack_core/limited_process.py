"""Work with a file in a process of its own, whose memory and time are limited.

Some libraries are written in C and take what a file says for true: of a damaged one they ask for
any amount of memory, never come to an end, or end the process that they are in. HDF5 ends it long
after it could not write. Here that process is another one, and what was left of it becomes a
sentence.
"""

import errno
import faulthandler
import gc
import os
import pickle
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.memory import machine_bytes
from stereotrack_core.worker_processes import Asker, Lost, TaskProcess

Result = TypeVar("Result")
GB, _MB = 1024**3, 1024**2
LEAST_MEMORY, _BASE_MEMORY, _MEMORY_FOR_SIZE = 4 * GB, 2 * GB, 30
"""Addresses that the process may have beside those of Python and the libraries. SLEAP's labels take
8 times the size of their file, and 17 times where people have a single point: measured with all
that is made of them there."""
_ANSWER_SHARE = 4
"""The result may have the fourth part of the memory: it is held here, where nothing limits it."""
LEAST_SECONDS, _SECONDS_FOR_MB = 120.0, 2.0
"""A busy machine needs some seconds to start a process, and an idle one 0.3 s for each MB."""
_OWN_SECONDS = 5.0  # so much later the process ends by itself, where nobody is left to end it


def read_apart(
    read: Callable[[Path], Result],
    path: Path,
    remedy: str,
    *,
    memory: int | None = None,
    seconds: float | None = None,
) -> Result:
    """Read a file, or a folder of files that are one, in another process; what that has read.

    A file may also be written so, whose library could end the process that has written it.

    The process ends with this one. What `read`, a function or a partial of one, returns and raises
    is sent by pickle, and should be small or arrays. `memory`: most bytes of addresses; without it
    4 GB, or 2 GB and 30 times the file where that is more, at most half the machine's memory. Where
    a system knows no such limit (Windows, macOS), only time is limited, by default to 2 minutes,
    and 2 s for each MB.

    Raises what `read` raises; InputError with `remedy` where it takes more than allowed, or the
    process is ended by what it reads; OSError where none can be started.
    """
    size = sum(one.stat().st_size for one in (path, *path.glob("*")) if one.is_file())
    wanted = _BASE_MEMORY + _MEMORY_FOR_SIZE * size
    most = (machine_bytes() or LEAST_MEMORY) // 2
    memory = memory or max(LEAST_MEMORY, min(wanted, most))
    seconds = seconds or LEAST_SECONDS + _SECONDS_FOR_MB * size / _MB
    try:
        answer = _apart(read, path, memory, seconds)
    except Cancelled:
        why = f"or too large: reading it takes more than {seconds:.0f} s"
    except Lost as lost:
        why = f"so that its reader broke down ({_name_of(lost)})"
    else:
        if answer and len(answer) <= memory // _ANSWER_SHARE:
            return pickle.loads(answer)  # type: ignore[no-any-return] # noqa: S301 - from below
        why = "or too large: it unfolds into too many numbers"
        if not answer:
            why = f"or too large: reading it takes more than {memory / GB:.1f} GB of memory"
    raise InputError(f"the file is damaged {why}", path, remedy)


def _name_of(lost: Lost) -> str:
    with suppress(ValueError, TypeError):
        return signal.Signals(-lost.code).name
    return f"exit code {lost.code}"


def _apart(do: Callable[[Path], Any], path: Path, memory: int, seconds: float) -> bytes:
    """Pickled result of a new process, empty for lack of memory. Raises Cancelled if it is late."""
    process, begun = TaskProcess(nice=0), list[Any]()
    late = time.monotonic() + seconds
    task = partial(_limited, do, path, memory, seconds)
    try:
        answer: bytes = process(task, begun.append, lambda: time.monotonic() > late, listens=False)
        return answer
    except Lost:
        if not begun:
            why = "no process could be started to read the file"
            raise ChildProcessError(errno.ECHILD, why, str(path)) from None
        raise
    finally:
        process.close()


def _limited(
    do: Callable[[Path], Any], path: Path, memory: int, seconds: float, asker: Asker
) -> bytes:
    """Do it in the other process, within the limits; what a library prints is shown to nobody."""
    asker.tell("begun")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    faulthandler.dump_traceback_later(seconds + _OWN_SECONDS, exit=True, file=2)
    gc.disable()  # what is read is kept, and the process ends with it
    _limit_memory(memory)
    try:
        return pickle.dumps(do(path))
    except MemoryError:
        return b""


def _limit_memory(memory: int) -> None:
    """Give this process so many more bytes of addresses, where the system can, and no core dump."""
    with suppress(ImportError, ValueError, OSError):  # a system that cannot limit it
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + memory
        for what, limit in ((resource.RLIMIT_CORE, 0), (resource.RLIMIT_AS, most)):
            hard = resource.getrlimit(what)[1]
            resource.setrlimit(what, (min(limit, hard) if hard >= 0 else limit, hard))
