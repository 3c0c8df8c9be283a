"""Tune: attempts beside a run, values of one parameter, and presets."""

from __future__ import annotations

from ...context import Context
from ...services.layout import Workspace
from .actions import commands
from .controller import TuneController


def register(context: Context) -> TuneController:
    """Offer the workspace Tune, its panels and its commands."""
    tuning = TuneController(context)
    context.docks.add_workspace(
        Workspace(
            "tune",
            "Tune",
            "Change settings, run trials on a stretch of frames, and compare them.",
            "settings",
            side=(("parameters",), ("attempts", "series", "comparison", "runs", "inside")),
            bottom=("plot", "timeline"),
            side_share=0.40,
            bottom_heights=(165, 150),
            side_heights=(1, 1),
            tall_side=True,
            why_not=context.session.no_depth,
        )
    )
    context.actions.add(commands(context.session, tuning))
    tuning.offer(context.actions)
    return tuning
