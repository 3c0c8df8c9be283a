"""Track: the tracker, its runs, and how they compare."""

from __future__ import annotations

from ...context import Context
from ...services.layout import Workspace
from .actions import commands
from .controller import RunsController


def register(context: Context) -> RunsController:
    """Offer the workspace Track, its panels and its commands."""
    runs = RunsController(context)
    context.docks.add_workspace(
        Workspace(
            "track",
            "Track",
            "Run the tracker and watch it: views, 3-D scene, settings and runs.",
            "run-tracker",
            side=(("scene",), ("runs", "parameters", "numbers", "inside", "findings")),
            bottom=("plot", "timeline"),
            side_share=0.37,
            bottom_heights=(145, 160),
            side_heights=(2, 1),
            why_not=context.session.no_depth,
        )
    )
    context.actions.add(commands(context, runs))
    return runs
