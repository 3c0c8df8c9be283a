"""Everything of annotation around the views: lanes, what is next, trust."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QDialog, QSizePolicy, QWidget

from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.blind_repeats import BlindRepeats
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...session.changes import Part
from ...session.jobs import Job
from ...session.runs import RunEntry
from ...session.session import unless
from ...widgets.forms.message import StateBar
from ...widgets.style.building import hbox, label, menu_of, thin_progress, tool_button
from ...widgets.style.theme import current_theme
from ...widgets.tables.landmarks_panel import NextPanel
from .clicking.controller import ClickController
from .filling.reference_work import ReferenceWork
from .lanes import AnnotationLanes
from .next_clicks import NextPresenter, Ranking

_GROUP = "annotation"
_OF_PROJECT = "of_project"  # property of dialogs that close with the project
_DELAY_MS = 40
_COUNTING_MS = 250
_REFIT_MS = 1500  # after an edit, for suggestions by the clicked frames
_MANY_FRAMES = 300


class AnnotationBar(QWidget):
    """One row over the timeline."""

    def __init__(self) -> None:
        super().__init__()
        self.strip = thin_progress()
        self.strip.setRange(0, 1000)
        self.strip.setFixedSize(72, 6)
        self.progress = label(wraps=False)
        self.previous_button = tool_button(
            "Previous frame with a flag", "previous-failure", role="plain"
        )
        self.next_button = tool_button("Next frame with a flag", "next-failure", role="plain")
        self.selection_words = label("", "muted", wraps=False)
        self.selection_words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.selection_words.setAlignment(
            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        )
        tip = "Actions on the selected frames"
        self.selection_button = tool_button(tip, "selection", "Selection ▾", "plain")
        self.selection_button.setAccessibleName(tip)
        self.selection_menu = menu_of(self.selection_button)
        left = (self.strip, self.progress, self.previous_button, self.next_button)
        right = ((self.selection_words, 1), self.selection_button)
        self.setLayout(hbox(*left, *right, margins=(8, 1, 8, 1), spacing=6))
        self.setAccessibleName("Annotation")
        self.hide()

    def show_progress(self, words: str, share: float, *, flagged: bool) -> None:
        """Say how far the annotation is; `share` is that of the keyframes that are done."""
        self.progress.setText(words)
        self.strip.setValue(round(1000 * share))
        colours, theme = self.strip.palette(), current_theme()
        colour = theme.good if share >= 1.0 else theme.accent
        colours.setColor(QPalette.ColorRole.Highlight, QColor(colour))
        self.strip.setPalette(colours)
        for button in (self.previous_button, self.next_button):
            button.setEnabled(flagged)

    def show_selection(self, words: str) -> None:
        self.selection_words.setText(words)
        self.selection_words.setToolTip(
            f"{words}\nCommands act on this selection. Drag in the ruler to select frames, "
            "Ctrl+click on names to select landmarks."
        )


class AnnotationPanels:
    """The panels of annotation and what stands behind them; they follow the session's project."""

    def __init__(self, context: Context, clicking: ClickController) -> None:
        self.context, self.clicking = context, clicking
        self.timeline, self.window = context.docks.timeline, context.docks.dialog_parent
        self.say = context.notifier.say
        self.project: Project | None = None
        self.recording: Recording | None = None
        self.frame_count, self.frame = 0, 0
        self._shown = True
        self.bar = AnnotationBar()
        self.next_panel = NextPanel(clicking.go_to, lambda: self.say("No click is suggested here."))
        tip = "Finish the blind repeat; both passes are kept in the project"
        self.repeat_bar = StateBar("Blind repeat", "Finish and show", tip)
        self.lanes: AnnotationLanes | None = None
        self._proposed: Mapping[int, Collection[str]] = {}
        self._kept: Mapping[int, Collection[str]] = {}
        self.next = NextPresenter(context.tasks, self._on_ranked)
        self.reference = ReferenceWork(context.tasks, self._on_reference, self._show_reference)
        context.session.losses.append(self.reference.lost_words)
        self._run: tuple[RunEntry, int] | None = None
        self._judged: Reference | None = None
        self._trajectory: LandmarkTrajectory | None = None
        self._back_to: int | None = None
        self._by_clicked = False
        self._refit = context.session.later(self._on_fit_wanted, _REFIT_MS)
        self._soon = context.session.later(self._show_numbers, _DELAY_MS)
        self._counted = context.session.later(self._on_counted, _COUNTING_MS)
        self._connect()
        self._follow_session()

    def _connect(self) -> None:
        self.timeline.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.timeline.customContextMenuRequested.connect(self._on_menu)
        self.timeline.selection_changed.connect(self._show_selection)
        self.timeline.lanes_selected.connect(self._show_selection)
        self.timeline.lane_clicked.connect(self.clicking.annotating.choose)
        self.bar.previous_button.clicked.connect(partial(self.go_to_flagged, True))
        self.bar.next_button.clicked.connect(partial(self.go_to_flagged, False))
        panel = self.next_panel
        panel.wanted.valueChanged.connect(self.next.set_wanted)
        panel.fit_button.clicked.connect(self._on_fit_wanted)
        self.repeat_bar.button.clicked.connect(self.finish_repeat)

    # ---- the session

    def _follow_session(self) -> None:
        session, clicking = self.context.session, self.clicking
        document, watch = session.document, session.changes.watch
        watch(Part.PROPOSALS, lambda: self.show_proposed(clicking.proposals.ahead()))
        session.changes.hear(Part.EDIT, self.follow)
        watch(Part.PROJECT_OPENED, self._on_project)
        watch(Part.PROJECT_CLOSING | Part.WINDOW_CLOSING, self.shutdown)
        watch(Part.WORKSPACE, self._on_workspace)
        watch(Part.LENGTH, lambda: self.set_frame_count(document.frame_count))
        watch(Part.FRAME, lambda: self.set_frame(document.frame))
        watch(Part.ACTIVE_RUN | Part.RUNS | Part.TRACKING | Part.RUN_ENDED, self._on_run)
        watch(Part.TRUTH, self._draw_reference)
        watch(Part.KEYPOINTS, self.read_kept)
        clicking.body.with_depth.toggled.connect(self._on_depth)
        self._on_depth(clicking.body.with_depth.isChecked())

    def _on_project(self) -> None:
        document, project = self.context.session.document, self.context.session.project.project
        if project is not self.project:
            self.set_project(project, document.recording, document.frame_count)
            self.set_frame(document.frame)
            self._run = None
            self._on_run()

    def _on_run(self) -> None:
        """Compare the suggested clicks with the active run once it is finished."""
        entry = self.context.session.finished_run
        known = (entry, len(entry.frames)) if entry is not None else None
        if known != self._run:
            self._run = known
            self.next.set_run(entry.trajectory() if entry is not None else None)

    def _on_depth(self, wanted: bool) -> None:
        self.reference.settings = replace(self.reference.settings, use_depth=wanted)

    def _on_workspace(self) -> None:
        """Show the lanes of landmarks in Annotate alone; elsewhere the runs need the room."""
        if self.clicking.active != self._shown:
            self._shown = self.clicking.active
            self._show_bar()
            self._show_lanes()
        self._draw_reference()

    # ---- the project

    def set_project(
        self, project: Project | None, recording: Recording | None, frame_count: int
    ) -> None:
        """Follow another project, or none; the one before may be closed afterwards."""
        for dialog in self.window.findChildren(QDialog):
            if dialog.property(_OF_PROJECT):
                dialog.close()
        self._refit.stop()
        self.project = project if recording is not None else None
        self.recording, self.frame_count = recording, frame_count
        self._back_to = None
        self.next.set_project(self.project, click_cameras(recording))
        self.next_panel.show_wanted(self.next.wanted_deg)
        self._make_lanes()
        self.reference.set_project(self.project, recording, frame_count)
        self._show_bar()
        self._show_selection()
        self._show_numbers()
        self._tell_repeat()

    def show_dialog(self, dialog: QDialog) -> None:
        """Show a dialog until it or the project is closed; the window stays usable."""
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setProperty(_OF_PROJECT, True)
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()

    def _show_bar(self) -> None:
        self.bar.setVisible(self._shown and self.project is not None)

    def set_frame_count(self, frame_count: int) -> None:
        if frame_count != self.frame_count:
            self.frame_count = frame_count
            # while frames are being counted this is called again and again
            self._counted.start(_COUNTING_MS if self.lanes is not None else 0)

    def _on_counted(self) -> None:
        self._make_lanes()
        self.reference.set_frame_count(self.frame_count)

    def set_frame(self, frame: int) -> None:
        self.frame, self.next_panel.awaited = frame, False
        if self.timeline.selection is None:
            self._show_selection()

    def settled(self) -> bool:
        timers = (self._soon, self._counted, self._refit)
        waiting = any(timer.isActive() for timer in timers)
        return not waiting and self.next.idle and not self.reference.fitting

    def shutdown(self) -> None:
        self.set_project(None, None, 0)

    def _make_lanes(self) -> None:
        project, recording = self.project, self.recording
        self.lanes = None
        if project is not None and recording is not None and self.frame_count:
            cameras = len(click_cameras(recording))
            self.lanes = AnnotationLanes(project, self.frame_count, cameras)
            self._dress_lanes()
        self._read_kept()
        self._show_lanes()

    # ---- edits

    def no_project(self) -> str:
        return unless(self.project, "No project is open. Open or create one first.")

    def no_edit(self) -> str:
        if self.project is not None and self.project.read_only:
            return "The project is open read-only."
        return self.no_project()

    def edit_selection(
        self, make: Callable[[Project, Selection], Edit], chosen: Selection | None = None
    ) -> None:
        """Make an edit of what is selected; in the background where that is a lot."""
        project, chosen = self.project, chosen or self.selection()
        if project is None:
            return
        if len(chosen.frames) > _MANY_FRAMES:
            job = Job("editing", lambda _: project.apply(make(project, chosen)), self._on_done)
            self.context.tasks.write(job)
        else:
            self.context.notifier.attempt(
                lambda: self._on_done(project.apply(make(project, chosen)))
            )

    def _on_done(self, changed: Changed | None) -> None:
        self.say(f"Done: {changed.words}." if changed is not None else "Nothing to change.")

    def follow(self, changed: Changed) -> None:
        if self.project is None:
            return
        self._soon.start()  # first, so that numbers are right whatever fails below
        if self.lanes is not None and self.lanes.follow(changed):
            self._show_lanes()
        self.reference.follow(changed)
        self.next.follow(changed)
        if "click" in changed.tables:
            if self._by_clicked:
                self._refit.start()
            self.next_panel.awaited = False  # who goes on clicking stays where they are
        if "repeat_click" in changed.tables:
            self._tell_repeat()

    def _show_numbers(self) -> None:
        if self.project is not None:
            progress = self.project.progress()
            flagged = self.lanes is not None and bool(len(self.lanes.flagged_frames()))
            self.bar.show_progress(progress.words(), progress.share, flagged=flagged)

    # ---- selection and lanes

    def selection(self) -> Selection:
        landmarks = self.lanes.landmark_set.names if self.lanes is not None else ()
        lanes = self.timeline.selected_lanes
        return Selection(
            self.timeline.selection or range(self.frame, self.frame + 1),
            tuple(name for name in landmarks if name in lanes),
        )

    def _show_selection(self) -> None:
        self.bar.show_selection(self.selection().words() if self.project is not None else "")

    def read_kept(self) -> None:
        self._read_kept()
        self.clicking.annotating.reread()

    def _read_kept(self) -> None:
        self._kept = self.project.predictions.places() if self.project is not None else {}
        self.show_proposed(self._proposed)

    def show_proposed(self, proposed: Mapping[int, Collection[str]]) -> None:
        """Hatch in the lanes the landmarks, by frame, that are proposed or kept as predictions."""
        self._proposed, kept = proposed, self._kept
        every = {k: {*kept.get(k, ()), *proposed.get(k, ())} for k in {*kept, *proposed}}
        if self.lanes is not None and self.lanes.show_proposed(every):
            self._show_lanes()

    def _show_lanes(self) -> None:
        lanes = self.lanes if self._shown else None
        self.timeline.set_lanes(lanes.lanes() if lanes is not None else (), _GROUP)

    def _on_menu(self, place: QPoint) -> None:
        if self.project is not None:
            self.bar.selection_menu.popup(self.timeline.mapToGlobal(place))

    def go_to_flagged(self, backwards: bool = False) -> None:
        """Go to the next (previous) frame in which a landmark is flagged."""
        lanes = self.lanes
        found = None if lanes is None else lanes.next_flagged(self.frame, backwards=backwards)
        if found is not None:
            self.context.session.document.visit(found)
        else:
            self.say(f"No frame {'before' if backwards else 'after'} this one has a flag.")

    # ---- fit, following, what is next

    def _on_fit_wanted(self) -> None:
        """Fit the clicked frames, as suggestions need it; or say why there can be none."""
        if self.reference.why_not() or self.project is None:
            self.say(self.reference.why_not())
        elif not self.project.clicks.count():
            self.say("Suggested clicks need a fit. Click at least three landmarks first.")
        else:
            self.reference.fit_clicked(self._suggest_by)

    def _suggest_by(self, fit: TrajectoryFit | None) -> None:
        """Suggest clicks by a fit of the clicked frames, until the whole recording is fitted."""
        self._by_clicked = fit is not None
        self.next.set_fit(fit)

    def _on_reference(self) -> None:
        now, self._by_clicked = self.reference.now, False
        self._dress_lanes()
        self._show_lanes()
        self.next.set_fit(now.fit if now is not None else None)
        if now is not None:
            self.say(now.words)
        self._show_reference()
        self.context.actions.refresh()

    def _show_reference(self) -> None:
        """Judge runs by the project's reference if that is another one, and draw it."""
        now = self.reference.now
        reference = now.reference if now is not None else None
        if reference is not self._judged:
            self._judged = reference
            name = now.name if now is not None else ""
            self._trajectory = reference.trajectory() if reference is not None else None
            self.context.session.judging.set_project_reference(name, reference)
        self._draw_reference()

    def _draw_reference(self) -> None:
        """Draw the project's reference while annotating; else what errors are measured against."""
        session, now = self.context.session, self.reference.now
        truth = session.judging.truth
        recorded = truth is not None and truth.against == "recording"
        drawn = self._trajectory if self.clicking.active or not recorded else None
        clicks = None if now is None or drawn is None else now.clicks
        session.instant.show_reference(drawn, clicks)

    def _dress_lanes(self) -> None:
        now = self.reference.now
        if self.lanes is not None and now is not None:
            self.lanes.show_reference(now.reference, now.outliers)
        elif self.lanes is not None:
            self.lanes.show_reference(None)

    def _on_ranked(self, ranking: Ranking | None) -> None:
        landmarks = self.lanes.landmark_set.landmarks if self.lanes is not None else ()
        colours = {one.name: one.colour for one in landmarks}
        names = self.recording.camera_names() if self.recording is not None else {}
        if ranking is None:
            self.next_panel.show_ranking((), None, colours)
        else:
            self.next_panel.show_ranking(ranking.suggestions, ranking.sign, colours, names)

    def check(self) -> None:
        if self.recording is not None:
            self.next.check(self.recording, self.say)

    # ---- blind repeats

    @property
    def repeats(self) -> BlindRepeats | None:
        return self.clicking.annotating.repeats if self.project is not None else None

    def begin_repeat(self, frame: int) -> None:
        if self.repeats is not None:
            self._back_to = self.frame
            self.repeats.begin(frame)
            self._tell_repeat()
            self.context.session.document.visit(frame)

    def finish_repeat(self) -> None:
        if self.repeats is None or self.repeats.active is None:
            return
        self.repeats.begin(None)
        self._tell_repeat()
        self.say("Both passes are kept. Agreement … under Quality check compares them.")
        back, self._back_to = self._back_to, None
        if back is not None:
            self.context.session.document.visit(back)

    def _tell_repeat(self) -> None:
        self.repeat_bar.show_words(self.repeats.words() if self.repeats is not None else "")
        self.clicking.annotating.reread()
        self.context.actions.refresh()


def click_cameras(recording: Recording | None) -> dict[str, Camera]:
    """The cameras whose images people click in: each view's reference image."""
    if recording is None:
        return {}
    names = [view.image.camera for view in recording.views]
    return {name: recording.cameras[name] for name in names}
