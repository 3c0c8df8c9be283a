"""Commands that look inside a frame."""

from __future__ import annotations

from ...services.actions import Command
from ...session.session import Session
from .controller import InspectController

_MENU = "&Track"


def commands(session: Session, inspect: InspectController) -> list[Command]:
    """Commands for the inside of a frame, in the menu Track."""

    def export_why() -> str:
        return "" if inspect.inside.known is not None else "Look inside a frame first."

    return [
        Command(
            "iterate", _MENU, "Step inside the next frame",
            "Show step by step what the tracker in progress does in its next frame; after the "
            "last step, track it.", inspect.iterate, "F11", "iterate",
            lambda: session.no_depth() or session.tracker_works(), section=True,
        ),
        Command(
            "look_inside", _MENU, "Look inside the frame", "Show step by step what the tracker "
            "does in this frame: prediction, points, correspondences, sigma points, "
            "cross-covariance, correction.", inspect.toggle, "F12", "search",
            lambda: session.no_depth() or session.tracker_works(),
            checked=lambda: inspect.inside.looking,
        ),
        Command(
            "inside_next", _MENU, "Next step inside the frame",
            "Show the next step of what the tracker does in this frame.",
            lambda: inspect.step(1), "F7", "step-forward",
            lambda: inspect.why_no_step(1),
        ),
        Command(
            "inside_previous", _MENU, "Previous step inside the frame",
            "Show the step before.", lambda: inspect.step(-1), "Shift+F7", "step-back",
            lambda: inspect.why_no_step(-1),
        ),
        Command(
            "inside_export", _MENU, "Export the inside of the frame…", "Write the "
            "cross-covariance of the iteration that is shown as CSV, or all numbers of the frame "
            "as NPZ.", inspect.ask_for_file, "", "export", export_why,
        ),
    ]  # fmt: skip
