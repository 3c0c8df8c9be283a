"""The window shows a recording as its project corrects it, or says that it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.project import Project
from stereotrack_core.project.setups import Corrections, save_corrections
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader

pytestmark = pytest.mark.window

LATER = Corrections("found from the movement", first_frames={"N/left": 2, "N/right": 2})


@pytest.fixture
def home(tmp_path):
    folder = tmp_path / "projects"
    folder.mkdir()
    return folder


def project_with(folder, path, corrections):
    with Project.create(path, folder, who="A") as project:
        project.apply(save_corrections("1", corrections))
        project.apply(Choose("description", "1"))
    return path


def opened_in(window, qtbot, path):
    window.context.session.opening.open(path)
    qtbot.waitUntil(lambda: window.context.session.document.frame_set is not None, timeout=30_000)
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    return window


def picture(folder, frame):
    with FrameReader(open_recording(folder)) as reader:
        return reader.frame_set(frame)


def all_messages(window):
    return [message.sentence() for message in window.messages._messages]


@pytest.mark.parametrize("by_file", [False, True])
def test_streams_and_cameras_are_corrected(window, qtbot, small_recording, home, by_file):
    camera = open_recording(small_recording).cameras["S_right"]
    usual = camera.camera_from_world
    elsewhere = RigidTransform(usual.rotation, usual.translation + (0.002, 0.0, 0.01))
    moved = replace(camera, camera_from_world=elsewhere)
    path = project_with(
        small_recording, home / "walk.stereotrack", replace(LATER, cameras={"S_right": moved})
    )
    opened_in(window, qtbot, path if by_file else small_recording)
    assert window.context.session.project.path == path.resolve()
    assert window.context.session.document.recording.view("N").image.first_frame == 2
    there = window.context.session.document.frame_set
    other = picture(small_recording, 2)
    np.testing.assert_array_equal(there.views["N"].image, other.views["N"].image)
    found = window.context.session.document.recording.cameras["S_right"].camera_from_world.matrix()
    np.testing.assert_allclose(found, moved.camera_from_world.matrix(), atol=1e-12)
    (words,) = all_messages(window)
    assert "shown with the corrections of its project (found from the movement)" in words
    assert "2 first frames, 1 camera" in words, words


def test_corrections_of_another_recording_are_refused_in_words(
    window, qtbot, small_recording, home
):
    wrong = Corrections("x", first_frames={"W/left": 3})
    project_with(small_recording, home / "walk.stereotrack", wrong)
    opened_in(window, qtbot, small_recording)
    assert window.context.session.document.recording.view("N").image.first_frame == 0
    assert window.context.session.project.why_no_edit() == ""
    (words,) = all_messages(window)
    assert "cannot be applied" in words
    assert "no stream 'W/left'" in words


def test_corrections_chosen_meanwhile_are_offered(opened, qtbot):
    window = opened
    window.context.session.project.apply(save_corrections("1", LATER))
    assert window.messages.text() == ""
    window.context.session.project.apply(Choose("description", "1"))
    qtbot.waitUntil(
        lambda: (
            "corrections of the recording in the project have changed" in window.messages.text()
        ),
        timeout=5_000,
    )
    assert window.context.session.document.recording.view("N").image.first_frame == 0
    window.messages.do_button.click()
    qtbot.waitUntil(
        lambda: (
            window.context.session.document.recording is not None
            and window.context.session.document.recording.view("N").image.first_frame == 2
        ),
        timeout=30_000,
    )
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    assert window.context.session.project.why_no_edit() == ""
    (words,) = all_messages(window)
    assert "shown with the corrections of its project" in words


def test_without_corrections_nothing_is_said(opened):
    assert opened.context.session.document.corrections is None
    assert opened.messages.text() == ""
