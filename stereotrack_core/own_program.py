"""Processes of this program: what to start so that one of its modules does something there.

A program that PyInstaller has put together has no interpreter; it starts itself, and finds out by
its first argument that it shall run a module.
"""

import os
import runpy
import signal
import sys
import threading
from collections.abc import Sequence

_OPTION = "--run-module"
_CODE = (
    "import sys; sys.path[:] = {path!r}; "
    "from stereotrack_core.own_program import run_module; run_module({module!r}, sys.argv[1:])"
)


def module_command(module: str, arguments: Sequence[str]) -> list[str]:
    """What to start so that a module is run with these arguments, as by ``python -m``."""
    if getattr(sys, "frozen", False):
        return [sys.executable, _OPTION, module, *arguments]
    return [sys.executable, "-c", _CODE.format(path=sys.path, module=module), *arguments]


def asked_module(argv: Sequence[str]) -> tuple[str, list[str]] | None:
    """The module that these arguments of the process ask for, and its own; None for a person's."""
    return (argv[2], list(argv[3:])) if len(argv) > 2 and argv[1] == _OPTION else None


def run_module(module: str, arguments: Sequence[str]) -> None:
    """Run a module as ``python -m`` does, which ends the process."""
    sys.argv[1:] = arguments
    runpy.run_module(module, run_name="__main__", alter_sys=True)


def end_with_input() -> None:
    """Ask this process to stop when its standard input ends, as when its parent is gone."""
    threading.Thread(target=_stop_with_input, daemon=True).start()


def _stop_with_input() -> None:
    while os.read(0, 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)  # long work listens to it
