"""Sweeps: their commands, dialogs and results."""

from __future__ import annotations

from ...context import Context
from .actions import commands
from .controller import SweepController


def register(context: Context) -> SweepController:
    """Offer sweeps."""
    sweeps = SweepController(context)
    context.actions.add(commands(sweeps))
    return sweeps
