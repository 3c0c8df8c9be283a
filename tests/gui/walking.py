"""Doing everything in a window that can be done in it, and noticing what goes wrong."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from pyqtgraph.Qt import isQObjectAlive
from PySide6.QtCore import QObject, Qt, QTimer, QtMsgType, qInstallMessageHandler
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QDialog, QTabBar, QWidget

from app.services.failures import FailureRelay
from app.shell.main_window import MainWindow
from tests.gui.seen_texts import faults_of

_LOOK_MS = 15
_ESCAPES = 3
"""Presses of Escape after which a dialog is closed in another way."""
_MOST_CHOICES = 8
_NOISE = ("propagateSizeHints", "plugin does not support")
"""What Qt's platform without a screen says about every window."""


class Watch:
    """Exceptions that nothing caught, and what Qt complains of, each with what was done then."""

    def __init__(self) -> None:
        self.wrong: list[str] = []
        self.now = ""

    def __enter__(self) -> Watch:
        self._relay = FailureRelay(lambda message: self.note(message.sentence()))
        self._before = qInstallMessageHandler(self._on_qt)
        return self

    def __exit__(self, *_error: object) -> None:
        qInstallMessageHandler(self._before)
        self._relay.remove()

    def note(self, what: str) -> None:
        """Remember something that is wrong."""
        self.wrong.append(f"{self.now}: {what}")

    def _on_qt(self, kind: QtMsgType, _context: object, words: str) -> None:
        if kind != QtMsgType.QtDebugMsg and not any(noise in words for noise in _NOISE):
            self.note(f"Qt: {words}")


class Answers(QObject):
    """Looks at whatever dialog or menu opens, and presses Escape in it.

    It does so as well while somebody waits for the dialog in an event loop of its own.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self.answered: set[str] = set()
        self._watch, self._pressed = watch, 0
        self._timer = QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)

    def start(self) -> None:
        """Begin to answer."""
        self._timer.start()

    def stop(self) -> None:
        """Answer until nothing is open, and no more."""
        end = time.monotonic() + 10.0
        while (left := dialog_over()) is not None and time.monotonic() < end:
            QTest.qWait(_LOOK_MS)
        self._timer.stop()
        if left is not None:
            self._watch.note(f"{left} stays open")
            left.hide()

    def _look(self) -> None:
        shown = dialog_over()
        if shown is None:
            return
        name = f"{type(shown).__name__} {shown.windowTitle()!r}"
        if isinstance(shown, QDialog) and name not in self.answered:
            for fault in faults_of(shown):
                self._watch.note(f"{name}: {fault}")
        self.answered.add(name)
        QTest.keyClick(shown, Qt.Key.Key_Escape)
        self._pressed = self._pressed + 1 if dialog_over() is shown else 0
        if self._pressed > _ESCAPES:
            self._watch.note(f"Escape does not close {name}")
            shown.close()


def dialog_over() -> QWidget | None:
    """What lies over the window: the topmost menu, modal dialog, or any other dialog."""
    app = QApplication.instance()
    others = (w for w in app.topLevelWidgets() if isinstance(w, QDialog) and w.isVisible())
    return app.activePopupWidget() or app.activeModalWidget() or next(others, None)


class Walk:
    """Triggers every command and every control of a window.

    `back` is called after each thing that was done; it brings the window back to the state in which
    things are tried, where it has left it.
    """

    def __init__(self, window: MainWindow, watch: Watch, back: Callable[[], None]) -> None:
        self.window, self.watch, self._back = window, watch, back
        self.done: list[str] = []
        self.answers = Answers(watch)

    def commands(self, besides: frozenset[str]) -> None:
        """Trigger each command that can be done now."""
        actions = self.window.context.actions
        for command in actions.commands:
            actions.refresh()
            if command.id not in besides and actions.action(command.id).isEnabled():
                self._do(f"command {command.id}", actions.action(command.id).trigger)

    def controls(self, workspace: str) -> None:
        """Look at a workspace, and click what is seen in it: buttons, tabs, choices."""
        docks = self.window.context.docks
        docks.show_named(workspace)
        self.settle()
        self.watch.now = f"{workspace or 'welcome'} is seen"
        for fault in faults_of(self.window):
            self.watch.note(fault)
        for control, words in list(self._controls()):
            usable = isQObjectAlive(control) and control.isVisible() and control.isEnabled()
            if not usable:
                continue
            self._do(f"{workspace or 'welcome'}: {words}", _use(control))
            if docks.workspace != workspace:
                docks.show_named(workspace)
                self.settle()

    def settle(self) -> None:
        """Wait until what was asked for is shown."""
        QTest.qWait(50)  # layouts, too
        end = time.monotonic() + 60.0
        while not self.window.context.tasks.settled() and time.monotonic() < end:
            QTest.qWait(_LOOK_MS)

    def _controls(self) -> Iterator[tuple[QWidget, str]]:
        for kind in (QAbstractButton, QComboBox, QTabBar):
            for control in self.window.findChildren(kind):
                if control.isVisible() and control.isEnabled() and control.visibleRegion():
                    yield control, _named(control)

    def _do(self, words: str, do: Callable[[], object]) -> None:
        self.watch.now = words
        self.done.append(words)
        self.answers.start()
        do()
        QApplication.processEvents()
        self.answers.stop()
        self._back()


def _named(control: QWidget) -> str:
    text = control.text() if isinstance(control, QAbstractButton) else ""
    name = text or control.accessibleName() or control.toolTip()[:30] or control.objectName()
    return f"{type(control).__name__} {name!r}"


def _use(control: QWidget) -> Callable[[], None]:
    """What clicks a control, each of its tabs, or takes each of its choices."""

    def click() -> None:
        QTest.mouseClick(control, Qt.MouseButton.LeftButton, pos=control.rect().center())

    def click_each() -> None:
        for index in range(control.count()):
            place = control.tabRect(index).center()
            QTest.mouseClick(control, Qt.MouseButton.LeftButton, pos=place)
            QApplication.processEvents()

    def choose_each() -> None:
        for index in (*range(min(control.count(), _MOST_CHOICES)), control.currentIndex()):
            control.setCurrentIndex(index)
            control.activated.emit(index)
            QApplication.processEvents()
            if not isQObjectAlive(control):
                return

    if isinstance(control, QComboBox):
        return choose_each
    return click_each if isinstance(control, QTabBar) else click
