"""The panels of annotation in the window: what they ask for is done, what they follow is told."""

from __future__ import annotations

import dataclasses

from PySide6.QtCore import QObject, Slot

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...session.runs import RunEntry
from ...widgets.camera.picture import PictureKind
from .clicking.controller import ClickController
from .filling.predicting import PredictionWork
from .panels import AnnotationPanels


class AnnotateController(QObject):
    """Connects lanes, Next, history and second readings with the document and the views."""

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
        docks.add("history", "History", panels.history_panel)
        docks.add_above_timeline(panels.bar)
        docks.add_above_views(panels.repeat_bar)
        panels.frame_requested.connect(session.document.visit)
        panels.click_requested.connect(self._on_click_wanted)
        panels.landmark_chosen.connect(annotating.choose)
        panels.repeat_changed.connect(annotating.reread)
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

    @Slot(bool)
    def _on_depth(self, wanted: bool) -> None:
        """The fit of the whole recording takes measured points where the live fit does."""
        reference = self.panels.reference
        reference.settings = dataclasses.replace(reference.settings, use_depth=wanted)

    @Slot()
    def _on_workspace(self) -> None:
        """Lanes of landmarks belong to annotating; elsewhere those of the runs need the room."""
        self.panels.set_shown(self._clicking.active)
        self._draw_reference()

    @Slot(int, str, str)
    def _on_click_wanted(self, frame: int, camera: str, landmark: str) -> None:
        """Show the frame, make the view active in which to click, and choose the landmark."""
        self._session.document.visit(frame)
        recording, views = self._session.document.recording, self._context.docks.views
        for view in recording.views if recording is not None else ():
            cameras: dict[PictureKind, str] = {"image": view.image.camera}
            if view.left is not None:
                cameras["left"] = view.left.camera
            for kind, name in cameras.items():
                if name == camera:
                    views.show_kind(view.name, kind)
                    self._context.view_state.activate(view.name)
                    views.tiles[view.name].camera.setFocus()
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
