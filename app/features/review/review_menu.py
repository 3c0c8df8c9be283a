"""Commands about statistics, explanations and joint angles."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ...services.actions import Command
from ...shell.reasons import no_judgement, no_recording

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_MENU = "&Review"
_STEP_DEG = 5.0


def commands(w: MainWindow) -> list[Command]:
    """Commands of the menu Review."""
    return [
        Command(
            "threshold_up", _MENU, "Raise the threshold", "Raise the threshold of the plot by 5°.",
            partial(w.review.move_threshold, _STEP_DEG), "Ctrl+Alt+Up", "threshold",
            lambda: no_judgement(w),
        ),
        Command(
            "threshold_down", _MENU, "Lower the threshold", "Lower the threshold of the plot by "
            "5°.", partial(w.review.move_threshold, -_STEP_DEG), "Ctrl+Alt+Down", "threshold",
            lambda: no_judgement(w),
        ),
        Command(
            "copy_statistics", _MENU, "Copy the statistics", "Copy the statistics of every limb as "
            "a table (CSV): the selection, or the whole recording, and every segment.",
            w.review.copy_statistics, "Ctrl+Alt+C", "table", lambda: no_judgement(w), section=True,
        ),
        Command(
            "save_statistics", _MENU, "Save the statistics …", "Save the statistics of every limb "
            "as a table (CSV).", w.review.ask_where_to_save_statistics, icon="save",
            why_not=lambda: no_judgement(w),
        ),
        Command(
            "save_angles", _MENU, "Save the joint angles …", "Save the joint angles of the active "
            "run with velocities, accelerations and standard deviations, frame by frame (CSV).",
            w.review.ask_where_to_save_angles, icon="save",
            why_not=lambda: no_recording(w) or w.review.why_no_angles(),
        ),
    ]  # fmt: skip
