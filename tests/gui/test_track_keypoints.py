"""Mono views are tracked in the window with the keypoints of the project."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session import keypoints as session_keypoints
from stereotrack_core.interop.run_npz import write_npz
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.project import Project
from stereotrack_core.recording.keypoints import keypoints_of, rows_of
from stereotrack_core.tracking import detecting
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.gui.hands import trigger
from tests.gui.kept_window import open_recording
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import FRAMES, mono_recording, truth

pytestmark = pytest.mark.window


@pytest.fixture
def mono(tmp_path):
    """Path of a project with keypoints of four mono views."""
    (tmp_path / "mono").mkdir()
    recording = mono_recording(tmp_path / "mono")
    keypoints = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3), seed=3)
    path = tmp_path / "mono.stereotrack"
    with Project.create(path, recording.folder, who="A") as project:
        names = tuple(set(keypoints.source.tolist()))
        project.keypoints.put(DetectorState(names, keypoints, ()))
    return path


def test_mono_views_are_tracked_with_the_keypoints_of_the_project(window, qtbot, mono):
    session = window.context.session
    open_recording(window, qtbot, mono)
    action = window.context.actions.action
    assert action("run").isEnabled(), action("run").statusTip()
    trigger(window, "use_keypoints")
    qtbot.waitUntil(lambda: not action("run").isEnabled())
    assert "keypoints of two mono views" in action("run").statusTip()
    trigger(window, "use_keypoints")
    qtbot.waitUntil(lambda: action("run").isEnabled())
    QTest.keyClick(window, Qt.Key.Key_F8)
    qtbot.waitUntil(lambda: session.track.entry is None and len(session.runs.entries) == 1)
    qtbot.waitUntil(window.context.tasks.settled)
    frames = session.runs.active.frames
    assert sorted(frames) == list(range(FRAMES))
    found = np.array([frames[k].landmarks for k in range(FRAMES)])
    assert np.median(np.linalg.norm(found - truth().points, axis=2)) < 0.015
    session.document.go_to(3)
    qtbot.waitUntil(window.context.tasks.settled)
    tried_and_inspected(window, qtbot)
    swept(window, qtbot)


def tried_and_inspected(window, qtbot):
    """A parameter is tried on a stretch, and a step is shown, as with stereo views."""
    context = window.context
    context.view_state.select(range(2, 5))
    context.docks.show_workspace("tune")
    line = window.features.tune.parameters.line
    assert line("keypoint_sigma").isVisibleTo(window)
    assert not line("disparity_count").isVisibleTo(window)
    context.session.track.use(context.session.track.settings.replaced(keypoint_sigma=0.1))
    qtbot.waitUntil(lambda: len(window.features.tune.trials.entries) == 1)
    qtbot.waitUntil(context.tasks.settled)
    trial = window.features.tune.trials.entries[0]
    assert sorted(trial.frames) == [2, 3, 4]
    assert trial.frames[4].tracked
    trigger(window, "look_inside")
    inspect = window.context.session.inspection
    qtbot.waitUntil(lambda: inspect.known is not None)
    assert inspect.known.compared == "The result equals the pose of the run."
    kinds = [step.kind for step in inspect.known.steps[:4]]
    assert kinds == ["predict", "pairs", "sigma", "correct"]
    inspect.go(1)
    assert "There is no cloud" in inspect.step.words
    trigger(window, "look_inside")


def swept(window, qtbot):
    """A sweep takes the keypoints of the project."""
    study, project = window.context.session.study, window.context.session.project.path
    trigger(window, "sweep")
    qtbot.waitUntil(lambda: not study.working)
    (row,) = study.study.rows
    assert study.study.place(row.keypoints) == project
    assert study.rows[0].messages == []
    assert len(study.rows[0].jobs) == 1
    window.features.study.window.close()


@pytest.fixture
def bare(window, qtbot, tmp_path):
    """The window with four mono views and no keypoints."""
    (tmp_path / "mono").mkdir()
    open_recording(window, qtbot, mono_recording(tmp_path / "mono").folder)
    return window


@pytest.fixture
def detector(bare, monkeypatch):
    """The same where the detector is installed."""
    for module in (detecting, session_keypoints):
        monkeypatch.setattr(module, "is_installed", lambda: True)
    bare.context.actions.refresh()
    return bare


def test_without_keypoints_and_detector_it_says_what_would_help(bare):
    tip = bare.context.actions.action("run").statusTip()
    assert "keypoints of two mono views" in tip
    assert "choose Track, Install pose detector …" in tip


def keep(window, qtbot, rows):
    """Let the project have keypoints of a detector, as an import does."""
    session, found = window.context.session, keypoints_of(rows)
    project, names = session.project.project, tuple(set(found.source.tolist()))
    before, after = project.keypoints.state(names), DetectorState(names, found, ())
    session.keypoints.write(project, "keep", lambda: (before, after), lambda: None)
    qtbot.waitUntil(window.context.tasks.settled)


def test_a_few_filled_frames_do_not_keep_the_others_from_being_detected(detector, qtbot):
    session, settings = detector.context.session, detector.context.session.track.settings
    cameras, known = session.document.recording.cameras, session.keypoints.for_run
    seen = simulated_keypoints(truth(), cameras, KeypointErrors(noise=0.3), seed=3)
    rows = [(*row[:6], DETECTOR_NAME, 0) for row in rows_of(seen)]
    keep(detector, qtbot, [row for row in rows if row[0] < 2])
    assert known(settings, range(FRAMES)) is None
    assert len(known(settings, range(2))) > 0
    assert len(known(settings.replaced(detector="off"), range(FRAMES))) > 0
    keep(detector, qtbot, [(*row[:6], "openpose", 0) for row in rows])
    assert len(known(settings, range(FRAMES))) > 0, "others' keypoints are used"


def test_keypoints_of_mono_views_come_back_with_a_run(bare, qtbot, tmp_path):
    """Its steps are shown where no detector is installed."""
    window, session = bare, bare.context.session
    recording = session.document.recording
    seen = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3), seed=3)
    found = keypoints_of((*row[:6], DETECTOR_NAME, 0) for row in rows_of(seen))
    spec = RunSpec(preset("accurate"), frames=range(FRAMES), keypoints=found)
    write_npz(tmp_path / "run.npz", track(recording, spec))
    session.open(tmp_path / "run.npz")
    qtbot.waitUntil(lambda: session.runs.active is not None)
    qtbot.waitUntil(window.context.tasks.settled)
    assert session.keypoints.drawn
    assert window.context.actions.action("trial_now").isEnabled()
    session.document.go_to(4)
    trigger(window, "look_inside")
    inspect = window.context.session.inspection
    qtbot.waitUntil(lambda: inspect.known is not None)
    assert inspect.known.compared == "The result equals the pose of the run."
