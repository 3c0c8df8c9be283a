"""Calibrate: the cameras of the rig, where they stand, and what looks wrong about them."""

from __future__ import annotations

from ...context import Context
from ...services.layout import Workspace
from .controller import CalibrateController


def register(context: Context) -> CalibrateController:
    """Offer the workspace Calibrate and its panels."""
    calibrate = CalibrateController(context)
    context.docks.add_workspace(
        Workspace(
            "calibrate",
            "Calibrate",
            "Inspect the cameras of the rig, their positions, and problems of the recording.",
            "calibrate",
            side=(("scene",), ("rig",), ("findings",)),
            bottom=(),
            side_share=0.50,
            bottom_heights=(),
            side_heights=(3, 3, 2),
            why_not=context.session.no_recording,
        )
    )
    return calibrate
