"""Annotate: landmarks by clicks, the body fitted to them, and what helps with both."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

from PySide6.QtCore import QObject, Slot

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...services.layout import Workspace
from ...session.runs import RunEntry
from .actions import add_commands
from .clicking.actions import commands
from .clicking.clicked_frames import ClickedFrames
from .clicking.controller import ClickController
from .dialogs import AnnotationDialogs
from .exchange.predictions import PredictionExchange
from .filling.predicting import PredictionWork
from .filling.retracking import Retracking, retrack_command
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
    _AnnotateController(context, panels, predicting)
    clicked = ClickedFrames(context.session.project)
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


class _AnnotateController(QObject):
    """Connects lanes, suggested clicks and the reference with the session."""

    def __init__(
        self, context: Context, panels: AnnotationPanels, predicting: PredictionWork
    ) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self.panels, self._predicting, self._clicking = panels, predicting, panels.clicking
        session, docks = context.session, context.docks
        docks.add("next", "Suggested clicks", panels.next_panel)
        docks.add_above_timeline(panels.bar)
        docks.lay_over_views(panels.repeat_bar)
        self._clicking.proposals.changed.connect(self._on_proposals)
        panels.reference_changed.connect(self._on_reference)
        session.project.changed.connect(panels.follow)
        session.project.opened.connect(self._on_project)
        session.project.closing.connect(panels.shutdown)
        docks.workspace_changed.connect(self._on_workspace)
        session.document.count_changed.connect(panels.set_frame_count)
        session.document.frame_changed.connect(panels.set_frame)
        for changed in (
            session.runs.active_changed, session.runs.changed, session.track.state_changed,
            session.track.finished,
        ):  # fmt: skip
            changed.connect(self._on_run)
        self._clicking.body.with_depth.toggled.connect(self._on_depth)
        session.judging.truth_changed.connect(self._draw_reference)
        session.instant.is_old = panels.reference.is_old
        panels.reference.aged.connect(self._on_aged)
        session.closing.connect(panels.shutdown)
        context.tasks.watch(panels.settled)
        self._run: tuple[RunEntry, int] | None = None
        self._reference: Reference | None = None
        self._trajectory: LandmarkTrajectory | None = None
        self._on_depth(self._clicking.body.with_depth.isChecked())

    @Slot()
    def _on_project(self) -> None:
        document, project = self._session.document, self._session.project.project
        if project is not self.panels.project:
            self.panels.set_project(project, document.recording, document.frame_count)
            self.panels.set_frame(document.frame)
            self._run = None
            self._on_run()

    @Slot()
    def _on_run(self, _what: object = None) -> None:
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

    @Slot()
    def _on_proposals(self) -> None:
        self.panels.show_proposed(self._clicking.proposals.ahead())

    @Slot(bool)
    def _on_depth(self, wanted: bool) -> None:
        reference = self.panels.reference
        reference.settings = replace(reference.settings, use_depth=wanted)

    @Slot()
    def _on_workspace(self) -> None:
        """Show the lanes of landmarks in Annotate alone; elsewhere the runs need the room."""
        self.panels.set_shown(self._clicking.active)
        self._draw_reference()

    @Slot()
    def _on_reference(self) -> None:
        now = self.panels.reference.now
        reference = now.reference if now is not None else None
        if reference is not self._reference:
            self._reference = reference
            name = now.name if now is not None else ""
            self._trajectory = reference.trajectory() if reference is not None else None
            self._session.judging.set_project_reference(name, reference)
        self._draw_reference()

    @Slot()
    def _draw_reference(self) -> None:
        """Draw the project's reference while annotating; else what errors are measured against."""
        truth = self._session.judging.truth
        recorded = truth is not None and truth.against == "recording"
        drawn = self._trajectory if self._clicking.active or not recorded else None
        if drawn is not self._session.instant.reference:
            self._session.instant.reference = drawn
            self._session.instant.tell_soon()

    @Slot()
    def _on_aged(self) -> None:
        """Draw the project's reference as old where it is, and no longer where it is not."""
        told = self._session.instant.told
        if told is not None:
            old = self.panels.reference.is_old(told.frame_set.index)
            if old is not told.reference_is_old:
                self._session.instant.tell_soon()
