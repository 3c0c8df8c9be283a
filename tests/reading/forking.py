"""Thousands of readings in processes of their own: by a fork, which takes milliseconds."""

from __future__ import annotations

import math
import mmap
import os
import signal
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from stereotrack_core.limited_process import Ended, Limits, do


def run_forked(read: Callable[[Path], Any], path: Path, limits: Limits) -> Ended:
    """As ``limited_process._run``, with what this process has loaded already.

    Its addresses are not counted.
    """
    ours, theirs = os.pipe()
    mapped = int(Path("/proc/self/statm").read_text().split()[0]) * mmap.PAGESIZE
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads: nobody else's are needed
        pid = os.fork()
    if pid == 0:
        try:
            os.close(ours)
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, 1)
            os.dup2(silence, 2)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(math.ceil(limits.seconds))
            with os.fdopen(theirs, "wb") as answers:
                do(read, path, limits._replace(memory=limits.memory + mapped), answers)
        finally:
            os._exit(1)
    os.close(theirs)
    with os.fdopen(ours, "rb") as answers:
        answer = answers.read()
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    return Ended(code, answer, "", late=code == -signal.SIGALRM)


def load_libraries() -> None:
    """Load the libraries, for all that are forked."""
    if find_spec("h5py") is not None:
        import h5py  # noqa: F401
    if find_spec("sleap_io") is not None:
        import sleap_io

        assert sleap_io.load_slp
    import scipy.io  # noqa: F401

    if find_spec("rosbags") is not None:
        import rosbags.highlevel
        import rosbags.typesys  # noqa: F401
