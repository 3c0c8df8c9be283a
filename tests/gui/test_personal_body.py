"""A run fails, a frame is clicked, the stretch is tracked again; then the body is personalised."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

from app.session.runs import entry_of_run
from stereotrack_core.annotation.click import Click
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import assembled
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from tests.gui.hands import click, undo_words, view
from tests.gui.kept_window import open_recording
from tests.tracking.recordings import write_depth_recording
from tests.tracking.running import tracked_frames
from tests.tracking.scenes import pose_with_arms

pytestmark = [pytest.mark.window, pytest.mark.slow]

LEFT, CONTROL = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier
FRAMES = range(14)
SETTINGS = preset("fast").replaced(pixel_step=1, speckle_size=0, search_arms=False, data_points=400)


def _pose(k):
    return pose_with_arms(
        [1, 0.1 * k, 0], [1, 0.2, 0], [-1, 0.1, 0], [-1, 0.1 * k, 0.1], place=(0, 0, 0.95)
    )


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    body = body_model(AVERAGE, SETTINGS.body)
    folder = tmp_path_factory.mktemp("recording") / "cones"
    return write_depth_recording(folder, body, [_pose(k) for k in FRAMES])


@pytest.fixture(scope="module")
def failing(recording):
    """A run whose left hand is somewhere else in frames 5 to 8."""
    unaided = dataclasses.replace(recording, reference=None)
    found, done = tracked_frames(unaided, RunSpec(SETTINGS, "fast", frames=FRAMES))
    frames, origin = [one.without_cloud() for one in found], done.origin()
    for k in range(5, 9):
        points = frames[k].landmarks.copy()
        points[LANDMARKS.index("left_hand")] = points[LANDMARKS.index("left_elbow")]
        points[LANDMARKS.index("left_hand"), 2] -= 0.3
        frames[k] = dataclasses.replace(frames[k], landmarks=points)
    return assembled(frames, origin.state_names, origin.meta)


@pytest.fixture
def annotating(window, qtbot, recording, failing):
    open_recording(window, qtbot, recording.folder)
    session = window.context.session
    qtbot.waitUntil(lambda: session.project.project is not None)
    session.runs.add(entry_of_run(failing, Path("first.npz")))
    window.context.docks.show_workspace("annotate")
    window.context.docks.dock("body").raise_()
    qtbot.waitUntil(window.context.tasks.settled)
    return window


def button(window, action):
    """The button of a command in the panel Body fit."""
    wanted = window.context.actions.action(action)
    body = window.features.annotate.clicking.body
    return next(one for one in body.findChildren(QToolButton) if one.defaultAction() is wanted)


def clicked(recording, frame, but=()):
    return [
        Click(frame, name, landmark, tuple(camera.project(recording.reference.points[frame, k])))
        for name, camera in recording.cameras.items()
        for k, landmark in enumerate(LANDMARKS)
        if landmark not in but
    ]


def test_a_failure_is_clicked_and_tracked_again(annotating, qtbot, recording):
    window, session = annotating, annotating.context.session
    annotate, first = window.features.annotate, session.runs.active
    session.document.go_to(6)
    qtbot.waitUntil(lambda: annotate.clicking.body.hint.text().startswith("The run fails here"))
    retrack = button(window, "annotate-retrack")
    qtbot.waitUntil(lambda: "No landmark is clicked" in retrack.toolTip())
    qtbot.waitUntil(lambda: view(window).painted_frame == 6 == view(window, "O").painted_frame)
    for name in ("N", "O"):
        x, y = recording.cameras[name].project(recording.reference.points[6, 0])
        click(window, x, y, name)
    session.project.apply(place_clicks(clicked(recording, 6, but=("left_hand",))))
    qtbot.waitUntil(retrack.isEnabled)
    QTest.mouseClick(retrack, LEFT)
    qtbot.waitUntil(lambda: session.runs.active is not first)
    qtbot.waitUntil(window.context.tasks.settled)
    again = session.runs.active
    assert again.name == "first, re-tracked 0–13"
    assert again.stored.meta["retracked"] == [[0, 13]]
    away = np.linalg.norm(again.at(6).landmarks - recording.reference.points[6], axis=1)
    assert away.max() < 0.06
    assert not first.visible
    personalised(window, qtbot, recording)


def personalised(window, qtbot, recording):
    session = window.context.session
    personalise = button(window, "annotate-personalise")
    window.context.actions.refresh()
    assert "1 frame clicked so far" in personalise.toolTip()
    for frame in (2, 10):
        session.project.apply(place_clicks(clicked(recording, frame)))
    qtbot.waitUntil(personalise.isEnabled)
    QTest.mouseClick(personalise, LEFT)
    qtbot.waitUntil(lambda: bool(session.project.subject().offsets))
    said = window.messages.text()
    assert "personalised from 3 clicked frames" in said
    assert "The trunk leans " in said
    assert len(session.project.subject().offsets) == 9
    assert session.project.subject() == session.project.project.subject()
    assert session.track.kept.recording.subject == session.project.subject()
    assert undo_words(window) == "use subject P, personalised"
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    QTest.keyClick(window, Qt.Key.Key_Z, CONTROL)
    assert session.project.subject() == recording.subject
