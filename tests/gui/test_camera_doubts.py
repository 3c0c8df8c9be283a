"""A camera that contradicts the others is named in the window, instead of its clicks."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton

from app.features.annotate.clicking.marks import fit_words as words_of_frame
from stereotrack_core.annotation.click import Click
from stereotrack_core.project.clicks import delete_clicks, place_clicks
from stereotrack_core.project.exporting import ClickedRecording
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui.hands import trigger

pytestmark = pytest.mark.window


def true_clicks(window, frames, shifted="", by=(0.0, 0.0)):
    """Clicks where everything is, in one camera's image all beside it."""
    recording = window.context.session.document.recording
    found = []
    for frame in frames:
        for view in recording.views:
            camera = recording.reference_camera(view)
            pixels = camera.project(recording.reference.points[frame])
            for name, (x, y) in zip(LANDMARKS, pixels.tolist(), strict=True):
                dx, dy = by if camera.name == shifted else (0.0, 0.0)
                found.append(Click(frame, camera.name, name, (x + dx, y + dy)))
    return tuple(found)


def place(window, qtbot, clicks):
    window.context.session.project.project.apply(place_clicks(clicks))
    qtbot.waitUntil(window.context.tasks.settled)


def test_the_camera_is_named_wherever_its_clicks_would_be_blamed(four, qtbot):
    clicks = true_clicks(four, range(3), "O_right", (32.0, 24.0))
    place(four, qtbot, clicks)
    words = "O disagrees with the other three by 40 px"
    assert words in four.messages.text()
    assert "Check its calibration and synchronisation" in four.messages.text()
    assert four.features.calibrate.findings.verdict.text() == "Usable, with 1 warning."
    assert words in four.features.calibrate.findings.tree.cells.cell(0, 1).text
    facts = four.features.annotate.clicking.facts.now()
    assert facts.fit is not None
    said = words_of_frame(facts)
    assert said[0].startswith(words)
    assert four.features.annotate.clicking.body.words.text().startswith(words)
    assert not any("in O: " in one for one in said)
    assert not any(mark.outlier for mark in four.context.docks.views.tiles["O"].camera.marks.clicks)
    told = []  # what the status line says goes by itself
    four.statusBar().messageChanged.connect(told.append)
    four.features.annotate.panels.reference.fit()
    qtbot.waitUntil(lambda: four.features.annotate.panels.reference.now is not None)
    qtbot.waitUntil(four.context.tasks.settled)
    now = four.features.annotate.panels.reference.now
    assert words in now.words
    assert now.outliers == ()
    assert "look like outliers" not in now.words
    assert len(now.fit.flagged()) > 10, "what would have been blamed"
    assert any("O disagrees" in one for one in told)


def test_the_message_comes_once_and_goes_with_its_cause(four, qtbot):
    session = four.context.session
    clicks = true_clicks(four, range(2), "O_right", (32.0, 24.0))
    place(four, qtbot, clicks)
    assert "O disagrees" in four.messages.text()
    four.messages.dismiss()
    place(four, qtbot, true_clicks(four, [2], "O_right", (32.0, 24.0)))
    assert session.cameras.now is not None
    assert four.messages.message is None, "somebody has read it"
    keys = tuple(one.key for one in session.project.project.clicks.all() if one.camera == "O_right")
    session.project.project.apply(delete_clicks(keys))
    qtbot.waitUntil(four.context.tasks.settled)
    assert session.cameras.now is None
    assert four.features.calibrate.findings.verdict.text() == "Usable; no problems found."


def test_it_is_left_out_by_one_button_and_comes_back_by_undo(four, qtbot):
    place(four, qtbot, true_clicks(four, range(3), "O_right", (32.0, 24.0)))
    session, clicking = four.context.session, four.features.annotate.clicking
    project = session.project.project
    (button,) = (one for one in four.messages.findChildren(QAbstractButton) if "out" in one.text())
    assert button.text() == "Leave O out"
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(four.context.tasks.settled)
    assert session.cameras.now is None, "the others agree"
    assert clicking.body.words.text().startswith("Left out: O.")
    fit = clicking.facts.now().fit
    assert {key.camera for key in fit.residuals} == {"N_right", "S_right", "W_right"}
    assert not clicking.facts.now().fit_is_old, "it is of all clicks that count"
    clicking.annotating.choose("head")
    offer = four.context.docks.views.tiles["O"].camera.marks.offer
    assert offer.words == "move head here (this camera is left out)"
    used = four.context.actions.action("annotate-camera-2")
    assert (used.text(), used.isChecked()) == ("Use O", False)
    assert not clicking.facts.now().fit_is_old, "it is the fit of the clicks that count"
    clicked = ClickedRecording.of(project, session.document.recording)
    assert len(clicked.clicks) == 81
    assert clicked.left_out == ["O_right"]
    assert project.clicks.count() == 108
    trigger(four, "undo", qtbot)
    assert not project.marks.unused_cameras()
    assert session.cameras.now is not None


def test_the_panel_has_a_box_for_each_camera_which_leaves_it_out_as_one_step(four, qtbot):
    place(four, qtbot, true_clicks(four, range(3), "O_right", (32.0, 24.0)))
    session, cameras = four.context.session, four.features.annotate.clicking.body.cameras
    four.context.docks.bring_up("body")
    shown = {box.text(): box for box in cameras.boxes if not box.isHidden()}
    assert {name: box.isChecked() for name, box in shown.items()} == dict.fromkeys("NOSW", True)
    assert "O disagrees with the other three by 40 px. Use O. Let the" in shown["O"].toolTip()
    assert [name for name, box in shown.items() if not box.icon().isNull()] == ["O"]
    shown["O"].click()
    qtbot.waitUntil(four.context.tasks.settled)
    assert session.project.project.marks.unused_cameras() == {"O_right"}
    assert not shown["O"].isChecked()
    assert "disagrees" not in shown["O"].toolTip(), "the others agree"
    four.context.actions.action("undo").trigger()
    qtbot.waitUntil(four.context.tasks.settled)
    assert not session.project.project.marks.unused_cameras()
    assert shown["O"].isChecked()


def test_a_recording_with_a_bad_camera_is_not_called_sound(window, qtbot, shared_recording):
    window.context.session.open(shared_recording("beam-4cam"))
    qtbot.waitUntil(lambda: window.context.session.document.findings is not None)
    qtbot.waitUntil(window.context.tasks.settled)
    assert window.features.calibrate.findings.verdict.text() == "Usable, with 1 warning."
    where = window.features.calibrate.findings.tree.cells.cell(0, 0).text
    assert where == "calibration.toml, view cam03"
