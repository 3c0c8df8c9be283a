"""The window: views in the middle, panels around them, one line that says how things are."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSettings, Qt, QTimer, Signal, Slot
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QApplication,
    QLabel,
    QMainWindow,
    QProgressBar,
    QStackedWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.actions import ActionBook
from app.commands import file_menu, playback_menu, track_menu, view_menu, window_menu
from app.dialogs import Dialogs
from app.failures import Message, message_of
from app.file_work import FileWork, dropped_folder
from app.icons import set_icon
from app.panel_follower import PanelFollower
from app.presenters.clouds import CloudPresenter
from app.presenters.document import DocumentPresenter
from app.presenters.instant import InstantPresenter
from app.presenters.judging import JudgementPresenter
from app.presenters.runs import RunList
from app.presenters.scene import POINT_COLOURS
from app.presenters.tracking import TrackPresenter
from app.tasks.task import TaskList
from app.theme import ThemeName, apply_theme
from app.track_control import TrackControl
from app.view_control import ViewControl
from app.views.scene_bar import SceneBar
from app.views.toolbars import add_toolbar
from app.window_panels import FIRST_POSE, TITLES, PanelWindow
from app.workspaces.layout import (
    WORKSPACES,
    Workspace,
    arrange,
    forget_layout,
    restore_layout,
    save_layout,
    workspace_named,
)
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import View


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
        self.settings = settings if settings is not None else user_settings()
        self.workspace: Workspace | None = None
        self._close_wanted = False
        self._make_presenters()
        self._make_centre()
        self._make_status_line()
        self.files = FileWork(self, self.settings)
        self.view = ViewControl(self)
        self.dialogs = Dialogs(self)
        self._refresh_timer = QTimer(self, singleShot=True, interval=30)
        self._refresh_timer.timeout.connect(self.refresh)
        self.follower = PanelFollower(self)
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
        geometry = self.settings.value("geometry")
        if geometry is not None:
            self.restoreGeometry(geometry)
        self._show_welcome()

    # ---- making

    def _make_presenters(self) -> None:
        self.tasks = TaskList(self)
        self.runs = RunList(self)
        self.document = DocumentPresenter(self.tasks, self)
        self.clouds = CloudPresenter(self)
        self.track = TrackPresenter(self.runs, self)
        self.tracker = TrackControl(self.document, self.clouds, self.runs, self.track, FIRST_POSE)
        self.judging = JudgementPresenter(self.document, self.runs)
        self.instant = InstantPresenter(
            self.document,
            self.clouds,
            self.runs,
            self.track,
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
        column.addWidget(self.stack, 1)
        self.setCentralWidget(centre)

    def _make_status_line(self) -> None:
        self.state_label = QLabel()
        self.state_label.setContentsMargins(8, 0, 0, 0)
        self.pixel_label = QLabel()
        self.progress = QProgressBar()
        self.progress.setMaximumWidth(160)
        self.progress.setMaximumHeight(14)
        self.progress.setTextVisible(False)
        self.cancel_button = QToolButton()
        self.cancel_button.setToolTip("Cancel the work in the background")
        self.cancel_button.setAutoRaise(True)
        set_icon(self.cancel_button, "stop")
        self.cancel_button.clicked.connect(self.tasks.cancel_all)
        bar = self.statusBar()
        bar.addWidget(self.state_label, 1)
        bar.addPermanentWidget(self.pixel_label)
        bar.addPermanentWidget(self.progress)
        bar.addPermanentWidget(self.cancel_button)
        self.progress.hide()
        self.cancel_button.hide()

    def _make_actions(self) -> None:
        self.actions_book = ActionBook(self, self.settings)
        for menu in (file_menu, view_menu, playback_menu, track_menu, window_menu):
            self.actions_book.add(menu.commands(self))
        self.actions_book.fill(self.menuBar())
        book = self.actions_book

        def named(names: tuple[str, ...]) -> list[QAction]:
            return [book.action(name) for name in names]

        spaces = tuple(f"workspace_{space.name}" for space in WORKSPACES)
        self.workspace_bar = add_toolbar(self, "Workspaces", named(spaces), words=True)
        go = ("first", "previous", "play", "next", "last")
        self.play_bar = add_toolbar(self, "Playback", named(go), widgets=[self.transport])
        track = ("run", "pause", "step", "iterate", "run_here", "stop")
        self.track_bar = add_toolbar(self, "Tracker", named(track))
        overlays = ("outline", "reference", "points", "correspondences")
        other = ("arrange_grid", "arrange_one-and-more", "arrange_single", "keep_person", "loupe")
        shown = [*named(tuple(f"overlay_{name}" for name in overlays)), None, *named(other)]
        self.view_bar = add_toolbar(self, "Views", shown)
        self._make_scene_bar(named)

    def _make_scene_bar(self, named: Callable[[tuple[str, ...]], list[QAction]]) -> None:
        layers = named(tuple(f"scene_{layer}" for layer in view_menu.SCENE_LAYERS))
        sides = named(tuple(f"scene_from_{side}" for side in view_menu.SCENE_SIDES))
        colours = named(tuple(f"points_{kind}" for kind in POINT_COLOURS))
        menus = [("Colour of the points", "theme", colours), ("Standard views", "scene", sides)]
        self.docks["scene"].setTitleBarWidget(SceneBar(TITLES["scene"], layers, menus))

    def _connect(self) -> None:
        document, track = self.document, self.track
        document.opened.connect(self._on_opened)
        document.opened.connect(self.files.on_opened)
        document.closed.connect(self._on_closed)
        for signal in (document.message, self.clouds.message, track.message):
            signal.connect(self.messages.show_message)
        self.tasks.failed.connect(self._on_task_failed)
        for changed in (
            document.frame_changed, document.playing_changed, document.count_changed,
            document.findings_changed, track.state_changed, self.runs.changed, self.runs.grew,
            self.runs.active_changed, self.tasks.changed, self.grid.arranged,
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
            and self.instant.settled()
            and self.follower.settled()
            and not self._refresh_timer.isActive()
        )

    def _points_wanted(self) -> bool:
        scene_seen = self.scene.isVisible() and self.scene.layer_visible("cloud")
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
        open_now = self.document.recording is not None
        for bar in (self.workspace_bar, self.play_bar, self.track_bar, self.view_bar):
            bar.setVisible(open_now)
        self.refreshed.emit()

    # ---- what commands do

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

    def toggle_run(self) -> None:
        """Show or hide the active run."""
        active = self.runs.active
        if active is not None:
            self.runs.show(active, visible=not active.visible)

    def activate_next_run(self) -> None:
        """Make the next run the active one."""
        entries, active = self.runs.entries, self.runs.active
        if active is not None:
            self.runs.activate(entries[(entries.index(active) + 1) % len(entries)])

    def remove_run(self) -> None:
        """Take the active run from the list."""
        if self.runs.active is not None:
            self.runs.remove(self.runs.active)

    # ---- workspaces and panels

    def show_workspace(self, space: Workspace) -> None:
        """Arrange the panels as a workspace has them, as the person left it."""
        if self.workspace is not None:
            save_layout(self, self.settings, self.workspace)
        self.workspace = space
        self.settings.setValue("workspace", space.name)
        if not restore_layout(self, self.settings, space):
            arrange(self, self.docks, space)
        self.follower.look_at(cameras=space.name == "calibrate")
        self.instant.tell_soon()
        self.refresh_soon()

    def show_workspace_named(self, name: str) -> None:
        """Show a workspace by its name; one that has nothing to show says why."""
        space = workspace_named(name)
        if space is None:
            known = ", ".join(space.name for space in WORKSPACES)
            self.show_error(
                InputError(f"there is no workspace {name!r}", remedy=f"Known are: {known}.")
            )
            return
        why_not = window_menu.why_no_workspace(self, space)
        if why_not:
            self.messages.show_message(
                Message("note", f"The workspace {space.title} has nothing to show", remedy=why_not)
            )
        else:
            self.show_workspace(space)

    def reset_workspace(self) -> None:
        """Put the panels of this workspace back where they belong."""
        if self.workspace is not None:
            forget_layout(self.settings, self.workspace)
            arrange(self, self.docks, self.workspace)

    def in_workspace(self, space: Workspace) -> bool:
        """Whether this is the workspace that is shown."""
        return self.workspace is space

    def panel_shown(self, name: str) -> bool:
        """Whether a panel is there, be it behind another one."""
        return not self.docks[name].isHidden()

    def toggle_panel(self, name: str) -> None:
        """Show or hide a panel; one that was never placed comes to the right."""
        dock = self.docks[name]
        if dock.isHidden():
            if self.dockWidgetArea(dock) == Qt.DockWidgetArea.NoDockWidgetArea:
                self.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
            dock.show()
            dock.raise_()
        else:
            dock.hide()
        self.instant.tell_soon()

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
        self.runs.clear()
        self.instant.clear()
        try:
            self.clouds.set_recording(recording)
        except InputError as error:
            self.clouds.set_recording(None)
            self.show_error(error)
        self.follower.show_recording()
        self.stack.setCurrentWidget(self.grid)
        self._choose_first_workspace()
        self.refresh()

    def _choose_first_workspace(self) -> None:
        self.workspace = None
        wanted = workspace_named(str(self.settings.value("workspace") or "track"))
        for space in (wanted, *WORKSPACES):
            if space is not None and not window_menu.why_no_workspace(self, space):
                self.show_workspace(space)
                return
        self.show_workspace(WORKSPACES[0])

    @Slot()
    def _on_closed(self) -> None:
        if self.workspace is not None:
            save_layout(self, self.settings, self.workspace)
        self.runs.clear()
        self.instant.clear()
        self.clouds.set_recording(None)
        self._show_welcome()

    def _show_welcome(self) -> None:
        self.workspace = None
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
        if self.workspace is not None:
            save_layout(self, self.settings, self.workspace)
        self.settings.setValue("geometry", self.saveGeometry())
        self.document.pause()
        self.track.stop()
        self.tasks.shutdown()
        self.document.close()
        self.clouds.set_recording(None)
        self.settings.sync()
        event.accept()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        first = not event.oldSize().isValid()
        if first and self.workspace is not None:
            arrange(self, self.docks, self.workspace)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if dropped_folder(event.mimeData()) is not None:
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        folder = dropped_folder(event.mimeData())
        if folder is not None:
            event.acceptProposedAction()
            self.files.open(folder)


def user_settings() -> QSettings:
    """Where layouts, shortcuts and the list of recordings are kept, apart from all data."""
    return QSettings(
        QSettings.Format.IniFormat, QSettings.Scope.UserScope, "stereotrack", "stereotrack"
    )
