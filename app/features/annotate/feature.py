"""Annotate: landmarks by clicks, the body fitted to them, and what helps with both."""

from __future__ import annotations

from dataclasses import dataclass

from ...context import Context
from ...services.layout import Workspace
from .actions import add_commands
from .clicking.actions import commands
from .clicking.controller import ClickController
from .controller import AnnotateController
from .dialogs import AnnotationDialogs
from .filling.predicting import PredictionWork
from .panels import AnnotationPanels


@dataclass(frozen=True)
class Annotate:
    """What annotating consists of.

    Attributes
    ----------
    clicking : ClickController
        Clicks in the views.
    panels : AnnotationPanels
        Lanes, what is next, history, second readings and fits.
    predicting : PredictionWork
        Predictions over a selection.
    """

    clicking: ClickController
    panels: AnnotationPanels
    predicting: PredictionWork


def register(context: Context) -> Annotate:
    """Offer the workspace Annotate, its panels and its commands."""
    docks = context.docks
    panels = AnnotationPanels(docks.timeline, context.tasks, docks.dialog_parent)
    clicking = ClickController(context, lambda: panels.repeats)
    predicting, dialogs = PredictionWork(panels), AnnotationDialogs(panels)
    AnnotateController(context, panels, predicting, clicking)
    context.docks.add_workspace(
        Workspace(
            "annotate",
            "Annotate",
            "Click landmarks in all views. The body is fitted to the clicks as you go.",
            "clicks",
            side=(("landmarks",), ("body", "next", "history", "scene")),
            bottom=("timeline",),
            side_share=0.26,
            bottom_heights=(230,),
            side_heights=(11, 10),
            why_not=context.session.no_recording,
        )
    )
    context.actions.add(commands(context.session, clicking))
    add_commands(context.actions, panels, dialogs, predicting)
    return Annotate(clicking, panels, predicting)
