"""A detector's predictions come into the project in the window, are accepted and removed."""

import os
import threading

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.features.annotate.exchange.predictions import PredictionsDialog
from app.features.annotate.filling import predicting
from stereotrack_core.annotation.click import Click
from stereotrack_core.interop.keypoints.reading import write_table
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.predictions import StoredKeypoints
from stereotrack_core.project.project import Project
from stereotrack_core.recording.keypoints import keypoints_of, rows_of
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.gui.hands import trigger
from tests.gui.kept_window import open_recording
from tests.pose_model.installed import installed_detector
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import mono_recording, truth

pytestmark = pytest.mark.window


@pytest.fixture
def opened(window, qtbot, tmp_path):
    """The window with a project of four mono views, and a file of keypoints for each of two."""
    (tmp_path / "mono").mkdir()
    recording = mono_recording(tmp_path / "mono")
    keypoints = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3), seed=3)
    for name in ("N", "S"):
        write_table(tmp_path / f"{name}.csv", keypoints[keypoints.camera == name], recording)
    with (tmp_path / "N.csv").open("a") as file:
        file.write("2,N,tail,3.0,2.0,0.25,0,x\n99,N,nose,3.0,2.0,0.25,0,x\n")
    path = tmp_path / "mono.stereotrack"
    Project.create(path, recording.folder, who="A").close()
    open_recording(window, qtbot, path)
    return window


def imported(window, qtbot, folder):
    """Import both files with the dialog; what it has said before."""
    trigger(window, "annotate-import-predictions")
    dialog = window.findChild(PredictionsDialog)
    dialog.add([folder / "N.csv", folder / "S.csv"])
    qtbot.waitUntil(dialog.settled)
    assert "several files need the name" in dialog.words.text()
    assert not dialog.accept_button.isEnabled()
    QTest.keyClicks(dialog.detector, "rtm")
    qtbot.waitUntil(dialog.accept_button.isEnabled)
    said = dialog.preview.text()
    QTest.mouseClick(dialog.accept_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(window.context.tasks.settled)
    return said


def test_files_are_told_imported_undone_and_removed(opened, qtbot, tmp_path):
    window, session = opened, opened.context.session
    project, action = session.project.project, window.context.actions.action
    project.apply(place_clicks((Click(0, "N", "head", (5.0, 5.0)),)))
    assert not action("run").isEnabled()
    said = imported(window, qtbot, tmp_path)
    count = project.keypoints.sources()["rtm"]
    assert f"{count} keypoints in 8 frames of N, S, detector rtm" in said
    assert "1 keypoint of keypoints that are no part of the body" in said
    assert "1 keypoint of frames that the recording does not have" in said
    proposed = project.predictions.of_source("rtm")
    assert proposed
    assert f"{len(proposed)} landmarks" in said
    assert not any(one.key == (0, "N", "head") for one in proposed)
    assert [one.position for one in project.clicks.all()] == [(5.0, 5.0)]
    assert action("run").isEnabled(), action("run").statusTip()
    assert session.edits.to_undo().words == "import predictions of rtm"

    window.context.docks.show_workspace("annotate")
    session.document.go_to(0)
    qtbot.waitUntil(window.context.tasks.settled)
    tile = window.context.docks.views.tiles["N"].camera
    assert {mark.landmark for mark in tile.marks.predictions} >= {"left_elbow", "left_hand"}

    trigger(window, "undo", qtbot)
    assert project.keypoints.sources() == {}
    assert not project.predictions.of_source("rtm")
    assert not action("run").isEnabled()
    trigger(window, "redo", qtbot)
    assert project.keypoints.sources() == {"rtm": count}
    assert len(project.predictions.of_source("rtm")) == len(proposed)

    window.context.docks.timeline.set_selection(range(2, 4))
    qtbot.waitUntil(window.context.tasks.settled)
    trigger(window, "annotate-accept-detector")
    assert {click.frame for click in project.clicks.all()} == {0, 2, 3}
    window.features.annotate.dialogs.remove_predictions("rtm")
    qtbot.waitUntil(window.context.tasks.settled)
    assert project.keypoints.sources() == {}
    assert session.edits.to_undo().words == "remove predictions of rtm"
    trigger(window, "undo")
    trigger(window, "redo")
    trigger(window, "undo", qtbot)
    assert project.keypoints.sources() == {"rtm": count}


def test_one_of_several_people_is_chosen(opened, qtbot, tmp_path):
    window, project = opened, opened.context.session.project.project
    header, *lines = (tmp_path / "N.csv").read_text().splitlines()
    both = [header]
    for line in lines:
        cells = line.split(",")
        both.append(",".join((*cells[:6], "patient", "x")))
        both.append(",".join((*cells[:3], str(float(cells[3]) + 20), cells[4], "1", "helper", "x")))
    (tmp_path / "both.csv").write_text("\n".join(both) + "\n")
    trigger(window, "annotate-import-predictions")
    dialog = window.findChild(PredictionsDialog)
    assert not dialog.person.isEnabled()
    dialog.add([tmp_path / "both.csv"])
    qtbot.waitUntil(dialog.accept_button.isEnabled)
    assert "2 people (patient, helper): helper is kept in all frames" in dialog.preview.text()
    assert dialog.person.isEnabled()
    dialog.person.setFocus()
    QTest.keyClicks(dialog.person, "p")
    qtbot.waitUntil(dialog.accept_button.isEnabled)
    assert "patient is kept in all frames, as stated" in dialog.preview.text()
    QTest.mouseClick(dialog.accept_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(window.context.tasks.settled)
    kept = project.keypoints.all()
    assert len(kept) == len(lines) - 2
    assert (kept.person == 0).all()


@pytest.fixture
def slow_disk(monkeypatch):
    """Lets keypoints be written only when the test says so; setting it is saying so."""
    ready, put = threading.Event(), StoredKeypoints.put
    ready.set()

    def wait_and_put(self, state):
        assert ready.wait(60.0)
        put(self, state)

    monkeypatch.setattr(StoredKeypoints, "put", wait_and_put)
    yield ready
    ready.set()


@pytest.fixture
def redone(opened, qtbot, slow_disk, tmp_path):
    """The window in which an import was undone and redone, which the disk does not have yet."""
    imported(opened, qtbot, tmp_path)
    trigger(opened, "undo", qtbot)
    assert kept_in(tmp_path) == {}
    slow_disk.clear()
    for _ in range(2):
        trigger(opened, "redo")
        trigger(opened, "undo")
    trigger(opened, "redo")
    return opened


def kept_in(folder):
    """Keypoints by detector that the file has."""
    with Project.open(folder / "mono.stereotrack", read_only=True) as project:
        return project.keypoints.sources()


@pytest.mark.parametrize("how", ["another recording", "the same project", "close recording"])
def test_what_was_redone_is_in_the_file_before_another_one_is_open(
    redone, qtbot, slow_disk, small_recording, tmp_path, how
):
    session, tasks = redone.context.session, redone.context.tasks
    project = session.project.project
    if how == "close recording":
        trigger(redone, "close")
    else:
        path = session.project.path if how == "the same project" else small_recording
        session.open(path)
    qtbot.wait(500)  # time enough to read what is small
    assert session.project.project is project, "it is left when everything is written"
    assert "saving predictions" in [task.title for task in tasks.tasks], "the status line says so"
    slow_disk.set()
    qtbot.waitUntil(lambda: session.project.project is not project)
    qtbot.waitUntil(tasks.settled)
    assert kept_in(tmp_path)["rtm"] > 0


def test_the_window_closes_when_what_was_redone_is_in_the_file(redone, qtbot, slow_disk, tmp_path):
    for _ in range(2):
        redone.close()
        assert redone.isVisible()
        assert "closes when everything is written" in redone.messages.text()
    slow_disk.set()
    qtbot.waitUntil(lambda: not redone.isVisible())
    assert kept_in(tmp_path)["rtm"] > 0


@pytest.fixture
def detector(opened, monkeypatch):
    """The window with an installed detector that sees simulated keypoints, when it may."""
    recording = opened.context.session.document.recording
    seen = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3), seed=3)
    seen = keypoints_of([(*row[:6], DETECTOR_NAME, 0) for row in rows_of(seen)])
    may_go_on = threading.Event()
    may_go_on.set()

    def detect(_recording, _detector, frames, *, on_frame):
        for done, _frame in enumerate(frames, start=1):
            on_frame(done)
            assert may_go_on.wait(60.0)
        return seen[np.isin(seen.frame, list(frames))]

    monkeypatch.setattr(predicting, "is_installed", lambda: True)
    monkeypatch.setattr(predicting, "required_detector", lambda: None)
    monkeypatch.setattr(predicting, "detect_keypoints", detect)
    opened.context.docks.show_workspace("annotate")
    opened.context.actions.refresh()
    return may_go_on


def filled(window, qtbot, frames=None):
    """Fill the frame that is shown, or these, from the detector; all its predictions."""
    window.context.docks.timeline.set_selection(frames)
    qtbot.waitUntil(window.context.tasks.settled)
    trigger(window, "annotate-detect", qtbot)
    return predicted(window)


def predicted(window):
    project = window.context.session.project.project
    return set(project.predictions.of_source(DETECTOR_NAME))


def test_without_a_detector_filling_from_it_says_what_to_install(opened):
    opened.context.docks.show_workspace("annotate")
    action = opened.context.actions.action("annotate-detect")
    assert not action.isEnabled()
    assert "Choose Track, Install pose detector … first" in action.statusTip()


def test_the_first_frame_is_filled_from_the_detector_without_any_click(opened, detector, qtbot):
    window, session = opened, opened.context.session
    project = session.project.project
    first = filled(window, qtbot)
    assert {one.frame for one in first} == {0}
    tile = window.context.docks.views.tiles["N"].camera
    assert {mark.landmark for mark in tile.marks.predictions} >= {"left_elbow", "left_hand"}
    assert f"{len(first)} landmarks predicted" in window.statusBar().currentMessage()
    assert session.edits.to_undo().words == "fill from detector in frame 0"
    trigger(window, "undo", qtbot)
    assert predicted(window) == set()
    assert project.keypoints.sources() == {}
    trigger(window, "redo", qtbot)
    assert predicted(window) == first

    both = filled(window, qtbot, range(2, 4))
    assert first < both, "what was filled before stays"
    assert {one.frame for one in both} == {0, 2, 3}
    trigger(window, "annotate-accept-detector")
    assert {click.frame for click in project.clicks.all()} == {2, 3}


def test_a_stopped_detection_keeps_nothing(opened, detector, qtbot):
    detector.clear()
    action = opened.context.actions.action("annotate-detect")
    opened.context.docks.timeline.set_selection(range(8))
    trigger(opened, "annotate-detect")
    qtbot.waitUntil(lambda: any("frame 1 of 8" in one.words for one in opened.context.tasks.tasks))
    qtbot.waitUntil(lambda: not action.isEnabled())
    opened.context.tasks.cancel_all()
    detector.set()
    qtbot.waitUntil(opened.context.tasks.settled)
    assert predicted(opened) == set()
    assert opened.context.session.project.project.keypoints.sources() == {}
    assert action.isEnabled()


def test_the_real_detector_fills_the_first_frame_of_four_videos(
    window, qtbot, monkeypatch, shared_recording
):
    folder = shared_recording("beam-4cam")
    installed_detector()
    monkeypatch.setenv(FOLDER_VARIABLE, os.environ["STEREOTRACK_TEST_DETECTOR"])
    session = window.context.session
    session.open(folder)
    qtbot.waitUntil(lambda: session.document.frame_set is not None)
    window.context.docks.show_workspace("annotate")
    found = filled(window, qtbot)
    cameras, points = session.document.recording.cameras, session.document.recording.reference
    assert len(found) >= 30
    shoulders = [one for one in found if "shoulder" in one.landmark]
    away = [
        np.hypot(*(cameras[one.camera].project(points.points[0][LANDMARKS.index(one.landmark)])
                   - one.position))
        for one in shoulders
    ]  # fmt: skip
    assert np.median(away) < 25.0, "of 1080 lines"
