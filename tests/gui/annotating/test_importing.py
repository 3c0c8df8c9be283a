"""What is imported goes into the project that was open when that was asked for."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from PySide6.QtCore import QDir, QObject, Signal
from PySide6.QtWidgets import QAbstractButton, QFileDialog

from app.features.annotate import dialogs
from app.features.annotate.dialogs import AnnotationDialogs
from app.features.annotate.exchange.click_files import ImportDialog
from app.features.annotate.exchange.predictions import PredictionsDialog
from app.services.tasks.task import TaskList
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.reading import read_keypoints
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.setups import load_reference
from stereotrack_core.recording.landmarks import LandmarkTrajectory, write_landmarks

PATIENCE_S = 300.0
SUFFIXES = (
    *(".csv", ".json", ".slp", ".h5", ".npz", ".trc", ".c3d", ".part", ".npy", ".mat", ".txt"),
    *(".mp4", ""),
)


class Panels(QObject):
    """In place of the panels: a project and a recording, and what works in the background."""

    leaving = Signal()
    message = Signal(object)

    def __init__(self, project, recording):
        super().__init__()
        self.project, self.recording, self.frame_count = project, recording, 10
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


def is_read(path, recording):
    """Which readers know files of that suffix; this one holds nothing that could be read."""

    def known(read):
        try:
            read()
        except InputError as error:
            return "cannot be read from" not in str(error) and "unknown suffix" not in str(error)
        return True

    clicks = (
        known(lambda: read_trajectory(path))
        if is_trajectory(path)
        else known(lambda: read_labels(LabelSource(path, recording, NINE.names)))
    )
    return {"clicks": clicks, "predictions": known(
        lambda: list(read_keypoints(KeypointSource(path, recording)).keypoints))}  # fmt: skip


def test_dialogs_show_every_file_that_is_read(qtbot, project, recording, tmp_path, monkeypatch):
    asked = {}

    def choose(_parent, title, _start, files):
        asked[title] = files.partition("(")[2].partition(")")[0].split()
        return ("", "") if title == "Import clicks" else ([], "")

    for name in ("getOpenFileName", "getOpenFileNames"):
        monkeypatch.setattr(QFileDialog, name, choose)
    for dialog, button in (
        (ImportDialog(recording, NINE.names, ""), "&Choose …"),
        (PredictionsDialog(project, recording, 2), "Add &files …"),
    ):
        qtbot.addWidget(dialog)
        (found,) = [one for one in dialog.findChildren(QAbstractButton) if one.text() == button]
        found.click()
    for suffix in SUFFIXES:
        path = tmp_path / f"file{suffix}"
        path.write_bytes(b"nothing")
        shown = {title: QDir.match(kinds, path.name) for title, kinds in asked.items()}
        read = is_read(path, recording)
        assert shown == {f"Import {what}": there for what, there in read.items()}, suffix


def test_a_reference_of_another_rate_and_longer_than_the_recording_is_taken_by_time_and_said(
    qtbot, project, recording, make, tmp_path
):
    points = np.stack([make.places_at(k) for k in range(13)]).repeat(5, axis=0)
    path, panels, said = tmp_path / "mocap.trc", Panels(project, recording), []
    panels.message.connect(said.append)
    write_trc(path, LandmarkTrajectory(np.arange(65), points), 5 * recording.fps)
    AnnotationDialogs(panels).import_labels(LabelSource(path, recording, NINE.names))
    qtbot.waitUntil(lambda: not panels.tasks.tasks)
    kept = load_reference(project.references, "mocap")
    assert kept.frame.tolist() == list(range(10))
    np.testing.assert_allclose(kept.points, points[:50:5], atol=1e-9)
    sentences = " ".join(one.sentence() for one in said)
    assert f"it has {5 * recording.fps:g} frames per second, the recording" in sentences
    assert "3 of its 13 frames lie after it. They are left out." in sentences
