"""Everything of annotation around the views: lanes, what is next, trust."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from PySide6.QtCore import QObject, QPoint, Qt, QTimer, Signal, Slot
from PySide6.QtWidgets import QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.blind_repeats import BlindRepeats
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.fitting import ShownReference
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording

from ...services.failures import message_of
from ...services.tasks.task import TaskList
from ...session.edits import EditStack
from ...widgets.forms.message import StateBar
from ...widgets.tables.next_panel import NextPanel
from ...widgets.timeline.bars import AnnotationBar
from ...widgets.timeline.timeline_view import TimelineView
from .filling.reference_work import ReferenceWork
from .lanes import AnnotationLanes
from .next_clicks import NextPresenter, Ranking

_GROUP = "annotation"
_DELAY_MS = 40
_COUNTING_MS = 250
_MANY_FRAMES = 300


class AnnotationPanels(QObject):
    """The panels of annotation and what stands behind them; they follow one project."""

    leaving = Signal()
    """Another project comes, or none: what works on the one before stops."""
    frame_requested = Signal(int)
    click_requested = Signal(int, str, str)
    """Frame, camera and landmark: go there and choose it."""
    landmark_chosen = Signal(str)
    """The name of a landmark's lane was clicked."""
    repeat_changed = Signal()
    """A frame begins or ends to be annotated again, or has other clicks of the second reading."""
    reference_changed = Signal()
    """Another trajectory is the project's reference, or none."""
    said = Signal(str)
    """What was done, for the status line."""
    message = Signal(object)
    """Something that the person should read."""
    changed = Signal()
    """Commands may be possible now that were not, or the other way round."""
    _edited = Signal(object)

    def __init__(
        self, timeline: TimelineView, tasks: TaskList, edits: EditStack, window: QWidget
    ) -> None:
        super().__init__(window)
        self.timeline, self.tasks, self.edits, self.window = timeline, tasks, edits, window
        self.project: Project | None = None
        self.recording: Recording | None = None
        self.frame_count, self.frame = 0, 0
        self._shown = True
        self.bar = AnnotationBar()
        self.next_panel = NextPanel()
        tip = "Finish the blind repeat; both passes are kept in the project"
        self.repeat_bar = StateBar("Blind repeat", "Finish and show", tip)
        self.lanes: AnnotationLanes | None = None
        self._proposed: Mapping[int, Collection[str]] = {}
        self._kept: Mapping[int, Collection[str]] = {}
        self.repeats: BlindRepeats | None = None
        self.next = NextPresenter(self)
        self.reference = ReferenceWork(tasks, self)
        self._back_to: int | None = None
        self._forget: Callable[[], None] | None = None
        self._soon = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._soon.timeout.connect(self._show_numbers)
        self._counted = QTimer(self, singleShot=True, interval=_COUNTING_MS)
        self._counted.timeout.connect(self._on_counted)
        self._connect()

    def _connect(self) -> None:
        self._edited.connect(self._on_edited)
        self.timeline.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.timeline.customContextMenuRequested.connect(self._on_menu)
        self.timeline.selection_changed.connect(self._on_selection)
        self.timeline.lanes_selected.connect(self._on_selection)
        self.timeline.lane_clicked.connect(self._on_lane)
        self.bar.flagged_requested.connect(self.go_to_flagged)
        self.next_panel.visit_requested.connect(self.click_requested)
        self.next_panel.wanted_changed.connect(self.next.set_wanted)
        self.next.wanted_changed.connect(self.next_panel.show_wanted)
        self.next_panel.limited.connect(self._on_limited)
        self.next_panel.fit_requested.connect(self._on_fit_wanted)
        self.next_panel.nothing_left.connect(lambda: self.said.emit("No click is suggested here."))
        self.next.ranked.connect(self._on_ranked)
        self.reference.shown.connect(self._on_reference)
        self.reference.busy_changed.connect(self.changed)
        self.repeat_bar.ended.connect(self.finish_repeat)
        for source in (self.next, self.reference):
            source.failed.connect(self._on_failed)

    # ---- the project

    def set_project(
        self, project: Project | None, recording: Recording | None, frame_count: int
    ) -> None:
        """Follow another project, or none; the one before may be closed afterwards."""
        if self._forget is not None:
            self._forget()
            self._forget = None
        self.leaving.emit()
        self.project = project if recording is not None else None
        self.recording, self.frame_count = recording, frame_count
        self._back_to = None
        if self.project is not None:
            self._forget = self.project.on_change(self._edited.emit)
        self.repeats = BlindRepeats(self.project) if self.project is not None else None
        self.next.set_project(self.project, click_cameras(recording))
        self.next_panel.show_wanted(self.next.wanted_deg)
        self._make_lanes()
        self.reference.set_project(self.project, recording, frame_count)
        self._show_bar()
        self._show_selection()
        self._show_numbers()
        self._tell_repeat()

    def set_shown(self, shown: bool) -> None:
        """Show lanes and bar, or leave the timeline to the runs."""
        if shown != self._shown:
            self._shown = shown
            self._show_bar()
            self._show_lanes()

    def _show_bar(self) -> None:
        self.bar.setVisible(self._shown and self.project is not None)

    def set_frame_count(self, frame_count: int) -> None:
        """The number of frames is known better."""
        if frame_count != self.frame_count:
            self.frame_count = frame_count
            # while frames are being counted this is called again and again
            self._counted.start(_COUNTING_MS if self.lanes is not None else 0)

    @Slot()
    def _on_counted(self) -> None:
        self._make_lanes()
        self.reference.set_frame_count(self.frame_count)

    def set_frame(self, frame: int) -> None:
        """Another frame is shown."""
        self.frame, self.next_panel.awaited = frame, False
        if self.timeline.selection is None:
            self._show_selection()

    def settled(self) -> bool:
        """Whether everything shown follows the facts."""
        waiting = self._soon.isActive() or self._counted.isActive()
        return not waiting and self.next.idle and not self.reference.fitting

    def shutdown(self) -> None:
        """Let the project go, before the window closes."""
        self.set_project(None, None, 0)

    def _make_lanes(self) -> None:
        project, recording = self.project, self.recording
        self.lanes = None
        if project is not None and recording is not None and self.frame_count:
            cameras = len(click_cameras(recording))
            self.lanes = AnnotationLanes(project, self.frame_count, cameras)
            self._dress_lanes(self.reference.now)
        self.read_kept()
        self._show_lanes()

    # ---- edits

    def no_project(self) -> str:
        """No project is open, as a sentence; empty where one is."""
        return "" if self.project is not None else "No project is open. Open or create one first."

    def no_edit(self) -> str:
        """Nothing can be changed in the project."""
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
            self.tasks.write(
                "editing", lambda _task: project.apply(make(project, chosen)), self._on_done
            )
            return
        try:
            self._on_done(project.apply(make(project, chosen)))
        except InputError as error:
            self.message.emit(message_of(error))

    @Slot(object)
    def _on_done(self, changed: Changed | None) -> None:
        self.said.emit(f"Done: {changed.words}." if changed is not None else "Nothing to change.")

    @Slot(object)
    def _on_edited(self, changed: Changed) -> None:
        if self.project is None:
            return
        self._soon.start()  # first, so that numbers are right whatever fails below
        if self.lanes is not None and self.lanes.follow(changed):
            self._show_lanes()
        self.reference.follow(changed)
        self.next.follow(changed)
        if "click" in changed.tables:
            self.next_panel.awaited = False  # who goes on clicking stays where they are
        if "repeat_click" in changed.tables:
            self._tell_repeat()

    @Slot()
    def _show_numbers(self) -> None:
        if self.project is not None:
            progress = self.project.progress()
            flagged = self.lanes is not None and bool(len(self.lanes.flagged_frames()))
            self.bar.show_progress(progress.words(), progress.share, flagged=flagged)
        self.changed.emit()

    # ---- selection and lanes

    def selection(self) -> Selection:
        """What commands work on: the selected frames, or the one that is shown."""
        landmarks = self.lanes.landmark_set.names if self.lanes is not None else ()
        lanes = self.timeline.selected_lanes
        return Selection(
            self.timeline.selection or range(self.frame, self.frame + 1),
            tuple(name for name in landmarks if name in lanes),
        )

    @Slot()
    def _on_selection(self) -> None:
        self._show_selection()
        if self.next_panel.limit.isChecked():
            self.next.set_frames(self.timeline.selection)

    def _show_selection(self) -> None:
        self.bar.show_selection(self.selection().words() if self.project is not None else "")

    @Slot(bool)
    def _on_limited(self, limited: bool) -> None:
        self.next.set_frames(self.timeline.selection if limited else None)

    @Slot(str)
    def _on_lane(self, name: str) -> None:
        if self.lanes is not None and name in self.lanes.landmark_set.names:
            self.landmark_chosen.emit(name)

    @Slot()
    def read_kept(self) -> None:
        """Other predictions are kept in the project than before."""
        self._kept = self.project.predictions.places() if self.project is not None else {}
        self.show_proposed(self._proposed)

    def show_proposed(self, proposed: Mapping[int, Collection[str]]) -> None:
        """Hatch in the lanes what can be accepted: landmarks by frame; what is kept too."""
        self._proposed, kept = proposed, self._kept
        every = {k: {*kept.get(k, ()), *proposed.get(k, ())} for k in {*kept, *proposed}}
        if self.lanes is not None and self.lanes.show_proposed(every):
            self._show_lanes()

    def _show_lanes(self) -> None:
        lanes = self.lanes if self._shown else None
        self.timeline.set_lanes(lanes.lanes() if lanes is not None else (), _GROUP)

    @Slot(QPoint)
    def _on_menu(self, place: QPoint) -> None:
        if self.project is not None:
            self.bar.show_selection_menu(self.timeline.mapToGlobal(place))

    @Slot(bool)
    def go_to_flagged(self, backwards: bool = False) -> None:
        """Go to the next (previous) frame in which a landmark is flagged."""
        found = None
        if self.lanes is not None:
            found = self.lanes.next_flagged(self.frame, backwards=backwards)
        if found is not None:
            self.frame_requested.emit(found)
        else:
            where = "before" if backwards else "after"
            self.said.emit(f"No frame {where} this one has a flag.")

    # ---- fit, following, what is next

    @Slot()
    def _on_fit_wanted(self) -> None:
        """Fit, as suggestions need it; or say why there can be none."""
        if self.reference.fitting:
            self.said.emit("Suggested clicks come when the fit that is running is done.")
        elif self.reference.why_not() or self.project is None:
            self.said.emit(self.reference.why_not())
        elif not self.project.clicks.count():
            self.said.emit("Suggested clicks need a fit. Click at least three landmarks first.")
        else:
            self.said.emit("Fitting the body to all clicks to find where one helps most …")
            self.reference.fit()

    @Slot(object)
    def _on_reference(self, now: ShownReference | None) -> None:
        self._dress_lanes(now)
        self._show_lanes()
        self.next.set_fit(now.fit if now is not None else None)
        if now is not None:
            self.said.emit(now.words)
        self.reference_changed.emit()
        self.changed.emit()

    def _dress_lanes(self, now: ShownReference | None) -> None:
        if self.lanes is not None:
            if now is not None:
                self.lanes.show_reference(now.reference, now.outliers)
            else:
                self.lanes.show_reference(None)

    @Slot(object)
    def _on_ranked(self, ranking: Ranking | None) -> None:
        colours: Mapping[str, str] = {}
        if self.lanes is not None:
            colours = {one.name: one.colour for one in self.lanes.landmark_set.landmarks}
        names = self.recording.camera_names() if self.recording is not None else {}
        if ranking is None:
            self.next_panel.show_ranking((), None, colours)
        else:
            self.next_panel.show_ranking(ranking.suggestions, ranking.sign, colours, names)

    # ---- blind repeats

    def begin_repeat(self, frame: int) -> None:
        """Annotate a frame again, its first reading hidden."""
        if self.repeats is not None:
            self._back_to = self.frame
            self.repeats.begin(frame)
            self._tell_repeat()
            self.frame_requested.emit(frame)

    @Slot()
    def finish_repeat(self) -> None:
        """Show the frame as it is again, and go back to where one was."""
        if self.repeats is None or self.repeats.active is None:
            return
        self.repeats.begin(None)
        self._tell_repeat()
        back, self._back_to = self._back_to, None
        if back is not None:
            self.frame_requested.emit(back)

    def _tell_repeat(self) -> None:
        self.repeat_bar.show_words(self.repeats.words() if self.repeats is not None else "")
        self.repeat_changed.emit()
        self.changed.emit()

    # ---- the rest

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self.message.emit(message_of(error))


def click_cameras(recording: Recording | None) -> dict[str, Camera]:
    """The cameras whose images people click in: each view's reference image."""
    if recording is None:
        return {}
    names = [view.image.camera for view in recording.views]
    return {name: recording.cameras[name] for name in names}
