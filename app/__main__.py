"""Start-up: the program, with the window handed to it."""

import os
import sys
from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status.

    Everything is done by the core's commands, which know nothing of Qt. Those that show the window
    are given it here.
    """
    # Window and command line shall get the same to the last bit. Linear algebra that has begun with
    # several threads inverts matrices otherwise where a thread other than the first limits it to
    # one. This is read when it is loaded, so it comes before anything else.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from stereotrack_core import program

        from .start import show

        return program.main(argv, window=show)
    except KeyboardInterrupt:  # while what is needed is still being loaded
        sys.stderr.write("Stopped.\n")
        return 1


if __name__ == "__main__":
    sys.exit(main())
