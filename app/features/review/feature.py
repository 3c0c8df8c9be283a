"""Review: where a run fails, and why."""

from dataclasses import dataclass
from functools import partial

from ...context import Context
from ...services.actions import Command, Menu
from ...services.layout import Workspace
from ...session.session import Session
from .failures import FailureController
from .plot import ErrorCurves

_STEP_DEG = 5.0


@dataclass(frozen=True)
class Review:
    """What reviewing consists of."""

    plot: ErrorCurves
    failures: FailureController


def register(context: Context) -> Review:
    """Offer the workspace Review, its panels and its commands."""
    review = Review(ErrorCurves(context), FailureController(context))
    session = context.session
    space = Workspace(
        "review", "Review", "Find and understand the failures of a run.", "threshold",
        side=(("scene",), ("failures", "comparison", "numbers", "runs")),
        bottom=("plot", "timeline"), side_share=0.37, bottom_shares=(0.27, 0.16),
        side_heights=(1, 2), tall_side=True,
        why_not=lambda: session.no_run() and session.not_tracked(),
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(session, review.plot, review.failures))
    return review


def _commands(session: Session, plot: ErrorCurves, e: FailureController) -> list[Command]:
    go, command = Menu("&Go", session.no_run).command, Menu("&Review", session.no_run).command
    failure = Menu("&Go", e.none_listed).command
    stretch = "stretch in which the error of a limb exceeds the threshold of the plot."
    return [
        go("next_above", "Next stretch above threshold", f"Go to the next {stretch}",
           partial(plot.go_above, 1), "N", "next-failure", section=True),
        go("previous_above", "Previous stretch above threshold", f"Go to the previous {stretch}",
           partial(plot.go_above, -1), "P", "previous-failure"),
        command("threshold_up", "Raise threshold", "Raise the threshold of the plot by 5°.",
                partial(plot.move_threshold, _STEP_DEG), "Ctrl+Alt+Up", "threshold"),
        command("threshold_down", "Lower threshold", "Lower the threshold of the plot by 5°.",
                partial(plot.move_threshold, -_STEP_DEG), "Ctrl+Alt+Down", "threshold"),
        failure("next_failure", "Next failure", "Go to the worst frame of the next listed failure "
                "of the active run.", partial(e.go, 1), "Shift+N", "next-failure", section=True),
        failure("previous_failure", "Previous failure", "Go to the worst frame of the previous "
                "listed failure.", partial(e.go, -1), "Shift+P", "previous-failure"),
        failure("loop_failure", "Loop failure", "Play the selected failure in a loop, with a few "
                "frames before and after it.", e.toggle_loop, "Shift+Space", "iterate",
                checked=e.looping),
    ]  # fmt: skip
