"""Commands that look inside a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...services.actions import Command
from ...shell.reasons import no_depth, running

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_MENU = "&Track"


def commands(w: MainWindow) -> list[Command]:
    """Commands for the inside of a frame, in the menu Track."""

    def export_why() -> str:
        return "" if w.inside.known is not None else "Look inside a frame first."

    return [
        Command(
            "look_inside", _MENU, "Look inside the frame", "Show step by step what the tracker "
            "does in this frame: prediction, points, correspondences, sigma points, "
            "cross-covariance, correction.", lambda: w.inside_work.toggle(), "F12", "search",
            lambda: no_depth(w) or running(w), checked=lambda: w.inside.looking, section=True,
        ),
        Command(
            "inside_next", _MENU, "Next step inside the frame",
            "Show the next step of what the tracker does in this frame.",
            lambda: w.inside_work.step(1), "F7", "step-forward",
            lambda: w.inside_work.why_no_step(1),
        ),
        Command(
            "inside_previous", _MENU, "Previous step inside the frame",
            "Show the step before.", lambda: w.inside_work.step(-1), "Shift+F7", "step-back",
            lambda: w.inside_work.why_no_step(-1),
        ),
        Command(
            "inside_export", _MENU, "Export the inside of the frame…", "Write the "
            "cross-covariance of the iteration that is shown as CSV, or all numbers of the frame "
            "as NPZ.", lambda: w.inside_work.ask_for_file(), "", "export", export_why,
        ),
    ]  # fmt: skip
