"""Somebody opens a recording, looks around and closes the window again."""

import gc
import threading
import weakref

import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox

from app.start import WORKSPACE_NAMES
from app.widgets.camera.camera_view import CameraView
from tests.gui.hands import double_click, frames_shown, trigger, wheel_event
from tests.gui.kept_window import close_window, open_recording, show_window

pytestmark = pytest.mark.window


def shown(window) -> set[int]:
    """Frames that the views have."""
    return {tile.camera.picture.frame for tile in window.context.docks.views.tiles.values()}


def press(qtbot, window, key, modifier=Qt.KeyboardModifier.NoModifier):
    window.activateWindow()
    QTest.keyClick(window, key, modifier)


def go(qtbot, window, frame):
    window.context.session.document.go_to(frame)
    qtbot.waitUntil(lambda: shown(window) == {frame})


def test_the_welcome_page_offers_ways_to_begin(window):
    assert window.context.docks.middle.currentWidget() is window.welcome
    assert window.welcome.open_button.isVisible()
    assert window.welcome.demo_button.isVisible()
    assert "no recording" in window.status.state.text()


def test_a_folder_without_a_recording_is_said_and_nothing_is_lost(opened, qtbot, tmp_path):
    opened.context.session.open(tmp_path)
    qtbot.waitUntil(lambda: opened.messages.message is not None)
    words = opened.messages.text()
    assert str(tmp_path) in words
    assert "Traceback" not in words
    assert opened.context.session.document.recording is not None


def test_arrow_keys_step_and_all_views_follow(opened, qtbot):
    for key, frame in (
        (Qt.Key.Key_Right, 1),
        (Qt.Key.Key_Period, 2),
        (Qt.Key.Key_Left, 1),
        (Qt.Key.Key_Comma, 0),
        (Qt.Key.Key_Left, 0),
        (Qt.Key.Key_End, 7),
        (Qt.Key.Key_Right, 7),
        (Qt.Key.Key_Home, 0),
    ):
        press(qtbot, opened, key)
        qtbot.waitUntil(lambda frame=frame: shown(opened) == {frame})
        assert opened.context.session.document.frame == frame
        assert opened.context.docks.transport.number.value() == frame
        assert opened.context.docks.timeline.frame == frame


def test_space_plays_to_the_end_and_stops_there(opened, qtbot):
    seen = frames_shown(opened)
    press(qtbot, opened, Qt.Key.Key_Space)
    assert opened.context.session.document.playing
    qtbot.waitUntil(lambda: not opened.context.session.document.playing)
    assert opened.context.session.document.frame == 7
    assert seen == sorted(seen)


def test_the_wheel_zooms_at_the_cursor(opened, qtbot):
    camera: CameraView = opened.context.docks.views.tiles["N"].camera
    place = QPointF(camera.width() * 0.3, camera.height() * 0.4)
    before = camera.pixel_at(place)
    QApplication.sendEvent(camera, wheel_event(camera, place, 3))
    assert camera.zoom > 1.5
    after = camera.pixel_at(place)
    assert abs(after.x() - before.x()) < 1e-6
    assert abs(after.y() - before.y()) < 1e-6
    double_click(camera, place.toPoint())
    assert camera.zoom == 1.0


def test_dragging_moves_an_enlarged_picture(opened, qtbot):
    camera = opened.context.docks.views.tiles["N"].camera
    camera.zoom_by(4.0)
    before = camera.place_of(300.0, 200.0)
    start = camera.rect().center()
    QTest.mousePress(camera, Qt.MouseButton.MiddleButton, pos=start)
    QTest.mouseMove(camera, start + QPoint(10, 6))
    QTest.mouseMove(camera, start + QPoint(30, 18))
    QTest.mouseRelease(camera, Qt.MouseButton.MiddleButton, pos=start + QPoint(30, 18))
    after = camera.place_of(300.0, 200.0)
    assert (after - before).x() == pytest.approx(30, abs=1)
    assert (after - before).y() == pytest.approx(18, abs=1)


def test_the_pixel_under_the_cursor_is_told(opened, qtbot):
    camera = opened.context.docks.views.tiles["S"].camera
    place = camera.place_of(100.0, 50.0).toPoint()
    QTest.mouseMove(camera, place + QPoint(1, 1))
    QTest.mouseMove(camera, place)
    expected = camera.pixel_at(QPointF(place))
    # A display server tells of the first of two moves too, and when it likes.
    told = f"S  x {expected.x():.1f}"
    qtbot.waitUntil(lambda: opened.status.pixel.text().startswith(told))


@pytest.mark.parametrize("name", WORKSPACE_NAMES)
def test_every_workspace_fits_the_smallest_screen(opened, qtbot, name):
    space = next(one for one in opened.context.docks.workspaces if one.name == name)
    qtbot.mouseClick(
        opened.bars.workspaces.widgetForAction(
            opened.context.actions.action(f"workspace_{space.name}")
        ),
        Qt.MouseButton.LeftButton,
    )
    qtbot.waitUntil(opened.context.tasks.settled)
    assert opened.context.docks.workspace == name
    assert opened.width() <= 1366
    assert opened.height() <= 768
    below = [(names,) if isinstance(names, str) else names for names in space.bottom]
    for panels in (*space.side, *below):
        docks = [opened.context.docks.dock(name) for name in panels]
        # those behind another tab lie outside the window
        seen = [dock for dock in docks if dock.geometry().intersects(opened.rect())]
        assert seen or not panels
        assert all(dock.height() > 60 and dock.width() > 150 for dock in seen)
    for tile in opened.context.docks.views.tiles.values():
        assert tile.camera.height() >= 100, "a view is squeezed"


def test_a_workspace_comes_back_as_it_was_left(opened):
    def shown():
        docks = opened.context.docks
        return {name for name in docks.titles() if docks.is_shown(name)}

    first = {}
    for name in (*WORKSPACE_NAMES, *WORKSPACE_NAMES[::-1]):
        opened.context.docks.show_named(name)
        assert shown() == first.setdefault(name, shown()), name


def test_the_reference_is_painted_where_the_camera_sees_it(opened, qtbot):
    camera = opened.context.docks.views.tiles["N"].camera
    with_reference = camera.grab().toImage()
    head = camera.picture.overlay.reference[6]
    place = camera.place_of(*head).toPoint()
    assert with_reference.pixelColor(place).lightness() > 200, "the head's dot is white"
    press(qtbot, opened, Qt.Key.Key_R)
    assert camera.grab().toImage() != with_reference


def test_disparity_and_foreground_are_shown_at_the_same_instant(opened, qtbot):
    none, shift = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ShiftModifier
    keys = [(key, none) for key in (Qt.Key.Key_F3, Qt.Key.Key_F4, Qt.Key.Key_F5, Qt.Key.Key_F2)]
    for key, modifier in (*keys, (Qt.Key.Key_F2, shift)):
        press(qtbot, opened, key, modifier)
        qtbot.waitUntil(opened.context.tasks.settled)
        kinds = {tile.camera.picture.kind for tile in opened.context.docks.views.tiles.values()}
        assert kinds == {opened.context.view_state.kinds["N"]}
        assert all(
            t.camera.picture.pixels is not None for t in opened.context.docks.views.tiles.values()
        )
        press(qtbot, opened, Qt.Key.Key_Right)
        qtbot.waitUntil(lambda: shown(opened) == {opened.context.session.document.frame})


def test_closing_the_recording_goes_back_to_the_welcome_page(opened, qtbot):
    trigger(opened, "close")
    assert opened.context.docks.middle.currentWidget() is opened.welcome
    assert opened.welcome.recent.count() == 1
    assert not opened.context.actions.action("run").isEnabled()


def test_nothing_opens_in_a_closed_window(qtbot, settings, processes, kept, small_recording):
    kept.close()
    made = show_window(qtbot, settings, processes)
    qtbot.addWidget(made)
    session = made.context.session
    session.open(small_recording)
    (reading,) = made.context.tasks.tasks
    assert reading.join(60.0), "it is done, and nobody has been told"
    close_window(made)
    session.open(small_recording)
    QTest.qWait(300)
    assert session.document.recording is None
    assert not session.document.opening
    assert "frames read" not in {thread.name for thread in threading.enumerate()}


def test_nothing_of_a_closed_window_is_left(qtbot, settings, processes, kept, small_recording):
    """What Qt holds, such as a function that a signal is given, is beyond Python's collector."""
    kept.close()
    made = show_window(qtbot, settings, processes)
    open_recording(made, qtbot, small_recording)
    for name in WORKSPACE_NAMES:
        trigger(made, f"workspace_{name}", qtbot)
    close_window(made)
    left = weakref.ref(made)
    made.deleteLater()
    del made
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    assert left() is None


def test_closing_a_recording_asks_where_trials_would_be_dropped(newly_opened, qtbot, monkeypatch):
    window, session, kept = newly_opened, newly_opened.context.session, []
    monkeypatch.setattr(window, "asks_before_quitting", True)
    monkeypatch.setattr(session.trials, "lost_words", lambda: "" if kept else "2 trials")
    monkeypatch.setattr(session.trials, "keep", lambda: kept.append("both"))

    def asked(do, button, *, stores=False):
        do()
        box = window.findChild(QMessageBox)
        assert box.informativeText() == "• 2 trials"
        box.checkBox().setChecked(stores)
        QTest.mouseClick(
            next(one for one in box.buttons() if button in one.text()), Qt.MouseButton.LeftButton
        )
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)

    def close():
        QTest.keyClick(window, Qt.Key.Key_W, Qt.KeyboardModifier.ControlModifier)

    asked(close, "Cancel")
    asked(lambda: session.open(session.document.recording.folder, frame=2), "Cancel")
    assert session.document.recording is not None
    assert session.document.frame == 0
    asked(close, "Close", stores=True)
    qtbot.waitUntil(lambda: session.document.recording is None)
    assert kept == ["both"]


def test_quitting_asks_where_something_would_be_lost(settings, failures, processes, kept, qtbot):
    kept.close()
    window = show_window(qtbot, settings, processes)
    qtbot.addWidget(window)
    window.asks_before_quitting = True
    window.context.session.losses.append(lambda: "a calibration that is not saved")
    for button in ("Cancel", "Quit"):
        window.close()
        assert window.isVisible()
        box = window.findChild(QMessageBox)
        assert "a calibration that is not saved" in box.informativeText()
        assert box.checkBox() is None, "there are no trials that could be stored"
        next(one for one in box.buttons() if button in one.text()).click()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    assert not window.isVisible()
    close_window(window)
    assert not failures
