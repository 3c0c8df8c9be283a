"""Annotate: landmarks by clicks, the body fitted to them, and what helps with both."""

from __future__ import annotations

from dataclasses import dataclass, replace

from PySide6.QtCore import QObject, Slot

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.recording.description import Stream
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...services.layout import Workspace
from ...session.runs import RunEntry
from ...widgets.camera.picture import PictureKind
from .actions import add_commands
from .clicking.actions import commands
from .clicking.clicked_frames import ClickedFrames
from .clicking.controller import ClickController
from .dialogs import AnnotationDialogs
from .exchange.predictions import PredictionExchange
from .filling.predicting import PredictionWork
from .filling.retracking import Retracking, retrack_commands
from .panels import AnnotationPanels
from .setup.personalising import Personalising, personal_commands


@dataclass(frozen=True)
class Annotate:
    """What annotating consists of."""

    clicking: ClickController
    """Clicks in the views."""
    panels: AnnotationPanels
    """Lanes, what is next, second readings and fits."""
    predicting: PredictionWork
    """Predictions over a selection."""
    personalising: Personalising
    """The subject's offsets by a few clicked frames."""
    exchange: PredictionExchange
    """Predictions of detectors from files."""
    retracking: Retracking
    """Failures of a run that are tracked again with clicks."""


def register(context: Context) -> Annotate:
    """Offer the workspace Annotate, its panels and its commands."""
    docks = context.docks
    panels = AnnotationPanels(
        docks.timeline, context.tasks, context.session.edits, docks.dialog_parent
    )
    clicking = ClickController(context, lambda: panels.repeats)
    predicting = PredictionWork(panels, context.session.keypoints)
    dialogs = AnnotationDialogs(panels)
    exchange = PredictionExchange(context, panels, dialogs.ask_to_export_predictions)
    _AnnotateController(context, panels, predicting, clicking)
    clicked = ClickedFrames(context.session.project, context.session)
    personalising = Personalising(context, clicked, lambda: panels.reference.settings)
    retracking = Retracking(context, clicked)
    context.docks.add_workspace(
        Workspace(
            "annotate",
            "Annotate",
            "Click landmarks in all views. The body is fitted to the clicks as you go.",
            "clicks",
            side=(("landmarks",), ("body", "next", "scene")),
            bottom=("timeline",),
            side_share=0.26,
            bottom_shares=(0.24,),
            side_heights=(10, 14),
            tall_side=True,
            why_not=context.session.no_recording,
        )
    )
    context.actions.add(commands(context.session, clicking))
    add_commands(context.actions, panels, dialogs, predicting, exchange.commands())
    context.actions.add(retrack_commands(retracking))
    context.actions.add(personal_commands(personalising))
    _offer_in_body(context, clicking, retracking)
    return Annotate(clicking, panels, predicting, personalising, exchange, retracking)


def _offer_in_body(context: Context, clicking: ClickController, retracking: Retracking) -> None:
    """Offer below the body fit what can be done without clicks and with them."""
    names = "annotate-detect", "annotate-personalise", "annotate-retrack"
    clicking.body.add_action_buttons([context.actions.action(name) for name in names])

    def show() -> None:
        clicking.body.show_hint(retracking.hint())
        context.actions.refresh_soon()

    retracking.changed.connect(show)


class _AnnotateController(QObject):
    """Connects lanes, Next and second readings with the document and the views."""

    def __init__(
        self,
        context: Context,
        panels: AnnotationPanels,
        predicting: PredictionWork,
        clicking: ClickController,
    ) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self.panels, self._predicting, self._clicking = panels, predicting, clicking
        session, docks, annotating = context.session, context.docks, clicking.annotating
        docks.add("next", "Suggested clicks", panels.next_panel)
        docks.add_above_timeline(panels.bar)
        docks.lay_over_views(panels.repeat_bar)
        panels.frame_requested.connect(session.document.visit)
        panels.click_requested.connect(self._on_click_wanted)
        panels.landmark_chosen.connect(annotating.choose)
        panels.repeat_changed.connect(annotating.reread)
        clicking.proposals.changed.connect(self._on_proposals)
        clicking.proposals.ahead_changed.connect(self._on_proposals)
        predicting.found.connect(panels.read_kept)
        panels.reference_changed.connect(self._on_reference)
        panels.said.connect(context.notifier.say)
        panels.message.connect(context.notifier.show)
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
        clicking.body.with_depth.toggled.connect(self._on_depth)
        session.judging.truth_changed.connect(self._draw_reference)
        session.instant.is_old = panels.reference.is_old
        panels.reference.aged.connect(self._on_aged)
        session.closing.connect(panels.shutdown)
        context.tasks.watch(panels.settled)
        self._run: tuple[RunEntry, int] | None = None
        self._reference: Reference | None = None
        self._trajectory: LandmarkTrajectory | None = None
        self._on_depth(clicking.body.with_depth.isChecked())

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
        """Let Next look at where the active run disagrees; one that still grows is not told."""
        panels, entry = self.panels, self._session.runs.active
        finished = (
            entry is not None and entry is not self._session.track.entry and bool(entry.frames)
        )
        known = (entry, len(entry.frames)) if entry is not None and finished else None
        if known != self._run:
            self._run = known
            panels.next.set_run(known[0].trajectory() if known is not None else None)
            self._predicting.set_run(known[0] if known is not None else None)
            self._clicking.proposals.set_run(known[0] if known is not None else None)

    @Slot()
    def _on_proposals(self) -> None:
        """Hatch in the lanes what is proposed for this frame and the next one."""
        self.panels.show_proposed(self._clicking.proposals.ahead())

    @Slot(bool)
    def _on_depth(self, wanted: bool) -> None:
        """The fit of the whole recording takes measured points where the live fit does."""
        reference = self.panels.reference
        reference.settings = replace(reference.settings, use_depth=wanted)

    @Slot()
    def _on_workspace(self) -> None:
        """Lanes of landmarks belong to annotating; elsewhere those of the runs need the room."""
        self.panels.set_shown(self._clicking.active)
        self._draw_reference()

    @Slot(int, str, str)
    def _on_click_wanted(self, frame: int, camera: str, landmark: str) -> None:
        """Show the frame, make the view active in which to click, and choose the landmark."""
        self._session.document.visit(frame)
        recording, state = self._session.document.recording, self._context.view_state
        for view in recording.views if recording is not None else ():
            streams: dict[PictureKind, Stream | None] = {"image": view.image, "left": view.left}
            for kind, stream in streams.items():
                if stream is not None and stream.camera == camera:
                    state.choose_kind(kind, view.name)
                    state.activate(view.name)
                    self._context.docks.views.tiles[view.name].camera.setFocus()
        self._clicking.annotating.choose(landmark)

    @Slot()
    def _on_reference(self) -> None:
        """Errors can be measured against the project's reference, where it has one."""
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
