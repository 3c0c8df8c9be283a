"""What is imported goes into the project that was open when that was asked for."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QObject

from app.context import window_loop
from app.features.annotate import dialogs
from app.features.annotate.dialogs import AnnotationDialogs
from app.session.jobs import TaskList
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.entries import load_reference
from stereotrack_core.recording.landmarks import LandmarkTrajectory, write_landmarks
from tests.gui.annotating.notices import Notices

PATIENCE_S = 300.0


class Panels(QObject):
    """In place of the panels: a project and a recording, and what works in the background."""

    def __init__(self, project, recording):
        super().__init__()
        self.project, self.recording, self.frame_count = project, recording, 10
        tasks = TaskList(window_loop(self), lambda _error: None, lambda: None)
        session = SimpleNamespace(keypoints=None)
        self.context = SimpleNamespace(tasks=tasks, notifier=Notices(), session=session)


@pytest.fixture
def slow(monkeypatch):
    """Reading a reference takes until it is let go."""
    begun, go, reference_in = threading.Event(), threading.Event(), dialogs.reference_in

    def reading(*given):
        begun.set()
        assert go.wait(PATIENCE_S)
        return reference_in(*given)

    monkeypatch.setattr(dialogs, "reference_in", reading)
    return begun, go


@pytest.mark.parametrize("stays", [True, False])
def test_a_reference_goes_into_the_project_it_was_read_for(
    qtbot, project, recording, make, tmp_path, slow, stays
):
    begun, go = slow
    points = np.stack([make.places_at(k) for k in range(10)])
    path = tmp_path / "truth.csv"
    write_landmarks(path, LandmarkTrajectory(np.arange(10), points))
    panels, applied = Panels(project, recording), []
    AnnotationDialogs(panels).import_labels(LabelSource(path, recording, NINE.names))
    assert begun.wait(PATIENCE_S)
    if not stays:
        panels.project = type("Other", (), {"apply": applied.append})()
    go.set()
    qtbot.waitUntil(lambda: not panels.context.tasks.tasks)
    assert project.references.names() == (("truth",) if stays else ())
    assert applied == [], "another project has nothing to do with it"


def test_a_reference_of_another_rate_and_longer_than_the_recording_is_taken_by_time_and_said(
    qtbot, project, recording, make, tmp_path
):
    points = np.stack([make.places_at(k) for k in range(13)]).repeat(5, axis=0)
    path, panels = tmp_path / "mocap.trc", Panels(project, recording)
    write_trc(path, LandmarkTrajectory(np.arange(65), points), 5 * recording.fps)
    AnnotationDialogs(panels).import_labels(LabelSource(path, recording, NINE.names))
    qtbot.waitUntil(lambda: not panels.context.tasks.tasks)
    kept = load_reference(project.references, "mocap")
    assert kept.frame.tolist() == list(range(10))
    np.testing.assert_allclose(kept.points, points[:50:5], atol=1e-9)
    sentences = " ".join(one.sentence() for one in panels.context.notifier.shown)
    assert f"it has {5 * recording.fps:g} frames per second, the recording" in sentences
    assert "3 of its 13 frames lie after it. They are left out." in sentences
