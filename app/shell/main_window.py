"""The window: views in the middle, panels around them, one line that says how things are."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6 import QtWidgets
from PySide6.QtCore import QMimeData, QSettings, QSize, Qt, QTimer
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDropEvent, QResizeEvent

from ..context import make_context
from ..services.docks import stored_bytes
from ..session.changes import PROJECT, Part
from ..session.jobs import Processes
from ..session.messages import Message
from ..session.session import opens
from ..widgets.forms.form_dialog import push_button
from ..widgets.forms.message import MessageBar
from ..widgets.style.building import hbox, label, named, vbox
from ..widgets.style.theme import icon_named
from .actions import MENUS, Toolbars, commands
from .help import Help
from .status import StatusLine

_ABOUT = (
    "Track and analyse the movement of a person's upper body in recordings of several stereo or "
    "depth cameras."
)
_HINT = (
    "A recording is a folder with a recording.toml, its calibration and its images. Drop one onto "
    "this window to open it, or drop videos to make one of them."
)
_WAYS = (
    ("open", "Open a recording …", "open", "Open a recording folder."),
    (
        "import_recording", "Make a recording of videos …", "camera",
        "Make a recording folder of videos or images of one or more cameras.",
    ),
    (
        "calibrate", "Calibrate cameras …", "calibrate",
        "Calibrate cameras with pictures of a board.",
    ),
    (
        "demo", "Open and track demo", "run-tracker",
        "Open four stereo views of a simulated person with known ground truth, and track them.",
    ),
)  # fmt: skip


class WelcomePage(QtWidgets.QWidget):
    """Ways to begin: a recording of one's own, the demo, or one of the last ones."""

    def __init__(self, do: Callable[[str], object], open_recent: Callable[[Path], object]) -> None:
        super().__init__()
        self.open_button, self.import_button, self.calibrate_button, self.demo_button = (
            _button(text, icon, tip, partial(do, name)) for name, text, icon, tip in _WAYS
        )
        self.recent = named(QtWidgets.QListWidget(), "Recent recordings")
        self.recent.setFrameShape(QtWidgets.QFrame.Shape.NoFrame)
        self.recent.setAlternatingRowColors(False)
        self._none = label("No recent recordings.", "muted")
        self._lay_out()
        for chosen in (self.recent.itemActivated, self.recent.itemClicked):
            chosen.connect(lambda item: open_recent(Path(item.data(Qt.ItemDataRole.UserRole))))

    def set_recent(self, recents: Sequence[Path]) -> None:
        self.recent.clear()
        for folder in recents:
            item = QtWidgets.QListWidgetItem(f"{folder.name}    {folder.parent}")
            item.setData(Qt.ItemDataRole.UserRole, str(folder))
            item.setToolTip(str(folder))
            self.recent.addItem(item)
        self.recent.setVisible(bool(recents))
        self._none.setVisible(not recents)

    def _lay_out(self) -> None:
        title = label("stereotrack")
        font = title.font()
        font.setPointSizeF(font.pointSizeF() * 2.4)
        font.setWeight(font.Weight.DemiBold)
        title.setFont(font)
        self.recent.setMaximumHeight(240)
        ways = (self.open_button, self.import_button, self.calibrate_button, self.demo_button)
        hints = (label(_HINT, "muted"), label("Press Ctrl+K to search all commands.", "muted"))
        column = vbox(
            None, title, label(_ABOUT), hbox(*ways, None, margins=(0, 8, 0, 16)),
            label("Open recent", "heading"), self._none, (self.recent, 4), *hints, None, spacing=12,
        )  # fmt: skip
        self.setLayout(hbox(None, (column, 3), None))


def _button(text: str, icon: str, tip: str, do: Callable[[], object]) -> QtWidgets.QPushButton:
    button = push_button(text, do, tip)
    button.setMinimumHeight(36)
    button.setIcon(icon_named(icon))
    return button


_USUAL = QSize(1600, 960)
_FRAME = QSize(16, 40)  # pixels that a window manager may draw around the window, about
_OF_COMMANDS = (
    Part.FRAME | Part.PLAYING | Part.LENGTH | Part.FINDINGS | Part.TRACKING
    | Part.RUNS | Part.RUN_FRAMES | Part.ACTIVE_RUN
    | PROJECT | Part.EDIT | Part.EDITS | Part.KEYPOINTS | Part.TASKS
)  # fmt: skip
"""Parts that titles and availability of commands depend on."""


class MainWindow(QtWidgets.QMainWindow):
    """Makes the services for the features, and draws what these have registered."""

    def __init__(self, settings: QSettings, processes: Processes | None = None) -> None:
        super().__init__()
        self.messages = MessageBar()
        context = self.context = make_context(self, self.messages, settings, processes)
        session = context.session
        self.welcome = WelcomePage(
            lambda name: context.actions.action(name).trigger(), session.open
        )
        context.docks.below_views.addWidget(self.messages)
        context.docks.middle.addWidget(self.welcome)
        self.status = StatusLine(self.statusBar(), context)
        self.help = Help(self, context)
        self._is_told_to_close = False
        self.asks_before_quitting = True  # whether it asks, where something would be lost
        session.ask_first = self._ask_first
        context.docks.left.connect(self._show_welcome)
        watch = session.changes.watch
        watch(_OF_COMMANDS, context.actions.refresh_soon)
        watch(Part.READY, self._on_ready)
        watch(Part.RECORDING_CLOSED, self.messages.clear)
        watch(Part.RECORDING_CLOSED, self._show_welcome)
        watch(Part.RECORDING_OPENED | PROJECT, self.write_title)
        watch(Part.RECENT, self._list_recent)
        watch(Part.PLAYING, self._show_playing)

    def draw(self) -> None:
        """Draw menus, toolbars and the welcome page, when all features have registered."""
        context = self.context
        views = context.docks.views
        others = {"Views": views, "Welcome page": self.welcome, "User guide": self.help}
        self.help.explain({**others, **context.docks.pages()})
        context.actions.add(commands(context, self, self.messages, self.help))
        context.actions.fill(self.menuBar(), MENUS)
        self.bars = Toolbars(self, context)
        self._lay_out()
        self._show_welcome()

    def _lay_out(self) -> None:
        self.setAcceptDrops(True)
        options = QtWidgets.QMainWindow.DockOption
        self.setDockOptions(
            options.AnimatedDocks | options.AllowTabbedDocks | options.AllowNestedDocks
        )
        for corner in (Qt.Corner.BottomLeftCorner, Qt.Corner.BottomRightCorner):
            self.setCorner(corner, Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setMinimumSize(900, 600)
        self.resize(_USUAL.boundedTo(self.screen().availableSize() - _FRAME))
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
        self.context.actions.action("play").setIcon(icon_named("pause" if playing else "play"))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.context.docks.leave_room()

    def focusNextPrevChild(self, forward: bool) -> bool:
        return self.context.docks.focus.step(forward)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Close when all that was promised is written; exports are waited for only once."""
        if self.asks_before_quitting and (lost := self.context.session.would_be_lost()):
            event.ignore()
            self._ask_first("Quit", lost, self._quit)
            return
        tasks, exports = self.context.tasks, not self._is_told_to_close
        if waits_for := tasks.promised(exports=exports):
            event.ignore()
            self._is_told_to_close = True
            tasks.after_writes(self._close_soon, exports=exports)
            what = "the window closes when everything is written"
            exporting = len(waits_for) > len(tasks.promised())
            again = "Close it again to stop exports." if exporting else ""
            titles = ", ".join(task.title for task in waits_for)
            self.context.notifier.show(Message("note", what, titles, again))
            return
        self.context.docks.leave()
        self.context.settings.setValue("geometry", self.saveGeometry())
        self.context.session.close()
        self.context.settings.sync()
        event.accept()

    def _ask_first(self, what: str, lost: Sequence[str], do: Callable[[], object]) -> None:
        if not (lost and self.asks_before_quitting):
            do()
            return
        trials, session = self.context.session.trials, self.context.session
        box = QtWidgets.QMessageBox(
            QtWidgets.QMessageBox.Icon.Question, what, f"{what} now? This would be lost:"
        )
        box.setParent(self, Qt.WindowType.Dialog)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setInformativeText("\n".join(f"• {words}" for words in lost))
        agrees = box.addButton(what, QtWidgets.QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QtWidgets.QMessageBox.StandardButton.Cancel))
        stores = QtWidgets.QCheckBox("Store the trials as runs of the project")
        if trials.lost_words() and not session.no_edit():
            box.setCheckBox(stores)

        def answered() -> None:
            if box.clickedButton() is agrees:
                if stores.isChecked():
                    trials.keep()
                do()

        box.finished.connect(answered)
        box.open()

    def _quit(self) -> None:
        self.asks_before_quitting = False
        self.close()

    def _close_soon(self) -> None:
        QTimer.singleShot(0, self, lambda: self.isVisible() and self.close())

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if _dropped_paths(event.mimeData()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        if paths := _dropped_paths(event.mimeData()):
            event.acceptProposedAction()
            self.context.session.open_all(paths)


def _dropped_paths(data: QMimeData) -> tuple[Path, ...]:
    """What was dragged into the window and can be opened."""
    paths = [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
    return tuple(path for path in paths if opens(path))
