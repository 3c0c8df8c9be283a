"""Start-up: the window, or a command of the command line."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

_WINDOW_COMMANDS = {"open", "demo"}
_HELP = {"-h", "--help"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program; return its exit status.

    Without a command the welcome page is shown; ``open`` and ``demo`` show the window;
    everything else, and a demo without a window, is done by the command line, which knows
    nothing of Qt.
    """
    # Window and command line shall get the same to the last bit. Linear algebra that has begun with
    # several threads inverts matrices otherwise where a thread other than the first limits it to
    # one. This is read when it is loaded, so it comes before anything else.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        return _run(list(sys.argv[1:] if argv is None else argv))
    except KeyboardInterrupt:  # while what is needed is still being loaded
        sys.stderr.write("Stopped.\n")
        return 1


def _run(arguments: list[str]) -> int:
    command = arguments[0] if arguments else ""
    in_window = not arguments or command in _WINDOW_COMMANDS
    headless = "--headless" in arguments and not any(
        word.startswith("--screenshot") for word in arguments
    )
    if not in_window or headless or _HELP & set(arguments):
        from stereotrack_core.cli import main as command_line

        return command_line(arguments, app_package=__package__)
    from .start import start

    return start(arguments)


if __name__ == "__main__":
    sys.exit(main())
