"""Reading in a process of its own, whose memory and time are limited, and writing in one.

Some libraries are written in C and take what a file says for true: of a damaged one they ask for
any amount of memory, never come to an end, or end the process that they are in. HDF5 ends it long
after it could not write. Here that process is another one, and what was left of it becomes a
sentence.
"""

import errno
import faulthandler
import gc
import io
import logging
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, NamedTuple, NoReturn, TypeVar

from stereotrack_core.errors import InputError, portable
from stereotrack_core.memory import machine_bytes
from stereotrack_core.own_program import end_with_input, module_command

_LOG = logging.getLogger(__name__)

Result = TypeVar("Result")

GB, _MB = 1024**3, 1024**2

LEAST_MEMORY, _BASE_MEMORY, _MEMORY_FOR_SIZE = 4 * GB, 2 * GB, 30
"""Addresses that the process may have: Python and the libraries take 0.5 GB of them before anything
is read. SLEAP's labels take 8 times the size of their file, and 17 times where people have a single
point: measured with all that is made of them there."""
_ANSWER_SHARE = 4
"""The result may have the fourth part of the memory: it is held here, where nothing limits it."""
LEAST_SECONDS, _SECONDS_FOR_MB = 120.0, 2.0
"""A busy machine needs some seconds to start a process, and an idle one 0.3 s for each MB."""
_LONGEST_WRITING = 3600.0  # seconds: pictures of long videos may have to be put into it
_OWN_SECONDS = 5.0  # so much later the process ends by itself, where nobody is left to end it
_ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Each further thread of theirs would take addresses."""


class Limits(NamedTuple):
    """What a process may use."""

    memory: int
    seconds: float

    @property
    def answer(self) -> int:
        """Most bytes of its answer."""
        return self.memory // _ANSWER_SHARE


class Ended(NamedTuple):
    """What is left of a process that has ended."""

    code: int
    answer: bytes
    complaint: str = ""
    late: bool = False  # whether it was ended because it took too long


def read_apart(
    read: Callable[[Path], Result],
    path: Path,
    remedy: str,
    *,
    memory: int | None = None,
    seconds: float | None = None,
) -> Result:
    """Read a file, or a folder of files that are one, in another process; what that has read.

    It imports the module of `read` alone, a function or a partial of one, and ends with this
    process. What `read` returns and raises is sent by pickle, and should be small or arrays.
    `memory`: most bytes of addresses; without it 4 GB, or 2 GB and 30 times the file where that is
    more, at most half the machine's memory. Where a system knows no such limit (Windows, macOS),
    only time is limited, by default to 2 minutes, and 2 s for each MB.

    Raises what `read` raises; InputError with `remedy` where it takes more than allowed, or the
    process is ended by what it reads; OSError where none can be started.
    """
    size = sum(one.stat().st_size for one in (path, *path.glob("*")) if one.is_file())
    wanted = _BASE_MEMORY + _MEMORY_FOR_SIZE * size
    most = (machine_bytes() or LEAST_MEMORY) // 2
    limits = Limits(
        memory or max(LEAST_MEMORY, min(wanted, most)),
        seconds or LEAST_SECONDS + _SECONDS_FOR_MB * size / _MB,
    )
    return _result(_run(read, path, limits), path, limits, remedy)  # type: ignore[no-any-return]


def write_apart(write: Callable[[Path], None], path: Path) -> None:
    """Have a file written in another process, as :func:`read_apart` reads one, without its limits.

    Raises what `write` raises; OSError where no process can be started, or it is ended by what it
    does, or after an hour.
    """
    ended = _run(write, path, Limits(sys.maxsize, _LONGEST_WRITING))
    if ended.code != 0 or ended.late or not ended.answer:
        _LOG.warning("%s: writing it ended with %d: %s", path, ended.code, ended.complaint)
        broken = f"what writes it broke down: {_name_of(ended.code)}"
        why = "it takes too long" if ended.late else broken
        raise ChildProcessError(errno.ECHILD, why, str(path))
    error, _ = _told(ended.answer)
    if error is not None:
        raise error


def _told(answer: bytes) -> tuple[Exception | None, Any]:
    """What the other process raised, and its result."""
    words = io.BytesIO(answer)
    pickle.load(words)  # noqa: S301 - our own process, which says first that it has begun
    return pickle.load(words)  # type: ignore[no-any-return] # noqa: S301


def _result(ended: Ended, path: Path, limits: Limits, remedy: str) -> Any:
    """What was read, or why it was not."""
    if ended.late:
        _refuse(path, f"or too large: reading it takes more than {limits.seconds:.0f} s", remedy)
    if not ended.answer:
        _LOG.warning("%s: no process to read it: %s", path, ended.complaint)
        why = "no process could be started to read the file"
        raise ChildProcessError(errno.ECHILD, why, str(path))
    if len(ended.answer) > limits.answer:
        _refuse(path, "or too large: it unfolds into too many numbers", remedy)
    if ended.code != 0:
        _LOG.info("%s: reading it ended with %d: %s", path, ended.code, ended.complaint)
        _refuse(path, f"so that its reader broke down ({_name_of(ended.code)})", remedy)
    error, result = _told(ended.answer)
    if isinstance(error, MemoryError):
        used = f"{limits.memory / GB:.1f} GB of memory"
        _refuse(path, f"or too large: reading it takes more than {used}", remedy)
    if error is not None:
        raise error
    return result


def _refuse(path: Path, why: str, remedy: str) -> NoReturn:
    raise InputError(f"the file is damaged {why}", where=str(path), remedy=remedy) from None


def _name_of(code: int) -> str:
    with suppress(ValueError):
        return signal.Signals(-code).name
    return f"exit code {code}"


def _run(read: Callable[[Path], Any], path: Path, limits: Limits) -> Ended:
    """Have it read by a new process; Ctrl-C in a terminal is for this one alone."""
    late, answer = threading.Event(), bytearray()
    with (
        tempfile.TemporaryFile() as complaints,
        subprocess.Popen(  # noqa: S603 - our own program
            module_command("stereotrack_core.limited_process", []),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=complaints,
            env={**os.environ, **_ONE_THREAD},
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        ) as process,
    ):

        def end() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(limits.seconds, end)
        timer.daemon = True
        timer.start()
        try:
            assert process.stdin is not None  # noqa: S101 - pipes were asked for
            assert process.stdout is not None  # noqa: S101
            with suppress(OSError):  # where it has ended already
                pickle.dump((read, path, limits), process.stdin)
                process.stdin.flush()
            while part := process.stdout.read(_MB):
                answer += part
                if len(answer) > limits.answer:
                    process.kill()
                    break
            code = process.wait()
        except BaseException:
            process.kill()
            raise
        finally:
            timer.cancel()
        complaints.seek(0)
        complaint = complaints.read(2000).decode(errors="replace")
    return Ended(code, bytes(answer), complaint, late.is_set())


# ---- in the other process


def _serve() -> NoReturn:
    """Do what is asked; what a library prints is no answer."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        read, path, limits = pickle.load(sys.stdin.buffer)  # noqa: S301 - from above
        end_with_input()
        faulthandler.dump_traceback_later(limits.seconds + _OWN_SECONDS, exit=True, file=2)
        do(read, path, limits, answers)


def do(read: Callable[[Path], Any], path: Path, limits: Limits, answers: IO[bytes]) -> NoReturn:
    """Read a file in this process within the limits of memory, answer, and end it.

    It ends without a word to what the libraries keep: one that is broken would not come to an end.
    """
    _limit_memory(limits.memory)
    gc.disable()  # what is read is kept, and the process ends with it
    pickle.dump("begun", answers)
    answers.flush()
    answer: tuple[Exception | None, Any]
    try:
        answer = (None, read(path))
    except Exception as error:  # noqa: BLE001 - told to whoever asked
        answer = (portable(error), None)
    try:
        pickle.dump(answer, answers)
        answers.flush()
    except MemoryError:
        os._exit(1)
    os._exit(0)


def _limit_memory(memory: int) -> None:
    """Give this process so many bytes of addresses, where the system can, and no core dump."""
    try:
        import resource
    except ImportError:  # as on Windows
        return
    for what, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(what)[1]
        soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
        with suppress(ValueError, OSError):  # a system that cannot limit it
            resource.setrlimit(what, (soft, hard))


if __name__ == "__main__":
    _serve()
