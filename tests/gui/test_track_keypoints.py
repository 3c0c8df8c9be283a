"""Mono views are tracked in the window with the keypoints of the project."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from stereotrack_core.project.project import Project
from stereotrack_core.simulation.keypoints import KeypointErrors, simulated_keypoints
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
        project.keypoints.replace(keypoints)
    return path


def test_mono_views_are_tracked_with_the_keypoints_of_the_project(window, qtbot, mono):
    session = window.context.session
    session.opening.open(mono)
    qtbot.waitUntil(lambda: session.document.frame_set is not None)
    qtbot.waitUntil(window.context.tasks.settled)
    action = window.context.actions.action
    assert action("run").isEnabled(), action("run").statusTip()
    action("use_keypoints").trigger()
    qtbot.waitUntil(lambda: not action("run").isEnabled())
    assert "keypoints of two mono views" in action("run").statusTip()
    action("use_keypoints").trigger()
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
