"""The panels of annotation in the window: what they ask for is done, what they follow is told."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Slot

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...session.runs import RunEntry
from ...session.truth import Against
from ...widgets.camera.picture import PictureKind

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_AGAINST = "errors_against"


class AnnotationWork(QObject):
    """Connects lanes, Next, history and second readings with the document and the views."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = window
        panels = window.annotation
        panels.frame_requested.connect(self._go_to)
        panels.click_requested.connect(self._on_click_wanted)
        panels.landmark_chosen.connect(window.annotate.annotating.choose)
        panels.repeat_changed.connect(window.annotate.annotating.reread)
        panels.reference_changed.connect(self._on_reference)
        panels.said.connect(self._say)
        panels.message.connect(window.messages.show_message)
        window.project.opened.connect(self._on_project)
        window.project.closing.connect(panels.shutdown)
        window.spaces.changed.connect(self._on_workspace)
        window.document.count_changed.connect(panels.set_frame_count)
        window.document.frame_changed.connect(panels.set_frame)
        window.runs.active_changed.connect(self._on_run)
        window.runs.changed.connect(self._on_run)
        window.track.state_changed.connect(self._on_run)
        window.track.finished.connect(self._on_run)
        window.body_panel.with_depth.toggled.connect(self._on_depth)
        window.judging.truth_changed.connect(self._draw_reference)
        self._run: tuple[RunEntry, int] | None = None
        self._reference: Reference | None = None
        self._trajectory: LandmarkTrajectory | None = None
        self._on_depth(window.body_panel.with_depth.isChecked())

    @Slot()
    def _on_project(self) -> None:
        document, project = self._w.document, self._w.project.project
        if project is not self._w.annotation.project:
            self._w.annotation.set_project(project, document.recording, document.frame_count)
            self._w.annotation.set_frame(document.frame)
            self._run = None
            self._on_run()
            stored = project.view_settings.get(_AGAINST) if project is not None else None
            wanted: Against | None = "project" if stored == "project" else None
            self._w.judging.judge_against(wanted)

    @Slot()
    def _on_run(self, _what: object = None) -> None:
        """Let Next look at where the active run disagrees; one that still grows is not told."""
        panels, entry = self._w.annotation, self._w.runs.active
        finished = entry is not None and entry is not self._w.track.entry and bool(entry.frames)
        known = (entry, len(entry.frames)) if entry is not None and finished else None
        if known != self._run:
            self._run = known
            panels.next.set_run(known[0].trajectory() if known is not None else None)
            panels.predicting.set_run(known[0] if known is not None else None)

    @Slot(bool)
    def _on_depth(self, wanted: bool) -> None:
        """The fit of the whole recording takes measured points where the live fit does."""
        reference = self._w.annotation.reference
        reference.settings = dataclasses.replace(reference.settings, use_depth=wanted)

    @Slot()
    def _on_workspace(self) -> None:
        """Lanes of landmarks belong to annotating; elsewhere those of the runs need the room."""
        self._w.annotation.set_shown(self._w.annotate.active)
        self._draw_reference()

    @Slot(int)
    def _go_to(self, frame: int) -> None:
        self._w.document.pause()
        self._w.document.go_to(frame)

    @Slot(int, str, str)
    def _on_click_wanted(self, frame: int, camera: str, landmark: str) -> None:
        """Show the frame, make the view active in which to click, and choose the landmark."""
        self._go_to(frame)
        w = self._w
        for view in w.views():
            cameras: dict[PictureKind, str] = {"image": view.image.camera}
            if view.left is not None:
                cameras["left"] = view.left.camera
            for kind, name in cameras.items():
                if name == camera:
                    w.grid.show_kind(view.name, kind)
                    w.grid.set_active(view.name)
                    w.grid.tiles[view.name].camera.setFocus()
        w.annotate.annotating.choose(landmark)

    @Slot()
    def _on_reference(self) -> None:
        """Errors can be measured against the project's reference, where it has one."""
        now = self._w.annotation.reference.now
        reference = now.reference if now is not None else None
        if reference is not self._reference:
            self._reference = reference
            name = now.name if now is not None else ""
            self._trajectory = reference.trajectory() if reference is not None else None
            self._w.judging.set_project_reference(name, reference)
        self._draw_reference()

    @Slot()
    def _draw_reference(self) -> None:
        """Draw the project's reference while annotating; else what errors are measured against."""
        truth = self._w.judging.truth
        recorded = truth is not None and truth.against == "recording"
        drawn = self._trajectory if self._w.annotate.active or not recorded else None
        if drawn is not self._w.instant.reference:
            self._w.instant.reference = drawn
            self._w.instant.tell_soon()

    def judge_against(self, against: Against) -> None:
        """Measure errors of runs against another reference, and keep that with the project."""
        project = self._w.annotation.project
        if project is not None and not project.read_only:
            project.view_settings.set(_AGAINST, against)
        self._w.judging.judge_against(against)
        self._w.refresh_soon()

    @Slot(str)
    def _say(self, words: str) -> None:
        self._w.statusBar().showMessage(words, 6000)
