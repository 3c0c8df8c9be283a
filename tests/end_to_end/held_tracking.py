"""The program, held after so many frames until it hears something on standard input.

It is given the frames, then the command line; a line on standard output says that it is held.
With ``limit`` before the frames it is not held, but no file may grow any more, as on a full drive.
"""

import os
import resource
import signal
import sys

from stereotrack_core.interop.run_journal import RunJournal
from stereotrack_core.program import main


def hold(frames: int, *, full: bool) -> None:
    """Hold the program, or fill the drive, when so many frames have been kept."""
    keep = RunJournal.keep

    def kept(self: RunJournal, *what: object) -> None:
        keep(self, *what)
        if self.kept != frames:
            return
        if full:
            most = self.path.stat().st_size + 100
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.RLIM_INFINITY))
            return
        os.write(1, b"held\n")
        os.read(0, 1)

    RunJournal.keep = kept


if __name__ == "__main__":
    # whoever runs the tests may have said that they outlive the terminal
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    full = sys.argv[1] == "limit"
    arguments = sys.argv[2:] if full else sys.argv[1:]
    hold(int(arguments[0]), full=full)
    sys.exit(main(arguments[1:]))
