"""Commands about statistics, explanations and joint angles."""

from __future__ import annotations

from functools import partial

from ...services.actions import Command
from ...session.session import Session
from .controller import ReviewController
from .plot import ErrorCurves

_MENU, _GO = "&Review", "&Go"
_STEP_DEG = 5.0


def commands(session: Session, review: ReviewController, plot: ErrorCurves) -> list[Command]:
    """Commands of the menus Go and Review."""
    return [
        Command(
            "next_above", _GO, "Next stretch above threshold",
            "Go to the next stretch in which the error of a limb exceeds the threshold of the "
            "plot.",
            lambda: plot.go_above(1), "N", "next-episode", session.no_run, section=True,
        ),
        Command(
            "previous_above", _GO, "Previous stretch above threshold",
            "Go to the previous stretch in which the error of a limb exceeds the threshold of the "
            "plot.",
            lambda: plot.go_above(-1), "P", "previous-episode", session.no_run,
        ),
        Command(
            "threshold_up", _MENU, "Raise threshold", "Raise the threshold of the plot by 5°.",
            partial(review.move_threshold, _STEP_DEG), "Ctrl+Alt+Up", "threshold",
            session.no_run,
        ),
        Command(
            "threshold_down", _MENU, "Lower threshold", "Lower the threshold of the plot by "
            "5°.", partial(review.move_threshold, -_STEP_DEG), "Ctrl+Alt+Down", "threshold",
            session.no_run,
        ),
        Command(
            "copy_statistics", _MENU, "Copy statistics",
            "Copy the statistics of each limb as a CSV table, for the selection or the whole "
            "recording and for each segment.",
            review.copy_statistics, "Ctrl+Alt+C", "table", session.no_run, section=True,
        ),
        Command(
            "save_statistics", _MENU, "Save statistics …",
            "Save the statistics of each limb as a CSV table.",
            review.ask_where_to_save_statistics, icon="save",
            why_not=session.no_run,
        ),
        Command(
            "save_angles", _MENU, "Save joint angles …",
            "Save the joint angles of the active run frame by frame, with velocities, "
            "accelerations and standard deviations, as CSV.",
            review.ask_where_to_save_angles, icon="save",
            why_not=lambda: session.no_recording() or review.why_no_angles(),
        ),
    ]  # fmt: skip
