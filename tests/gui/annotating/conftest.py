"""A project of a recording of four views, and clicks of a person in it."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QSettings

from app.session.changes import Part
from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose, hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.annotation.scenes import AZIMUTHS, LENSES, looking_in
from tests.gui.annotating.stage import Stage

MATRIX = np.array([[520.0, 0, 319.5], [0, 520.0, 239.5], [0, 0, 1]])
FRAMES = 60


def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.is_relative_to(Path(__file__).parent):
            item.add_marker(pytest.mark.qt_log_level_fail("WARNING"))
            item.add_marker(pytest.mark.qt_log_ignore("plugin does not support"))


CAMERAS = {
    name: Camera(name, 640, 480, MATRIX, *LENSES["barrel"], looking_in(azimuth))
    for name, azimuth in AZIMUTHS.items()
}


def write_recording(folder: Path) -> Recording:
    for name in CAMERAS:
        (folder / name).mkdir(parents=True)
        for k in range(2):
            write_png(folder / name / f"{k}.png", np.full((480, 640), 40 * k, np.uint8))
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in CAMERAS)
    recording = Recording(folder, "walk", 10.0, views, CAMERAS)
    write_recording_description(recording)
    return recording


def pose_at(frame: int) -> Pose:
    """Arms that swing slowly."""
    bend = np.tile(np.eye(3), (len(PARTS), 1, 1))
    bend[3:7] = rotation_from_vector(
        np.array([[0.5 + 0.01 * frame, 0.3, 0.0]] * 4) * [[1], [1], [0.6], [0.6]]
    )
    pose = hanging_pose(np.array([0.05, 0.001 * frame, 0.9]))
    return replace(pose, rotations=pose.rotations @ bend)


def places_at(frame: int, proportions=AVERAGE) -> np.ndarray:
    """The nine landmarks (9, 3) of the person."""
    body = body_model(proportions)
    return NINE.places(body, body.frames(pose_at(frame)))


def clicks_at(frames, *, sigma=0.0, seed=0, cameras=tuple(CAMERAS), **more) -> tuple[Click, ...]:
    """Clicks of every landmark in every view."""
    rng = np.random.default_rng(seed)
    proportions = more.pop("proportions", AVERAGE)
    found = []
    for frame in frames:
        for name in cameras:
            pixels = CAMERAS[name].project(places_at(frame, proportions))
            pixels = pixels + rng.normal(0, sigma, (9, 2)) if sigma else pixels
            found += [
                Click(frame, name, landmark, (float(x), float(y)), **more)
                for landmark, (x, y) in zip(NINE.names, pixels, strict=True)
            ]
    return tuple(found)


@pytest.fixture
def recording(tmp_path) -> Recording:
    return write_recording(tmp_path / "data" / "walk")


@pytest.fixture
def project(recording) -> Iterator[Project]:
    with Project.create(recording.folder.parent / "walk.stereotrack", recording.folder) as made:
        yield made


@pytest.fixture
def tasks(qapp):
    """Work in the background, ended with the test."""
    from app.context import window_loop
    from app.session.jobs import TaskList

    made = TaskList(window_loop(qapp), lambda _error: None, lambda: None)
    yield made
    made.shutdown()


@pytest.fixture
def make():
    """What tests make clicks, cameras and poses with."""
    from types import SimpleNamespace

    return SimpleNamespace(
        clicks_at=clicks_at, places_at=places_at, pose_at=pose_at, CAMERAS=CAMERAS, FRAMES=FRAMES
    )


@pytest.fixture
def stage(qtbot, project, make, shown, tmp_path):
    project.apply(place_clicks(make.clicks_at(range(0, FRAMES, 10), sigma=1.0)))
    settings = QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)
    made = Stage(settings)
    made.timeline.set_range(FRAMES, 10.0)
    recording = open_recording(project.find_recording().folder)
    made.edits.set_project(project)
    changes = made.context.session.changes
    project.on_change(partial(changes.tell, Part.EDIT))
    made.panels.set_project(project, recording, FRAMES)
    shown(made, 1100, 900)
    yield made
    made.panels.shutdown()
    made.context.session.close()
