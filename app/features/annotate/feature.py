"""Annotate: landmarks by clicks, the body fitted to them, and what helps with both."""

from dataclasses import dataclass, replace
from functools import partial

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...services.layout import Workspace
from ...session.changes import Part
from ...session.runs import RunEntry
from .actions import add_commands
from .clicking.actions import commands
from .clicking.controller import ClickController
from .dialogs import AnnotationDialogs
from .exchange.predictions import PredictionExchange
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
    exchange: PredictionExchange
    retracking: Retracking


def register(context: Context) -> Annotate:
    """Offer the workspace Annotate, its panels and its commands."""
    clicking = ClickController(context)
    panels = AnnotationPanels(context, clicking)
    predicting = PredictionWork(panels)
    dialogs = AnnotationDialogs(panels)
    exchange = PredictionExchange(panels, partial(dialogs.ask_to_export, "keypoints"))
    context.docks.add("next", "Suggested clicks", panels.next_panel)
    context.docks.add_above_timeline(panels.bar)
    context.docks.lay_over_views(panels.repeat_bar)
    context.tasks.watch(panels.settled)
    _Following(panels, predicting)
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
    add_commands(context.actions, panels, dialogs, predicting, exchange.commands())
    context.actions.add([retrack_command(retracking), personal_command(personalising)])
    names = "annotate-detect", "annotate-personalise", "annotate-retrack"
    clicking.body.add_action_buttons([context.actions.action(name) for name in names])
    return Annotate(clicking, panels, predicting, personalising, exchange, retracking)


class _Following:
    """Lanes, suggested clicks and the reference follow the session."""

    def __init__(self, panels: AnnotationPanels, predicting: PredictionWork) -> None:
        session = self._session = panels.context.session
        self.panels, self._predicting, self._clicking = panels, predicting, panels.clicking
        watch = session.changes.watch
        proposals = self._clicking.proposals
        watch(Part.PROPOSALS, lambda: panels.show_proposed(proposals.ahead()))
        watch(Part.REFERENCE, self._on_reference)
        session.changes.hear(Part.EDIT, panels.follow)
        watch(Part.PROJECT_OPENED, self._on_project)
        watch(Part.PROJECT_CLOSING | Part.WINDOW_CLOSING, panels.shutdown)
        watch(Part.WORKSPACE, self._on_workspace)
        watch(Part.LENGTH, lambda: panels.set_frame_count(session.document.frame_count))
        watch(Part.FRAME, lambda: panels.set_frame(session.document.frame))
        watch(Part.ACTIVE_RUN | Part.RUNS | Part.TRACKING | Part.RUN_ENDED, self._on_run)
        watch(Part.TRUTH, self._draw_reference)
        self._clicking.body.with_depth.toggled.connect(self._on_depth)
        self._run: tuple[RunEntry, int] | None = None
        self._reference: Reference | None = None
        self._trajectory: LandmarkTrajectory | None = None
        self._on_depth(self._clicking.body.with_depth.isChecked())

    def _on_project(self) -> None:
        document, project = self._session.document, self._session.project.project
        if project is not self.panels.project:
            self.panels.set_project(project, document.recording, document.frame_count)
            self.panels.set_frame(document.frame)
            self._run = None
            self._on_run()

    def _on_run(self) -> None:
        """Compare the suggested clicks with the active run once it is finished."""
        entry = self._session.runs.active
        if entry is self._session.track.entry or (entry is not None and not entry.frames):
            entry = None
        known = (entry, len(entry.frames)) if entry is not None else None
        if known != self._run:
            self._run = known
            self.panels.next.set_run(entry.trajectory() if entry is not None else None)
            self._predicting.run = entry
            self._clicking.proposals.set_run(entry)

    def _on_depth(self, wanted: bool) -> None:
        reference = self.panels.reference
        reference.settings = replace(reference.settings, use_depth=wanted)

    def _on_workspace(self) -> None:
        """Show the lanes of landmarks in Annotate alone; elsewhere the runs need the room."""
        self.panels.set_shown(self._clicking.active)
        self._draw_reference()

    def _on_reference(self) -> None:
        now = self.panels.reference.now
        reference = now.reference if now is not None else None
        if reference is not self._reference:
            self._reference = reference
            name = now.name if now is not None else ""
            self._trajectory = reference.trajectory() if reference is not None else None
            self._session.judging.set_project_reference(name, reference)
        self._draw_reference()

    def _draw_reference(self) -> None:
        """Draw the project's reference while annotating; else what errors are measured against."""
        truth = self._session.judging.truth
        recorded = truth is not None and truth.against == "recording"
        drawn = self._trajectory if self._clicking.active or not recorded else None
        now = self.panels.reference.now
        clicks = None if now is None or drawn is None else now.clicks
        self._session.instant.show_reference(drawn, clicks)
