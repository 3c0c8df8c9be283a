"""A subject's lengths are entered, measured from clicks, kept, and reused."""

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt

from app.features.annotate.subject_dialog import SubjectDialog
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import use_subject
from stereotrack_core.recording.description import Subject

LEFT = Qt.MouseButton.LeftButton
RECORDED = Subject("P2", upper_arm_length=0.30)


@pytest.fixture
def dialog(project, make, shown, tasks):
    return shown(SubjectDialog(project, make.CAMERAS, RECORDED, tasks), 560, 420)


def type_into(qtbot, box, text):
    box.setFocus()
    box.selectAll()
    qtbot.keyClicks(box, text)
    qtbot.keyClick(box, Qt.Key.Key_Tab)


def test_lengths_are_typed_kept_and_used(qtbot, project, dialog):
    type_into(qtbot, dialog.name, "Anna")
    type_into(qtbot, dialog.lengths["torso_length"], "512")
    qtbot.mouseClick(dialog.accept_button, LEFT)
    assert not dialog.isVisible()
    subject = project.subject()
    assert subject.name == "Anna"
    assert subject.torso_length == pytest.approx(0.512)
    assert subject.upper_arm_length == pytest.approx(0.300)
    assert subject.hand_length is None
    assert project.subjects.get("Anna").facts["origin"] == "entered"
    project.undo()
    assert project.subject() is None


def test_a_length_that_nobody_has_is_doubted(qtbot, dialog):
    type_into(qtbot, dialog.lengths["forearm_length"], "25")
    assert "Forearm: 25 mm; a person of this size has about" in dialog.words.text()
    type_into(qtbot, dialog.lengths["forearm_length"], "270")
    assert dialog.words.text() == ""


def test_they_are_measured_from_clicks(qtbot, project, make, dialog):
    tall = replace(AVERAGE, upper_arm_length=0.33, torso_length=0.55)
    project.apply(place_clicks(make.clicks_at(range(20), sigma=1.0, proportions=tall)))
    qtbot.mouseClick(dialog.measure_button, LEFT)
    qtbot.waitUntil(dialog.measure_button.isEnabled)
    qtbot.mouseClick(dialog.take_button, LEFT)
    assert dialog.lengths["upper_arm_length"].value() == pytest.approx(330, abs=4)
    assert dialog.lengths["torso_length"].value() == pytest.approx(550, abs=4)
    qtbot.mouseClick(dialog.accept_button, LEFT)
    assert project.subjects.get("P2").facts["origin"] == "measured from clicks"


def test_files_are_exchanged(project, make, dialog, tmp_path):
    dialog.store(tmp_path / "p2")
    assert (tmp_path / "p2.toml").is_file()
    dialog.name.setText("other")
    dialog.load(tmp_path / "p2.toml")
    assert dialog.draft() == RECORDED
    dialog.load(tmp_path / "missing.toml")
    assert "no such file" in dialog.words.text()


def test_the_subject_in_use_is_shown_and_given_up(qtbot, project, make, shown, tasks):
    project.apply(use_subject(Subject("Bert", torso_length=0.6), "entered"))
    dialog = shown(SubjectDialog(project, make.CAMERAS, RECORDED, tasks), 560, 420)
    assert dialog.name.text() == "Bert"
    assert dialog.lengths["torso_length"].value() == 600
    qtbot.mouseClick(dialog.recorded_button, LEFT)
    assert dialog.draft() == RECORDED
    qtbot.mouseClick(dialog.accept_button, LEFT)
    assert project.subject() is None
