"""What is imported goes into the project that was open when that was asked for."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from PySide6.QtCore import QObject, Signal

from app.features.annotate import dialogs
from app.features.annotate.dialogs import AnnotationDialogs
from app.services.tasks.task import TaskList
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.recording.landmarks import LandmarkTrajectory, write_landmarks

PATIENCE_S = 300.0


class Panels(QObject):
    """In place of the panels: a project and a recording, and what works in the background."""

    leaving = Signal()

    def __init__(self, project, recording):
        super().__init__()
        self.project, self.recording = project, recording
        self.tasks = TaskList()


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
    qtbot.waitUntil(lambda: not panels.tasks.tasks)
    assert project.references.names() == (("truth",) if stays else ())
    assert applied == [], "another project has nothing to do with it"
