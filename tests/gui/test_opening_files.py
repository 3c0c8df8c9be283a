"""Whatever is named or dropped opens: runs with their recording, recents, damaged projects."""

import re
import shutil
from dataclasses import replace

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog

from stereotrack_core.interop.run_file import write_run
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.recording.reader import FrameReader
from tests.gui.conftest import FRAMES
from tests.gui.hands import settle, trigger
from tests.gui.kept_window import open_recording as show_recording
from tests.gui.made_runs import made_run

pytestmark = pytest.mark.window


@pytest.fixture
def folder(small_recording, tmp_path):
    """A copy of the recording that a test may have runs beside and move."""
    return shutil.copytree(small_recording, tmp_path / "place" / "walk")


@pytest.fixture
def run_file(folder):
    """A run of it, in its own folder beside it."""
    recording = open_recording(folder)
    run = made_run(recording)
    meta = {
        "recording": recording.name,
        "recording_folder": str(folder),
        "fingerprint": fingerprint(recording),
    }
    path = folder.parent / "runs" / "first.npz"
    path.parent.mkdir()
    write_run(path, replace(run, meta={**run.meta, **meta}))
    return path


def drop(window, *paths):
    """Drag files into the window as a file manager does; whether it takes them."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    how = Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    entering = QDragEnterEvent(QPoint(200, 200), *how)
    entering.setAccepted(False)
    window.dragEnterEvent(entering)
    if entering.isAccepted():
        window.dropEvent(QDropEvent(QPointF(200, 200), *how))
    return entering.isAccepted()


def shows(qtbot, window, folder):
    def there():
        recording = window.context.session.document.recording
        return recording is not None and recording.folder.resolve() == folder.resolve()

    qtbot.waitUntil(there)
    settle(window, qtbot)


def accept_offer(qtbot, window):
    """Press the button of the message, when it is painted."""
    button = window.messages.do_button
    qtbot.waitUntil(lambda: not button.visibleRegion().isEmpty())
    QApplication.processEvents()
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def runs(window):
    return [entry.name for entry in window.context.session.runs.entries]


def test_a_run_file_opens_with_its_recording(window, qtbot, folder, run_file):
    assert drop(window, run_file)
    shows(qtbot, window, folder)
    assert runs(window) == ["first"]
    assert drop(window, run_file)
    settle(window, qtbot)
    assert runs(window) == ["first", "first"]
    assert window.context.session.document.recording.folder.resolve() == folder.resolve()


def test_a_run_opens_although_both_have_moved(window, qtbot, folder, run_file):
    away = shutil.move(folder.parent, folder.parent.with_name("away"))
    window.context.session.open(away / "runs" / "first.npz")
    shows(qtbot, window, away / "walk")
    assert runs(window) == ["first"]


def test_the_recording_of_a_run_is_asked_for_where_it_is_not_found(
    window, qtbot, folder, run_file, tmp_path, monkeypatch
):
    away = shutil.move(folder, tmp_path / "far" / "away")
    window.context.session.open(run_file)
    qtbot.waitUntil(lambda: window.messages.message is not None)
    assert "the recording of this run was not found" in window.messages.text()
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(away))
    accept_offer(qtbot, window)
    shows(qtbot, window, away)
    assert runs(window) == ["first"]


def test_what_is_no_run_is_said(window, qtbot, tmp_path):
    path = tmp_path / "broken.npz"
    path.write_bytes(b"PK\x03\x04 and nothing more")
    window.context.session.open(path)
    qtbot.waitUntil(lambda: window.messages.message is not None)
    assert "broken.npz" in window.messages.text()
    assert window.context.session.document.recording is None


def test_recents_stand_in_the_menu(window, qtbot, folder, settings):
    actions = window.context.actions
    actions.refresh()
    assert not actions.action("recent_1").isVisible()
    assert "Nothing was opened yet" in actions.action("forget_recent").toolTip()
    window.context.session.open(folder)
    shows(qtbot, window, folder)
    actions.refresh()
    first = actions.action("recent_1")
    assert first.isVisible()
    assert re.match(r"walk   .*place$", first.text())
    assert not actions.action("recent_2").isVisible()
    trigger(window, "close")
    assert window.welcome.recent.item(0).text().startswith("walk ")
    first.trigger()
    shows(qtbot, window, folder)
    trigger(window, "forget_recent")
    actions.refresh()
    assert not first.isVisible()
    assert folder.is_dir()


def test_a_viewer_at_the_end_stays_there_when_there_are_fewer_frames_than_estimated(
    window, qtbot, small_recording, monkeypatch
):
    known = [(FRAMES, False)]
    monkeypatch.setattr(FrameReader, "frame_count_so_far", lambda _reader: known[-1])
    show_recording(window, qtbot, small_recording)
    document = window.context.session.document
    document.visit(FRAMES - 1)
    qtbot.waitUntil(window.context.tasks.settled)
    known.append((FRAMES - 2, True))
    qtbot.waitUntil(lambda: document.frame_count == FRAMES - 2)
    assert document.frame == FRAMES - 3
    qtbot.waitUntil(lambda: document.frame_set is not None)
