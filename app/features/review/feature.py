"""Review: where a run fails, and why."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ...context import Context
from ...services.actions import Command
from ...services.layout import Workspace
from ...session.session import Session
from .controller import ReviewController
from .episodes import EpisodeController
from .plot import ErrorCurves

_MENU, _GO, _TRACK = "&Review", "&Go", "&Track/&Failures"
_STEP_DEG = 5.0


@dataclass(frozen=True)
class Review:
    """What reviewing consists of."""

    plot: ErrorCurves
    episodes: EpisodeController
    panels: ReviewController
    """Statistics, explanations and joint angles."""


def register(context: Context) -> Review:
    """Offer the workspace Review, its panels and its commands."""
    review = Review(ErrorCurves(context), EpisodeController(context), ReviewController(context))
    context.docks.add_workspace(
        Workspace(
            "review",
            "Review",
            "Find and understand the failures of a run.",
            "threshold",
            side=(
                ("scene",),
                ("episodes", "statistics", "numbers", "comparison", "motion", "runs"),
            ),
            bottom=(("plot", "explanations", "angles"), "timeline"),
            side_share=0.37,
            bottom_heights=(260, 155),
            side_heights=(1, 2),
            tall_side=True,
            why_not=context.session.no_depth,
        )
    )
    context.actions.add(_commands(context.session, review.panels, review.plot))
    context.actions.add(_failure_commands(review.episodes))
    review.panels.add_buttons()
    return review


def _commands(session: Session, review: ReviewController, plot: ErrorCurves) -> list[Command]:
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
            partial(review.ask_where, "Save statistics", "statistics.csv", review.save_statistics),
            icon="save", why_not=session.no_run,
        ),
        Command(
            "save_angles", _MENU, "Save joint angles …",
            "Save the joint angles of the active run frame by frame, with velocities, "
            "accelerations and standard deviations, as CSV.",
            partial(review.ask_where, "Save joint angles", "angles.csv", review.save_angles),
            icon="save", why_not=lambda: session.no_recording() or review.why_no_angles(),
        ),
    ]  # fmt: skip


def _failure_commands(e: EpisodeController) -> list[Command]:
    """Commands of the menus Go and Track, Failures."""
    return [
        Command(
            "next_episode", _GO, "Next failure",
            "Go to the worst frame of the next listed failure of the active run.",
            lambda: e.go(1), "Shift+N", "next-episode", e.none_listed, section=True,
        ),
        Command(
            "previous_episode", _GO, "Previous failure",
            "Go to the worst frame of the previous listed failure.",
            lambda: e.go(-1), "Shift+P", "previous-episode", e.none_listed,
        ),
        Command(
            "loop_episode", _GO, "Loop failure",
            "Play the selected failure in a loop, with a few frames before and after it.",
            e.toggle_loop, "Shift+Space", "iterate", e.none_listed, e.looping,
        ),
        Command(
            "export_strips", _TRACK, "Export image strips …",
            "Save the frames of each failure side by side, with the model drawn in the lower row, "
            "as PNG.",
            lambda: e.export(video=False), "", "picture", e.none_listed,
        ),
        Command(
            "export_film", _TRACK, "Video …",
            "Save a video of the failures: all views with the model outline and the errors.",
            lambda: e.export(video=True), "", "export", e.none_listed,
        ),
    ]  # fmt: skip
