"""The window's project: made, found again, locked, moved; nothing is ever lost or saved by hand."""

import os
import shutil

import pytest
from PySide6.QtCore import QMimeData, QPointF, QSettings, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QMessageBox

from app.__main__ import main
from stereotrack_core.annotation.click import Click
from stereotrack_core.project.clicks import place
from stereotrack_core.project.project import Project
from tests.gui.hands import trigger, window_with

pytestmark = pytest.mark.window


@pytest.fixture
def folder(small_recording, tmp_path):
    """A copy of the recording that a test may have projects beside and move."""
    return shutil.copytree(small_recording, tmp_path / "place" / "walk")


def ready(qtbot, window):
    qtbot.waitUntil(lambda: window.context.session.document.recording is not None)
    qtbot.waitUntil(window.context.tasks.settled)


def open_path(qtbot, window, path):
    window.context.session.open(path)
    qtbot.waitUntil(window.context.tasks.settled)
    ready(qtbot, window)


def clicked(window, frame=0, landmark="head", camera="N_right"):
    window.context.session.project.apply(place(Click(frame, camera, landmark, (100.0, 120.0))))


def test_opening_a_recording_makes_its_project_beside_it(window, qtbot, folder, settings):
    settings.remove("projects_folder")
    open_path(qtbot, window, folder)
    path = folder.parent / "walk.stereotrack"
    assert path.is_file()
    assert window.context.session.project.path == path.resolve()
    assert window.windowTitle() == "small – walk.stereotrack – stereotrack"
    clicked(window)
    trigger(window, "close")
    assert window.context.session.project.project is None
    open_path(qtbot, window, folder)
    assert [c.landmark for c in window.context.session.project.project.clicks.at(0)] == ["head"]
    assert len(list(folder.parent.glob("*.stereotrack"))) == 1


def test_a_project_file_opens_its_recording(window, qtbot, folder, tmp_path):
    path = tmp_path / "mine.stereotrack"
    with Project.create(path, folder, who="A") as project:
        project.apply(place(Click(3, "S_right", "left_hand", (10.0, 20.0))))
        seen = {"frame": 5, "workspace": "annotate", "pictures": {}, "light": {}}
        project.view_settings.set("window", seen)
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    buttons, keys = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    copy = Qt.DropAction.CopyAction
    window.dropEvent(QDropEvent(QPointF(200, 200), copy, data, buttons, keys))
    qtbot.waitUntil(window.context.tasks.settled)
    ready(qtbot, window)
    assert window.context.session.project.path == path
    assert window.context.session.document.recording.folder.resolve() == folder.resolve()
    assert window.context.session.recents() == [path]
    assert len(window.context.session.project.project.clicks.at(3)) == 1
    assert window.context.session.document.frame == 5
    assert window.context.docks.workspace == "annotate"


def test_a_file_that_is_no_project_is_refused_before_a_window_comes(tmp_path, capsys):
    path = tmp_path / "mine.stereotrack"
    path.write_text("this is something else entirely" * 10)
    assert main(["open", str(path)]) == 2
    assert "not a stereotrack project" in capsys.readouterr().err


def test_two_windows_on_one_project(window, qtbot, folder, tmp_path, settings):
    open_path(qtbot, window, folder)
    clicked(window)
    other = window_with(QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat))
    qtbot.addWidget(other)
    other.show()
    open_path(qtbot, other, folder)
    assert other.context.session.project.path == window.context.session.project.path
    assert "read-only" in other.windowTitle()
    words = other.messages.text()
    assert "already open" in words
    assert str(os.getpid()) in words
    assert other.context.session.project.in_use
    assert not other.context.actions.action("undo").isEnabled()
    assert "another program" in other.context.actions.command("undo").why_not()
    before = other.context.session.track.settings
    other.context.session.track.use(before.replaced(iterations=1))

    def active() -> bool:
        other.activateWindow()
        return other.isActiveWindow()

    qtbot.waitUntil(active)
    assert other.context.actions.action("undo").text() == "Undo Set iterations to 1"
    QTest.keyClick(other, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert other.context.session.track.settings == before, "what is not stored is undone"
    assert not other.context.actions.action("undo").isEnabled()
    clicked(other, landmark="left_hand")
    assert {c.landmark for c in window.context.session.project.project.clicks.at(0)} == {"head"}
    assert {c.landmark for c in other.context.session.project.project.clicks.at(0)} == {"head"}, (
        "it can be read"
    )
    other.close()


def test_a_recording_that_has_moved_is_asked_for(window, qtbot, folder, tmp_path, monkeypatch):
    path = tmp_path / "mine.stereotrack"
    with Project.create(path, folder) as project:
        project.apply(place(Click(2, "N_right", "head", (10.0, 20.0))))
    away = tmp_path / "far" / "away" / "elsewhere"
    away.parent.mkdir(parents=True)
    folder.rename(away)
    asked = []

    def answer(_parent, title, *_rest):
        asked.append(title)
        return str(away)

    monkeypatch.setattr(QFileDialog, "getExistingDirectory", answer)
    window.context.session.open(path)
    ready(qtbot, window)
    assert len(asked) == 1
    assert "mine.stereotrack" in asked[0]
    assert window.context.session.project.path == path
    trigger(window, "close")
    open_path(qtbot, window, path)
    assert len(asked) == 1, "it remembers"
    assert len(window.context.session.project.project.clicks.at(2)) == 1


def test_another_recording_is_not_taken_unasked(
    window, qtbot, folder, small_recording, tmp_path, monkeypatch
):
    session = window.context.session
    path = tmp_path / "mine.stereotrack"
    Project.create(path, folder).close()
    other = shutil.copytree(small_recording, tmp_path / "others" / "other")
    text = (other / "recording.toml").read_text()
    (other / "recording.toml").write_text(text.replace('name = "small"', 'name = "another"'))
    calibration = (other / "calibration.toml").read_text()
    (other / "calibration.toml").write_text(calibration.replace("N_left", "N_left_2"))
    (other / "recording.toml").write_text(text.replace('N_left"', 'N_left_2"'))
    shutil.rmtree(folder)
    questions = []
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *a: str(other))

    def cancel(*args):
        questions.append(args[2])
        return QMessageBox.StandardButton.Cancel

    monkeypatch.setattr(QMessageBox, "question", cancel)
    session.open(path)
    qtbot.waitUntil(lambda: bool(questions) or session.document.recording is not None)
    assert questions
    assert "not the recording" in questions[0]
    assert session.document.recording is None
    Project.open(path).close()  # nobody holds it any more


def test_undo_names_the_edit_and_goes_to_its_frame(window, qtbot, folder):
    open_path(qtbot, window, folder)
    book = window.context.actions
    assert "nothing to undo" in book.command("undo").why_not()
    clicked(window, frame=2)
    clicked(window, frame=6, landmark="left_hand")
    qtbot.waitUntil(lambda: book.action("undo").isEnabled())
    assert book.action("undo").text() == "Undo Place left hand in N_right, frame 6"
    window.context.session.document.go_to(1)
    window.activateWindow()
    QTest.keyClick(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert window.context.session.document.frame == 6
    assert window.context.session.project.project.clicks.at(6) == ()
    QTest.keyClick(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert window.context.session.document.frame == 2
    both = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    QTest.keyClick(window, Qt.Key.Key_Z, both)
    QTest.keyClick(window, Qt.Key.Key_Z, both)
    assert window.context.session.document.frame == 6
    assert len(window.context.session.project.project.clicks.at(6)) == 1
    assert not book.action("redo").isEnabled()
