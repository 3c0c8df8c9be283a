"""Videos without a calibration: the message leads to a file, to the board, and to the person."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from app.features.calibrate.person import PersonDialog
from app.features.project.importing.calibration_page import AttachDialog
from stereotrack_core.annotation.click import Click
from stereotrack_core.calibrate import person as person_work
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.formats import write_foreign
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui import kept_window
from tests.gui.hands import trigger
from tests.tracking.keypoints.mono import mono_recording, truth

pytestmark = pytest.mark.window


@pytest.fixture
def plain(window, qtbot, tmp_path):
    """The window with four views of guessed cameras, and the true cameras."""
    (tmp_path / "mono").mkdir()
    true = mono_recording(tmp_path / "mono").cameras
    guess = {name: replace(one, camera_from_world=true["N"].camera_from_world)
             for name, one in true.items()}  # fmt: skip
    write_calibration(tmp_path / "mono" / "calibration.toml", guess, guessed=True)
    kept_window.open_recording(window, qtbot, tmp_path / "mono", workspace="annotate")
    assert "guessed from the size of the images" in window.messages.text()
    return true


def button_of(window, words):
    bar = window.messages
    buttons = (bar.do_button, *bar.other_buttons)
    return next(one for one in buttons if words in one.text() and one.isVisible())


def press(button):
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def calibrated(window, qtbot):
    """The recording that is open again, with cameras that nobody guessed."""
    session = window.context.session
    qtbot.waitUntil(lambda: session.document.recording and not session.document.recording.guessed)
    qtbot.waitUntil(window.context.tasks.settled)
    assert window.context.docks.workspace == "annotate"
    return session.document.recording


def choose(monkeypatch, path):
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_, **__: (str(path), ""))


def test_a_file_with_the_same_names_is_attached_at_once(
    window, qtbot, plain, tmp_path, monkeypatch
):
    write_calibration(tmp_path / "true.toml", plain)
    choose(monkeypatch, tmp_path / "true.toml")
    press(button_of(window, "Attach a calibration"))
    recording = calibrated(window, qtbot)
    assert recording.cameras["S"].position_world == pytest.approx(plain["S"].position_world)
    assert "calibration-before-1.toml" in window.messages.text()
    assert open_recording(recording.folder).guessed is False
    assert (recording.folder / "calibration-before-1.toml").exists()
    assert "stands elsewhere" not in window.messages.text(), "guessed cameras stood nowhere"

    pose = plain["S"].camera_from_world
    moved = RigidTransform(pose.rotation, pose.translation + np.array([0.0, 0.5, 0.0]))
    write_calibration(
        tmp_path / "moved.toml", {**plain, "S": replace(plain["S"], camera_from_world=moved)}
    )
    choose(monkeypatch, tmp_path / "moved.toml")
    trigger(window, "attach_calibration")
    qtbot.waitUntil(lambda: "calibration-before-2.toml" in window.messages.text())
    assert "A camera stands elsewhere than before" in window.messages.text()


def test_other_names_are_taken_in_order_and_asked_about(
    window, qtbot, plain, tmp_path, monkeypatch
):
    named = [replace(one, name=f"cam{k}") for k, one in enumerate(plain.values())]
    write_foreign(tmp_path / "cameras.toml", named, "aniposelib")
    choose(monkeypatch, tmp_path / "cameras.toml")
    press(button_of(window, "Attach a calibration"))
    dialog = window.findChild(AttachDialog)
    boxes = dialog.page._cameras
    assert {name: box.currentText() for name, box in boxes.items()} == dict(
        zip(plain, ("cam0", "cam1", "cam2", "cam3"), strict=True)
    )
    assert dialog.page.guess.isHidden()
    boxes["O"].setCurrentIndex(0)
    assert not dialog.accept_button.isEnabled()
    assert "Say which camera of the file is O" in dialog.page.words.text()
    boxes["O"].setCurrentIndex(2)
    press(dialog.accept_button)
    recording = calibrated(window, qtbot)
    assert list(recording.cameras) == list(plain)
    assert recording.cameras["O"].position_world == pytest.approx(
        plain["O"].position_world, abs=1e-6
    )


def test_the_message_leads_to_the_board(window, plain):
    press(button_of(window, "Calibrate"))
    assert window.context.docks.workspace == "calibrate"


def test_the_cameras_come_from_the_person(window, qtbot, plain, monkeypatch):
    monkeypatch.setattr(person_work, "_MOST_SHIFT", 0.5)  # eight frames of one pose tell little
    monkeypatch.setattr(person_work, "_MOST_TURN_DEG", 30.0)
    project, points = window.context.session.project.project, truth().points
    clicks = [
        Click(frame, view, name, tuple(camera.project(points[frame, place]).tolist()))
        for frame in range(8)
        for place, name in enumerate(LANDMARKS)
        for view, camera in plain.items()
    ]
    project.apply(place_clicks(tuple(one for one in clicks if one.frame < 2)))
    press(button_of(window, "Calibrate from the person"))
    dialog = window.findChild(PersonDialog)
    press(dialog.accept_button)
    assert "type the length" in dialog.words.text()
    for field, number in ((dialog.length, 350), (dialog.focal, plain["N"].focal)):
        field.setFocus()
        field.selectAll()
        QTest.keyClicks(field, f"{number:g}")
        QTest.keyClick(field, Qt.Key.Key_Tab)
    press(dialog.accept_button)
    qtbot.waitUntil(lambda: "too few clicks" in dialog.words.text())
    assert "2 more frames" in dialog.words.text()

    project.apply(place_clicks(tuple(clicks)))
    press(dialog.accept_button)
    qtbot.waitUntil(lambda: "Use these" in dialog.accept_button.text())
    assert "clicks are met within" in dialog.words.text()
    press(dialog.accept_button)
    recording = calibrated(window, qtbot)
    assert len({tuple(one.position_world.round(2)) for one in recording.cameras.values()}) == 4
    assert "clicks are met within" in window.messages.text()
    assert len(window.context.session.project.project.clicks.at(3)) == 9 * len(plain)
