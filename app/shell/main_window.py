"""The window: views in the middle, panels around them, one line that says how things are."""

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QMimeData, QSettings, QSize, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QMainWindow

from ..context import make_context
from ..services.focus import WheelGuard
from ..services.layout import stored_bytes
from ..session.changes import PROJECT, Part
from ..session.jobs import Processes, Task
from ..session.messages import Message
from ..session.session import opens
from ..widgets.forms.message import MessageBar
from ..widgets.forms.welcome import WelcomePage
from ..widgets.style.theme import set_icon
from .actions import MENUS, Toolbars, commands
from .dialogs import Dialogs
from .help import Help
from .status import StatusLine

_USUAL = QSize(1600, 960)
_FRAME = QSize(16, 40)  # pixels that a window manager may draw around the window, about
_OF_COMMANDS = (
    Part.FRAME | Part.PLAYING | Part.LENGTH | Part.FINDINGS | Part.TRACKING
    | Part.RUNS | Part.RUN_FRAMES | Part.ACTIVE_RUN
    | PROJECT | Part.EDIT | Part.EDITS | Part.KEYPOINTS | Part.TASKS
)  # fmt: skip
"""Parts that titles and availability of commands depend on."""


def first_size(screen: QSize) -> QSize:
    """Size of a window that was never opened before, on a screen with so much room."""
    return _USUAL.boundedTo(screen - _FRAME)


class MainWindow(QMainWindow):
    """Makes the services for the features, and draws what these have registered."""

    def __init__(self, settings: QSettings, processes: Processes | None = None) -> None:
        super().__init__()
        self.messages = MessageBar()
        self.context = make_context(self, self.messages, settings, processes)
        WheelGuard(self)
        self.welcome = WelcomePage(self._do, self.context.session.open)
        self.context.docks.lay_over_views(self.messages)
        self.context.docks.middle.addWidget(self.welcome)
        self.status = StatusLine(self.statusBar(), self.context)
        self.help = Help(self, self.context)
        self._is_told_to_close = False
        self._connect()

    def draw(self) -> None:
        """Draw menus, toolbars and the welcome page, when all features have registered."""
        context = self.context
        self.help.explain(
            {
                "Views": context.docks.views,
                "Welcome page": self.welcome,
                "User guide": self.help,
                **context.docks.pages(),
            }
        )
        dialogs = Dialogs(self, context)
        context.actions.add(commands(context, dialogs, self.messages, self.help))
        context.actions.fill(self.menuBar(), MENUS)
        self.bars = Toolbars(self, context)
        self._lay_out()
        self._show_welcome()

    def _connect(self) -> None:
        context, session = self.context, self.context.session
        context.docks.left.connect(self._show_welcome)
        watch = session.changes.watch
        watch(_OF_COMMANDS, context.actions.refresh_soon)
        watch(Part.READY, self._on_ready)
        watch(Part.RECORDING_CLOSED, self._show_welcome)
        watch(Part.RECORDING_OPENED | PROJECT, self.write_title)
        watch(Part.RECENT, self._list_recent)
        watch(Part.PLAYING, self._show_playing)

    def _do(self, name: str) -> None:
        self.context.actions.action(name).trigger()

    def _lay_out(self) -> None:
        self.setAcceptDrops(True)
        options = QMainWindow.DockOption
        self.setDockOptions(
            options.AnimatedDocks | options.AllowTabbedDocks | options.AllowNestedDocks
        )
        self.setCorner(Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setMinimumSize(900, 600)
        self.resize(first_size(self.screen().availableSize()))
        geometry = stored_bytes(self.context.settings, "geometry")
        if geometry is not None:
            self.restoreGeometry(geometry)

    def _on_ready(self) -> None:
        self.messages.clear()
        self.context.docks.show_first()
        self.context.actions.refresh()

    def _show_welcome(self) -> None:
        docks = self.context.docks
        docks.leave()
        docks.hide_all()
        self.write_title()
        self._list_recent()
        docks.middle.setCurrentWidget(self.welcome)
        self.context.actions.refresh()

    def _list_recent(self) -> None:
        self.welcome.set_recent(self.context.session.recents())

    def write_title(self) -> None:
        recording, project = self.context.session.document.recording, self.context.session.project
        names = [recording.name] if recording is not None else []
        if recording is not None and project.project is not None:
            reading = "  (read-only)" if project.project.read_only else ""
            names.append(f"{project.project.path.name}{reading}")
        self.setWindowTitle(" – ".join([*names, "stereotrack"]))

    def _show_playing(self) -> None:
        playing = self.context.session.document.playing
        set_icon(self.context.actions.action("play"), "pause" if playing else "play")

    def focusNextPrevChild(self, forward: bool) -> bool:
        return self.context.docks.focus.step(forward)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Close when all that was promised is written; exports are waited for only once."""
        tasks, exports = self.context.tasks, not self._is_told_to_close
        if waits_for := tasks.promised(exports=exports):
            event.ignore()
            self._is_told_to_close = True
            tasks.after_writes(self._close_soon, exports=exports)
            only_writes = len(waits_for) == len(tasks.promised())
            self.context.notifier.show(_closes_after(waits_for, exports=not only_writes))
            return
        self.context.docks.leave()
        self.context.settings.setValue("geometry", self.saveGeometry())
        self.context.session.close()
        self.context.settings.sync()
        event.accept()

    def _close_soon(self) -> None:
        QTimer.singleShot(0, self, self._close_if_shown)

    def _close_if_shown(self) -> None:
        if self.isVisible():
            self.close()

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if _dropped_paths(event.mimeData()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        paths = _dropped_paths(event.mimeData())
        if paths:
            event.acceptProposedAction()
            self.context.session.open_all(paths)


def _dropped_paths(data: QMimeData) -> tuple[Path, ...]:
    """What was dragged into the window and can be opened."""
    paths = [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
    return tuple(path for path in paths if opens(path))


def _closes_after(tasks: Sequence[Task], *, exports: bool) -> Message:
    return Message(
        "note",
        "the window closes when everything is written",
        ", ".join(task.title for task in tasks),
        "Close it again to stop exports." if exports else "",
    )
