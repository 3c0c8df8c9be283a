"""Work in another process, so that painting never waits for its turn with heavy computing.

The process ends by itself when the one that started it is gone, in whichever way.
"""

from __future__ import annotations

import importlib
import os
import pickle
import signal
import struct
import subprocess
import sys
import threading
from typing import IO, Any

_DIED = (EOFError, OSError, pickle.UnpicklingError)
_LENGTH = struct.Struct("<Q")
_CODE = "import sys; sys.path[:] = {path!r}; from {here} import serve; serve({of!r})"


class HelperProcess:
    """Answers questions, one after the other, in a process that is started with the first one.

    Parameters
    ----------
    worker : str
        ``module:name`` of a callable without arguments that gives the callable which answers.
        Questions and answers are pickled; the module should not load Qt.
    """

    def __init__(self, worker: str) -> None:
        self._worker = worker
        self._process: subprocess.Popen[bytes] | None = None
        self._closed = False
        self._starting = threading.Lock()
        self._turn = threading.Lock()

    def __call__(self, question: object) -> Any:
        """The answer; a process that has died is started anew, once.

        May be called from several threads, which take turns.

        Raises
        ------
        Exception
            What answering raised.
        EOFError
            Where it is closed, or the process dies again.
        """
        data = pickle.dumps(question)
        with self._turn:
            try:
                answered, result = self._exchange(data)
            except _DIED:
                answered, result = self._exchange(data)
        if not answered:
            raise result
        return result

    def close(self) -> None:
        """End the process for good; whoever waits for an answer gets an ``EOFError``."""
        self._closed = True
        with self._starting:  # whoever comes later sees that it is closed
            process = self._process
        if process is not None:
            process.kill()
        with self._turn:  # whoever has waited for an answer waits no longer
            self._end()

    def _exchange(self, data: bytes) -> tuple[bool, Any]:
        """Ask the process, in one's turn; one that does not answer is ended."""
        process = self._running()
        assert process.stdin is not None  # noqa: S101 - it was made with pipes
        assert process.stdout is not None  # noqa: S101 - it was made with pipes
        try:
            _send(process.stdin, data)
            answer: tuple[bool, Any] = pickle.loads(_receive(process.stdout))  # noqa: S301 - own
        except BaseException:
            self._end()  # what it may still answer is not for the next question
            raise
        return answer

    def _running(self) -> subprocess.Popen[bytes]:
        """The process, started where there is none."""
        with self._starting:
            if self._closed:
                raise EOFError
            if self._process is None:
                self._process = self._started()
            return self._process

    def _started(self) -> subprocess.Popen[bytes]:
        code = _CODE.format(path=sys.path, here=__name__, of=self._worker)
        return subprocess.Popen(  # noqa: S603 - our own code in our own interpreter
            [sys.executable, "-c", code],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )

    def _end(self) -> None:
        """End the process and close its pipes, which only the one whose turn it is reads."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    _close(pipe)


def serve(worker: str) -> None:
    """Answer questions from the standard input until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the window
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    module, _, name = worker.partition(":")
    answer = getattr(importlib.import_module(module), name)()
    while True:
        try:
            question = pickle.loads(_receive(sys.stdin.buffer))  # noqa: S301 - from our own window
        except EOFError:
            return
        try:
            result = (True, answer(question))
        except Exception as error:  # noqa: BLE001 - handed to the window, which shows it
            result = (False, error)
        _send(answers, pickle.dumps(result))


def _send(pipe: IO[bytes], data: bytes) -> None:
    pipe.write(_LENGTH.pack(len(data)))
    pipe.write(data)
    pipe.flush()


def _receive(pipe: IO[bytes]) -> bytes:
    (length,) = _LENGTH.unpack(_exactly(pipe, _LENGTH.size))
    return _exactly(pipe, length)


def _exactly(pipe: IO[bytes], count: int) -> bytes:
    data = pipe.read(count)
    if len(data) < count:
        raise EOFError
    return data


def _close(pipe: IO[bytes]) -> None:
    try:
        pipe.close()
    except OSError:
        return  # the other end is gone, with something still to be written to it
