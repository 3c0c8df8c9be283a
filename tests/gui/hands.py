"""What somebody who annotates does in the real window, as mouse and key events."""

import numpy as np
from PySide6.QtCore import QPoint, QPointF, QSettings, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.program import make_window
from app.session.changes import Part
from app.session.jobs import Processes
from app.shell.main_window import MainWindow
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.recording.landmarks import LANDMARKS

NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
CTRL = Qt.KeyboardModifier.ControlModifier
ALT = Qt.KeyboardModifier.AltModifier
LEFT, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton


def window_with(settings: QSettings, processes: Processes | None = None) -> MainWindow:
    """The window with its features at hand; by default it shows whole pictures."""
    if not settings.contains("open_zoomed"):
        settings.setValue("open_zoomed", False)
    window, window.features = make_window(settings, processes)
    window.asks_before_quitting = False
    return window


def heard(window: MainWindow) -> list:
    """Messages that the window shows from now on."""
    said, show = [], window.messages.show_message

    def show_message(message) -> None:
        said.append(message)
        show(message)

    window.messages.show_message = show_message
    return said


def frames_shown(window: MainWindow) -> list:
    """Frames that the window goes to from now on."""
    seen, session = [], window.context.session
    session.changes.watch(Part.FRAME, lambda: seen.append(session.document.frame))
    return seen


def double_click(widget, place: QPoint) -> None:
    """Click twice; the test library's own event leaves the button down, and the mouse captured."""
    QTest.mouseDClick(widget, LEFT, pos=place)
    QTest.mouseRelease(widget, LEFT, pos=place)


def wheel_event(widget, place: QPointF, steps: int) -> QWheelEvent:
    """The wheel turned away from a person, over a place of a widget."""
    where, turned, phase = widget.mapToGlobal(place), QPoint(0, 120 * steps), Qt.ScrollPhase
    button = Qt.MouseButton.NoButton
    return QWheelEvent(place, where, QPoint(), turned, button, NONE, phase.NoScrollPhase, False)


def view(window, name="N"):
    return window.context.docks.views.tiles[name].camera


def at(window, x, y, name="N") -> QPoint:
    return view(window, name).place_of(x, y).toPoint()


def click(window, x, y, name="N", modifiers=NONE, button=LEFT):
    """Click near a raw pixel; the raw pixel that the cursor really was on."""
    place = at(window, x, y, name)
    pixel = view(window, name).pixel_at(place.toPointF())
    QTest.mouseClick(view(window, name), button, modifiers, place)
    return pixel.x(), pixel.y()


def in_window(window, x, y, name="N") -> QPoint:
    """Where a raw pixel is in the whole window."""
    return view(window, name).mapTo(window, at(window, x, y, name))


def point(window, x, y, name="N"):
    """Move the mouse as the screen does, so that views are entered and left."""
    place = in_window(window, x, y, name)
    for near in (place + QPoint(1, 1), place):  # a mouse that rests already would tell nothing
        QTest.mouseMove(window.windowHandle(), near)
    QApplication.processEvents()


def point_and_click(window, x, y, name="N", modifiers=NONE):
    """Go there and click, as the screen tells it; the raw pixel that the cursor really was on."""
    point(window, x, y, name)
    place = in_window(window, x, y, name)
    pixel = view(window, name).pixel_at(view(window, name).mapFrom(window, place).toPointF())
    QTest.mouseClick(window.windowHandle(), LEFT, modifiers, place)
    QApplication.processEvents()
    return pixel.x(), pixel.y()


def drag(window, start, end, name="N", button=LEFT):
    QTest.mousePress(view(window, name), button, NONE, start)
    QTest.mouseMove(view(window, name), (start + end) / 2)
    QTest.mouseMove(view(window, name), end)
    QTest.mouseRelease(view(window, name), button, NONE, end)


def key(window, code, modifiers=NONE, name="N"):
    """Press a key while a view has the focus, as it has after a click."""
    view(window, name).setFocus()
    QTest.keyClick(view(window, name), code, modifiers)


def settle(window, qtbot):
    """Wait until what was asked for is done and shown."""
    qtbot.waitUntil(window.context.tasks.settled)


def show_workspace(window, qtbot, name):
    """Show a workspace and wait until all of it is there."""
    window.context.docks.show_named(name)
    settle(window, qtbot)


def trigger(window, name, qtbot=None):
    """Choose a command that can be done now; with the bot, wait until what it asks for is done."""
    window.context.actions.refresh()
    action = window.context.actions.action(name)
    assert action.isEnabled(), action.statusTip()
    action.trigger()
    if qtbot is not None:
        settle(window, qtbot)


def clicks(window, frame=None):
    frame = window.context.session.document.frame if frame is None else frame
    return {
        (c.camera, c.landmark): c for c in window.context.session.project.project.clicks.at(frame)
    }


def undo_words(window):
    return window.context.session.project.project.history.to_undo().words


def truth(window, landmark, name="N"):
    recording = window.context.session.document.recording
    place = int(np.searchsorted(recording.reference.frame, window.context.session.document.frame))
    point = recording.reference.points[place][LANDMARKS.index(landmark)]
    pixel = recording.reference_camera(recording.view(name)).project(point)
    return float(pixel[0]), float(pixel[1])


def click_truth(window, landmark, name="N", shift=(0.0, 0.0)):
    window.features.annotate.clicking.annotating.choose(landmark)
    x, y = truth(window, landmark, name)
    return click(window, x + shift[0], y + shift[1], name)


def annotate_all(window, qtbot, shifts=None):
    for name in ("N", "S"):
        for landmark in NINE.names:
            click_truth(window, landmark, name, (shifts or {}).get((name, landmark), (0.0, 0.0)))
    qtbot.waitUntil(window.context.tasks.settled)
