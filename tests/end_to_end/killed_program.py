"""Runs command lines in forked children and kills them; each begins with all modules loaded.

Each line of JSON on standard input holds seconds and words. The words are done in a child that is
killed after so many seconds; null lets it end, and 0 does them without a child, so that all is
loaded. How it has ended is a line on standard output.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time

from stereotrack_core.program import main


def serve() -> None:
    """Serve until standard input ends."""
    told = os.fdopen(os.dup(1), "w", buffering=1)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):
        os.dup2(nothing, stream)  # what the commands say
    for line in sys.stdin:
        seconds, *words = json.loads(line)
        if seconds == 0:
            told.write(f"{main(words)}\n")
            continue
        child = os.fork()
        if child == 0:
            os._exit(main(words))
        if seconds is not None:
            time.sleep(seconds)
            os.kill(child, signal.SIGKILL)  # not waited for yet, so the number is still its own
        _, status = os.waitpid(child, 0)
        told.write(f"{os.waitstatus_to_exitcode(status)}\n")


if __name__ == "__main__":
    serve()
