"""Sweeps: their commands, dialogs and results."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Command
from .controller import SweepController

_MENU = "&Track"


def register(context: Context) -> SweepController:
    """Offer sweeps."""
    sweeps = SweepController(context)
    context.actions.add(_commands(sweeps))
    return sweeps


def _commands(sweeps: SweepController) -> list[Command]:
    """Commands that begin a sweep and look at what came of one."""
    return [
        Command(
            "sweep", _MENU, "Sweep …",
            "Track with several parameter values, recordings and seeds in the background, and "
            "compare the results.", sweeps.show_dialog, "Ctrl+Alt+S", "grid", section=True,
        ),
        Command(
            "sweep_results", _MENU, "Sweep results …",
            "Plot the results of a sweep: a measure over one parameter, or a heat map over two.",
            sweeps.ask_for_results, "Ctrl+Alt+R", "table",
        ),
    ]  # fmt: skip
