"""Commands of sweeps, in the menu Track."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...services.actions import Command

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_MENU = "&Track"


def commands(w: MainWindow) -> list[Command]:
    """Commands that begin a sweep and look at what came of one."""
    return [
        Command(
            "sweep", _MENU, "Sweep …",
            "Track with many values of parameters, recordings and seeds, in the background, and "
            "compare them.", w.sweeps.show_dialog, "Ctrl+Alt+S", "grid", section=True,
        ),
        Command(
            "sweep_results", _MENU, "Results of a sweep …",
            "Plot the table of a sweep: a measure over a parameter, or a map over two.",
            w.sweeps.ask_for_results, "Ctrl+Alt+R", "table",
        ),
    ]  # fmt: skip
