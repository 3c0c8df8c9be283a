"""Inspect: what the tracker does within one frame."""

from __future__ import annotations

from ...context import Context
from ...services.actions import Command
from ...session.session import Session
from .controller import InspectController

_MENU = "&Track"


def register(context: Context) -> InspectController:
    """Offer the panel and its commands."""
    inspect = InspectController(context)
    context.actions.add(_commands(context.session, inspect))
    inspect.offer(context.actions)
    return inspect


def _commands(session: Session, inspect: InspectController) -> list[Command]:
    """Commands for the inside of a frame, in the menu Track."""

    def export_why() -> str:
        return (
            ""
            if inspect.known is not None
            else "No step trace is shown. Choose Inspect step first."
        )

    return [
        Command(
            "iterate", _MENU, "Inspect next frame",
            "Show step by step how the tracker processes its next frame. The frame is tracked "
            "after the last stage.", inspect.iterate, "F11", "iterate",
            lambda: session.not_tracked() or session.tracker_works(), section=True,
        ),
        Command(
            "look_inside", _MENU, "Inspect step", "Show step by step how the tracker "
            "processes this frame: prediction, points, correspondences, sigma points, "
            "cross-covariance, correction.", inspect.toggle, "F12", "search",
            lambda: session.not_tried() or session.tracker_works(),
            checked=lambda: inspect.inspects,
        ),
        Command(
            "inside_next", _MENU, "Next stage of the step",
            "Show the next stage of the tracker's step.",
            lambda: inspect.go(inspect.index + 1), "F7", "step-forward",
            lambda: inspect.why_no_step(1),
        ),
        Command(
            "inside_previous", _MENU, "Previous stage of the step",
            "Show the previous stage of the tracker's step.",
            lambda: inspect.go(inspect.index - 1), "Shift+F7", "step-back",
            lambda: inspect.why_no_step(-1),
        ),
        Command(
            "inside_export", _MENU, "Export step trace …",
            "Save the cross-covariance of the shown iteration as CSV, or all numbers of the step "
            "as NPZ.", inspect.ask_for_file, "", "export", export_why,
        ),
    ]  # fmt: skip
