"""Annotate: landmarks by clicks, the body fitted to them, and what helps with both."""

from dataclasses import dataclass

from ...context import Context
from ...services.layout import Workspace
from .actions import add_commands
from .clicking.actions import commands
from .clicking.controller import ClickController
from .dialogs import AnnotationDialogs
from .filling.predicting import PredictionWork
from .filling.retracking import ClickedFrames, Retracking, retrack_command
from .panels import AnnotationPanels
from .setup.personalising import Personalising, personal_command


@dataclass(frozen=True)
class Annotate:
    """Parts of the feature."""

    clicking: ClickController
    panels: AnnotationPanels
    predicting: PredictionWork
    personalising: Personalising
    dialogs: AnnotationDialogs
    retracking: Retracking


def register(context: Context) -> Annotate:
    """Offer the workspace Annotate, its panels and its commands."""
    clicking = ClickController(context)
    panels = AnnotationPanels(context, clicking)
    predicting = PredictionWork(panels)
    dialogs = AnnotationDialogs(panels)
    context.docks.add("next", "Suggested clicks", panels.next_panel)
    context.docks.add_above_timeline(panels.bar)
    context.docks.lay_over_views(panels.repeat_bar)
    context.tasks.watch(panels.settled)
    clicked = ClickedFrames(context.session)
    personalising = Personalising(context, clicked, lambda: panels.reference.settings)
    retracking = Retracking(context, clicked, clicking.body)
    space = Workspace(
        "annotate", "Annotate",
        "Click landmarks in all views. The body is fitted to the clicks as you go.", "clicks",
        side=(("landmarks",), ("body", "next", "scene")), bottom=("timeline",),
        side_share=0.26, bottom_shares=(0.24,), side_heights=(10, 14), tall_side=True,
        why_not=context.session.no_recording,
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(commands(context.session, clicking))
    add_commands(context.actions, panels, dialogs, predicting)
    context.actions.add([retrack_command(retracking), personal_command(personalising)])
    names = "annotate-detect", "annotate-personalise", "annotate-retrack"
    clicking.body.add_action_buttons([context.actions.action(name) for name in names])
    return Annotate(clicking, panels, predicting, personalising, dialogs, retracking)
