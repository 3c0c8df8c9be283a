"""The window: views in the middle, panels around them, one line that says how things are."""

from __future__ import annotations

import sys

from PySide6.QtCore import QSettings, Qt, QTimer, Signal, Slot
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QResizeEvent
from PySide6.QtWidgets import QApplication, QMainWindow, QStackedWidget, QVBoxLayout, QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import View

from ..features.annotate.annotation_work import AnnotationWork
from ..features.annotate.clicking import annotate_menu
from ..features.annotate.clicking.annotate_control import AnnotateControl
from ..features.annotate.commands import add_commands
from ..features.inspect.inside import InsidePresenter
from ..features.inspect.inside_work import InsideWork
from ..features.project import edit_menu, file_menu
from ..features.project.file_work import FileWork, dropped_path
from ..features.project.project_work import ProjectWork
from ..features.review import review_menu
from ..features.review.episodes import episodes_menu
from ..features.review.episodes.work import EpisodeWork
from ..features.review.review_work import ReviewWork
from ..features.sweep import sweep_menu
from ..features.sweep.sweep_work import SweepWork
from ..features.track import track_menu
from ..features.track.work import RunWork
from ..features.tune import tune_menu
from ..features.tune.tuning_work import TuningWork
from ..features.view import playback_menu, view_menu
from ..features.view.view_control import ViewControl
from ..features.view.view_memory import ViewMemory
from ..services.actions import ActionBook
from ..services.failures import message_of
from ..services.stored import stored_bytes
from ..session.clouds import CloudPresenter
from ..session.document import DocumentPresenter
from ..session.instant import InstantPresenter
from ..session.judging import JudgementPresenter
from ..session.project_file import ProjectPresenter
from ..session.runs import RunList
from ..session.track_control import TrackControl
from ..session.tracking import TrackPresenter
from ..widgets.style.icons import set_icon
from ..widgets.style.theme import ThemeName, apply_theme
from . import window_menu
from .dialogs import Dialogs
from .panel_follower import PanelFollower
from .window_bars import WindowBars
from .window_panels import FIRST_POSE, PanelWindow
from .workspace_control import WorkspaceControl
from .workspaces.layout import Workspace


class MainWindow(PanelWindow):
    """Puts presenters and views together; computes nothing itself.

    Signals
    -------
    refreshed : ()
        Everything that is shown follows the facts again.
    """

    refreshed = Signal()

    def __init__(self, settings: QSettings | None = None) -> None:
        super().__init__()
        # work in the background takes turns with painting every half millisecond, not every five
        sys.setswitchinterval(0.0005)
        self.settings = settings if settings is not None else user_settings()
        self._close_wanted = False
        self._make_presenters()
        self._make_centre()
        self.cancel_button.clicked.connect(self.tasks.cancel_all)
        self.files = FileWork(self, self.settings)
        self.projects = ProjectWork(self)
        self.spaces = WorkspaceControl(self, self.settings)
        self.view = ViewControl(self)
        self.dialogs = Dialogs(self)
        self._refresh_timer = QTimer(self, singleShot=True, interval=30)
        self._refresh_timer.timeout.connect(self.refresh)
        self.run_work = RunWork(self)
        self.follower = PanelFollower(self)
        self.annotate = AnnotateControl(self)
        self.annotation_work = AnnotationWork(self)
        self.episodes = EpisodeWork(self)
        self.review = ReviewWork(self)
        self.sweeps = SweepWork(self)
        self.tuning = TuningWork(self)
        self.view_memory = ViewMemory(self)
        self.inside_work = InsideWork(self)
        self._make_actions()
        self._connect()
        self.setAcceptDrops(True)
        self.setDockOptions(
            QMainWindow.DockOption.AnimatedDocks
            | QMainWindow.DockOption.AllowTabbedDocks
            | QMainWindow.DockOption.AllowNestedDocks
        )
        self.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setMinimumSize(900, 600)
        self.resize(1366, 768)
        geometry = stored_bytes(self.settings, "geometry")
        if geometry is not None:
            self.restoreGeometry(geometry)
        self._show_welcome()

    # ---- making

    def _make_presenters(self) -> None:
        self.runs = RunList(self)
        self.document = DocumentPresenter(self.tasks, self)
        self.project = ProjectPresenter(self.document, self.tasks, self.settings, self)
        self.clouds = CloudPresenter(self)
        self.track = TrackPresenter(self.runs, self)
        self.inside = InsidePresenter(self.document, self.clouds, self.runs, self.track)
        self.tracker = TrackControl(
            self.document, self.clouds, self.runs, self.track, self.inside, FIRST_POSE
        )
        self.judging = JudgementPresenter(self.document, self.runs)
        self.instant = InstantPresenter(
            self.document,
            self.clouds,
            self.runs,
            self.track,
            self.inside,
            wanted=lambda: self.grid.wanted(),
            points_wanted=self._points_wanted,
        )

    def _make_centre(self) -> None:
        self.stack = QStackedWidget()
        self.stack.addWidget(self.welcome)
        self.stack.addWidget(self.grid)
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.messages)
        column.addWidget(self.annotation.repeat_bar)
        column.addWidget(self.stack, 1)
        self.setCentralWidget(centre)

    def _make_actions(self) -> None:
        self.actions_book = ActionBook(self, self.settings)
        self.actions_book.add(file_menu.commands(self))
        for menu in (edit_menu, view_menu, playback_menu, annotate_menu):
            self.actions_book.add(menu.commands(self))
        add_commands(self.annotation, self.actions_book)
        for menu in (track_menu, sweep_menu, tune_menu, review_menu, episodes_menu, window_menu):
            self.actions_book.add(menu.commands(self))
        self.actions_book.add(file_menu.last_commands(self))
        self.actions_book.fill(self.menuBar())
        self.tuning.offer(self.actions_book)
        self.bars = WindowBars(self)
        self.inside_work.offer(self.actions_book)
        self.review.add_buttons()

    def _connect(self) -> None:
        document, track = self.document, self.track
        document.opened.connect(self._on_opened)
        document.opened.connect(self.files.on_opened)
        document.closed.connect(self._on_closed)
        for signal in (
            document.message, self.project.message, self.clouds.message, track.message
        ):  # fmt: skip
            signal.connect(self.messages.show_message)
        self.tasks.failed.connect(self._on_task_failed)
        for changed in (
            document.frame_changed, document.playing_changed, document.count_changed,
            document.findings_changed, track.state_changed, self.runs.changed, self.runs.grew,
            self.runs.active_changed, self.tasks.changed, self.grid.arranged,
            self.project.opened, self.project.closed, self.project.changed,
        ):  # fmt: skip
            changed.connect(self.refresh_soon)
        track.finished.connect(self._on_run_finished)
        self.welcome.open_wanted.connect(self.files.ask_for_recording)
        self.welcome.demo_wanted.connect(self.files.begin_demo)
        self.welcome.recent_chosen.connect(self.files.open)
        self.files.recent_changed.connect(self._list_recent)

    # ---- state, computed from facts

    def views(self) -> tuple[View, ...]:
        """Views of the open recording."""
        recording = self.document.recording
        return recording.views if recording is not None else ()

    def settled(self) -> bool:
        """Whether everything that was asked for is there and painted."""
        return (
            self.document.settled()
            and not self.tasks.tasks
            and not self.track.running
            and self.judging.settled()
            and self.run_work.settled()
            and self.inside.settled()
            and self.instant.settled()
            and self.follower.settled()
            and self.annotate.settled()
            and self.episodes.settled()
            and self.review.settled()
            and self.annotation.settled()
            and self.tuning.settled()
            and not self._refresh_timer.isActive()
        )

    def _points_wanted(self) -> bool:
        scene_seen = self.scene.is_seen() and self.scene.layer_visible("cloud")
        return scene_seen or "points" in self.grid.display.overlays

    @Slot()
    def refresh_soon(self, _what: object = None) -> None:
        """Bring actions and the status line up to date, at most some 30 times a second."""
        if not self._refresh_timer.isActive():
            self._refresh_timer.start()

    @Slot()
    def refresh(self) -> None:
        """Bring actions and the status line up to date."""
        self.actions_book.refresh()
        self.follower.write_status()
        playing = self.document.playing
        set_icon(self.actions_book.action("play"), "pause" if playing else "play")
        self.bars.show_for(self.workspace)
        self.refreshed.emit()

    # ---- what commands do

    @property
    def workspace(self) -> Workspace | None:
        """The arrangement that is shown."""
        return self.spaces.current

    def show_workspace_named(self, name: str) -> None:
        """Show a workspace by its name; one that has nothing to show says why."""
        self.spaces.show_named(name)

    def toggle_playing(self) -> None:
        """Play or pause."""
        if self.document.playing:
            self.document.pause()
        else:
            self.document.play()

    def go_above(self, direction: int) -> None:
        """Go to the next or previous stretch above the plot's threshold."""
        frame = self.plot.crossing(direction)
        if frame is not None:
            self.document.pause()
            self.document.go_to(frame)
        else:
            where = "after" if direction > 0 else "before"
            self.statusBar().showMessage(
                f"No limb is above the threshold {where} this frame.", 4000
            )

    def choose_theme(self, name: ThemeName) -> None:
        """Change the look, and keep it for next time."""
        app = QApplication.instance()
        if isinstance(app, QApplication):
            apply_theme(app, name)
            self.settings.setValue("theme", name)
            self.instant.tell_soon()

    def show_error(self, error: BaseException) -> None:
        """Show what went wrong in words."""
        self.messages.show_message(message_of(error))

    # ---- following the document

    @Slot()
    def _on_opened(self) -> None:
        recording = self.document.recording
        self.messages.clear()
        self.track.stop()
        self.tuning.stop()
        self.runs.clear()
        self.instant.clear()
        try:
            self.clouds.set_recording(recording)
        except InputError as error:
            self.clouds.set_recording(None)
            self.show_error(error)
        self.follower.show_recording()
        self.stack.setCurrentWidget(self.grid)
        self.spaces.show_first()
        self.refresh()

    @Slot()
    def _on_closed(self) -> None:
        self.spaces.leave()
        self.track.stop()
        self.tuning.stop()
        self.runs.clear()
        self.instant.clear()
        self.clouds.set_recording(None)
        self._show_welcome()

    def _show_welcome(self) -> None:
        self.spaces.leave()
        self.follower.show_recording()
        for dock in self.docks.values():
            dock.hide()
        self._list_recent()
        self.stack.setCurrentWidget(self.welcome)
        self.refresh()

    @Slot()
    def _list_recent(self) -> None:
        self.welcome.set_recent(self.files.recent())

    @Slot(object)
    def _on_run_finished(self, entry: object) -> None:
        self.judging.judge()
        self.follower.on_run_finished(entry)
        self.refresh_soon()

    @Slot(object)
    def _on_task_failed(self, error: Exception) -> None:
        self.show_error(error)

    # ---- the window itself

    def close_later(self) -> None:
        """Close when the command that asked for it has returned."""
        QTimer.singleShot(0, self.close)

    def closeEvent(self, event: QCloseEvent) -> None:
        self.spaces.leave()
        self.settings.setValue("geometry", self.saveGeometry())
        self.document.pause()
        self.track.stop()
        self.sweeps.shutdown()
        self.tuning.stop()
        self.inside.close()
        self.tasks.shutdown()
        self.document.close()
        self.annotate.close()
        self.annotation.shutdown()
        self.episodes.shutdown()
        self.project.shutdown()
        self.clouds.set_recording(None)
        self.settings.sync()
        event.accept()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        first = not event.oldSize().isValid()
        if first:
            self.spaces.arrange()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if dropped_path(event.mimeData()) is not None:
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        path = dropped_path(event.mimeData())
        if path is not None:
            event.acceptProposedAction()
            self.files.open(path)


def user_settings() -> QSettings:
    """Where layouts, shortcuts and the list of recordings are kept, apart from all data."""
    return QSettings(
        QSettings.Format.IniFormat, QSettings.Scope.UserScope, "stereotrack", "stereotrack"
    )
