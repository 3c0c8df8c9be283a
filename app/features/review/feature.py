"""Review: where a run fails, and why."""

from __future__ import annotations

from dataclasses import dataclass

from ...context import Context
from ...services.layout import Workspace
from .actions import commands, failure_commands
from .controller import ReviewController
from .episodes.controller import EpisodeController
from .plot import ErrorCurves


@dataclass(frozen=True)
class Review:
    """What reviewing consists of.

    Attributes
    ----------
    plot : ErrorCurves
    episodes : EpisodeController
    panels : ReviewController
        Statistics, explanations and joint angles.
    """

    plot: ErrorCurves
    episodes: EpisodeController
    panels: ReviewController


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
    context.actions.add(commands(context.session, review.panels, review.plot))
    context.actions.add(failure_commands(review.episodes))
    review.panels.add_buttons()
    return review
