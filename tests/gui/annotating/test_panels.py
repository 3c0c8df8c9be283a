"""The panels of annotation together: an edit anywhere is seen everywhere, commands are edits."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QComboBox, QInputDialog

from app.features.annotate.exchange.agreement import AgreementDialog
from app.features.annotate.exchange.merging import ImportDialog, TakeInDialog
from app.features.annotate.subject_dialog import SubjectDialog
from app.widgets.forms.form_dialog import FormDialog
from app.widgets.forms.numbers import WholeNumberField
from app.widgets.timeline.lanes import Mark
from app.widgets.timeline.painting import RULER_HEIGHT
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.scenarios import scenarios_of
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory, write_landmarks
from tests.gui.annotating.stage import LEFT, select, settled

FRAMES = 60


def lane(stage, name):
    return next(one.values for one in stage.timeline.lanes if one.id == name)


def test_the_selection_is_dragged_and_cleared(qtbot, project, stage):
    select(qtbot, stage, 8, 22)
    assert stage.panels.bar.selection_words.text() == "frames 8 – 22"
    row = 2 * stage.timeline.lane_height + RULER_HEIGHT + 5
    control = Qt.KeyboardModifier.ControlModifier
    qtbot.mouseClick(stage.timeline.viewport(), LEFT, control, QPoint(30, row))
    assert stage.panels.bar.selection_words.text() == "frames 8 – 22, left elbow"
    stage.trigger("clear")
    assert stage.heard[-1] == "Done: delete left elbow in 4 cameras, frames 10 to 20."
    assert project.clicks.count() == 216 - 8
    assert lane(stage, "left_elbow")[10] == Mark.MISSING
    stage.trigger("clear")
    assert "no clicks in frames 8 – 22, left elbow" in stage.problems[-1].what
    project.undo()
    assert lane(stage, "left_elbow")[10] == Mark.CLICKED


def test_keyframes_flags_and_gaps_by_commands(qtbot, project, stage):
    select(qtbot, stage, 0, 59)
    stage.trigger("keyframes")
    dialog = stage.findChild(FormDialog)
    qtbot.keyClicks(dialog.findChild(WholeNumberField), "20")
    dialog.accept_button.click()
    stage.timeline.set_selection(None)
    stage.go_to(20)
    qtbot.keyClick(stage, Qt.Key.Key_K)
    qtbot.waitUntil(lambda: stage.panels.bar.progress.text() == "1 of 3 keyframes done")
    assert not stage.panels.bar.next_button.isEnabled()
    stage.trigger("flag")
    qtbot.waitUntil(lambda: stage.panels.bar.progress.text() == "1 of 3 keyframes done, 1 flagged")
    stage.go_to(5)
    qtbot.mouseClick(stage.panels.bar.next_button, LEFT)
    assert stage.timeline.frame == 20
    qtbot.mouseClick(stage.panels.bar.next_button, LEFT)
    assert stage.heard[-1] == "No frame after this one has a flag."
    select(qtbot, stage, 31, 36)
    stage.trigger("gap")
    assert lane(stage, "head")[33] == Mark.GAP


def test_one_key_fits_fills_lanes_and_goes_to_what_is_next(qtbot, project, stage):
    went = []
    stage.panels.next_panel._visit = lambda *where: went.append(where)
    stage.book.refresh()
    qtbot.keyClick(stage, Qt.Key.Key_J)
    settled(qtbot, stage)
    assert not stage.problems
    assert stage.panels.reference.now is None, "the clicked frames alone were fitted"
    assert len(went) == 1
    stage.trigger("fit")
    settled(qtbot, stage)
    assert lane(stage, "head")[5] == Mark.INTERPOLATED
    torso = next(one for one in stage.timeline.lanes if one.id == "torso ±")
    assert np.isfinite(torso.values).all()
    assert went[0][2] in NINE.names
    qtbot.keyClick(stage, Qt.Key.Key_J)
    assert len(set(went)) == 2
    project.undo()
    project.undo()
    settled(qtbot, stage)
    assert lane(stage, "head")[5] == Mark.NONE
    assert stage.panels.next_panel.tree.cells.rowCount() == 0


def test_clicks_are_imported_after_a_look(qtbot, project, stage, make, tmp_path):
    path = tmp_path / "clicks.csv"
    write_clicks(path, make.clicks_at([0, 5]), stage.panels.recording)
    path.write_text(path.read_text() + "7,N,elbow,1,2,2,clicked,,,,\n")
    stage.trigger("import")
    asking = stage.findChild(ImportDialog)
    qtbot.keyClicks(asking.path, str(path))
    qtbot.mouseClick(asking.accept_button, LEFT)
    qtbot.waitUntil(lambda: stage.findChild(TakeInDialog) is not None)
    dialog = stage.findChild(TakeInDialog)
    assert dialog.summary.text() == "clicks.csv: 36 new, 0 equal, 36 differ (36 moved)."
    assert "unknown landmark 'elbow'" in dialog.problems.toPlainText()
    assert project.clicks.count() == 216
    qtbot.mouseClick(dialog.accept_button, LEFT)
    settled(qtbot, stage)
    assert project.clicks.count() == 252
    assert stage.heard[-1] == "merge 36 clicks from clicks.csv"


def test_selected_frames_get_a_name_and_lose_it(qtbot, project, stage):
    assert not stage.book.action("annotate-name-stretch").isEnabled(), "nothing is selected"
    for first, last in ((10, 20), (40, 50)):
        select(qtbot, stage, first, last)
        stage.trigger("name-stretch")
        dialog = stage.findChildren(QInputDialog)[-1]
        assert dialog.focusWidget() is dialog.findChild(QComboBox), "a name can be typed at once"
        dialog.findChild(QComboBox).clearEditText()
        qtbot.keyClicks(dialog.findChild(QComboBox), "crossing")
        dialog.accept()
    assert scenarios_of(project) == (Segment("crossing", 10, 21), Segment("crossing", 40, 51))
    stage.trigger("forget-stretch")
    stage.findChildren(QInputDialog)[-1].accept()
    assert scenarios_of(project) == ()
    project.undo()
    assert len(scenarios_of(project)) == 2


def test_a_trajectory_becomes_a_reference(qtbot, project, stage, make, tmp_path):
    points = np.stack([make.places_at(k) for k in range(10)])
    write_landmarks(tmp_path / "truth.csv", LandmarkTrajectory(np.arange(10), points))
    stage.dialogs.import_labels(
        LabelSource(tmp_path / "truth.csv", stage.panels.recording, NINE.names)
    )
    settled(qtbot, stage)
    qtbot.waitUntil(lambda: stage.panels.reference.now is not None)
    assert project.chosen(project.references) == "truth"
    assert "uncertainty unknown" in stage.panels.reference.now.words
    stage.dialogs.import_labels(
        LabelSource(tmp_path / "truth.csv", stage.panels.recording, NINE.names)
    )
    qtbot.waitUntil(lambda: bool(stage.problems))
    assert "there is a reference 'truth' already" in stage.problems[-1].what


def test_another_project_is_compared_and_merged(qtbot, project, stage, make, tmp_path):
    path = tmp_path / "other.stereotrack"
    theirs = make.clicks_at([0, 10, 15], sigma=2.0, seed=7)
    with Project.create(path, stage.panels.recording.folder, who="B") as other:
        other.apply(place_clicks(theirs))
    stage.trigger("agreement")
    qtbot.waitUntil(lambda: stage.findChild(AgreementDialog) is not None)
    dialog = stage.findChild(AgreementDialog)
    qtbot.waitUntil(lambda: "Nothing to compare" in dialog.verdict.text())
    stage.dialogs.compare_with(path)
    qtbot.waitUntil(lambda: "click uncertainty" in dialog.verdict.text())
    stage.dialogs.merge(path)
    qtbot.waitUntil(lambda: stage.findChild(TakeInDialog) is not None)
    merging = stage.findChild(TakeInDialog)
    merging.decision.setCurrentIndex(merging.decision.findData("mean"))
    qtbot.mouseClick(merging.accept_button, LEFT)
    settled(qtbot, stage)
    mine, other_x = make.clicks_at(range(0, FRAMES, 10), sigma=1.0)[0], theirs[0].position[0]
    middle = (mine.position[0] + other_x) / 2
    assert project.clicks.get(theirs[0].key).position[0] == pytest.approx(middle)
    assert project.clicks.count() == 252
    project.undo()
    assert project.clicks.count() == 216


def test_a_project_that_can_only_be_read_is_shown(qtbot, project, stage, make):
    recording = stage.panels.recording
    stage.panels.set_project(None, None, 0)
    stage.edits.set_project(None)
    project.close()
    with Project.open(project.path, read_only=True) as read:
        stage.edits.set_project(read)
        stage.panels.set_project(read, recording, FRAMES)
        assert lane(stage, "head")[10] == Mark.CLICKED
        stage.book.refresh()
        for name in ("clear", "gap", "done", "fit", "repeat-now", "merge"):
            assert not stage.book.action(f"annotate-{name}").isEnabled(), name
        for name in ("agreement", "export", "subject"):
            assert stage.book.action(f"annotate-{name}").isEnabled(), name
        stage.dialogs.show_subjects()
        assert not stage.findChild(SubjectDialog).accept_button.isEnabled()
        assert stage.edits.to_undo() is None
        stage.panels.set_project(None, None, 0)
        stage.edits.set_project(None)
    assert not stage.problems


def test_axes_that_a_person_contradicts_are_asked_for(qtbot, project, stage, make, tmp_path):
    """A table with z up in a format whose y is up; its hands have another program's name."""
    points = np.stack([make.places_at(k) for k in range(10)])
    path = tmp_path / "theirs.trc"
    write_trc(path, LandmarkTrajectory(np.arange(10), points[..., [2, 0, 1]]), 10.0)
    path.write_text(path.read_text().replace("left_hand", "LWrist"))
    stage.trigger("import")
    asking = stage.findChild(ImportDialog)
    qtbot.keyClicks(asking.path, str(path))
    qtbot.keyClicks(asking.names, "LWrist=left_hand")
    asking.axes.setCurrentText("x,y")
    qtbot.mouseClick(asking.accept_button, LEFT)
    assert "does not name three axes" in asking.words.text()
    asking.axes.setCurrentIndex(0)
    qtbot.mouseClick(asking.accept_button, LEFT)

    def again():
        shown = [one for one in stage.findChildren(ImportDialog) if one.isVisible()]
        assert len(shown) == 1
        assert "y points up" in shown[0].words.text()
        return shown[0]

    qtbot.waitUntil(lambda: bool(again()))
    assert project.references.names() == ()
    asking = again()
    assert asking.names.text() == "LWrist=left_hand"
    field = asking.axes.lineEdit()
    field.selectAll()
    qtbot.keyClicks(field, "x,y,z")
    qtbot.mouseClick(asking.accept_button, LEFT)
    settled(qtbot, stage)
    qtbot.waitUntil(lambda: stage.panels.reference.now is not None)
    kept = load_reference(project.references, "theirs")
    np.testing.assert_allclose(kept.points, points, atol=1e-9)
