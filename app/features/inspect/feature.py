"""Inspect: what the tracker does within one frame."""

from __future__ import annotations

from ...context import Context
from .actions import commands
from .controller import InspectController


def register(context: Context) -> InspectController:
    """Offer the panel and its commands."""
    inspect = InspectController(context)
    context.actions.add(commands(context.session, inspect))
    inspect.offer(context.actions)
    return inspect
