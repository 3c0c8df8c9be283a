"""Landmarks are proposed over a selection through real pictures, and accepted by hand."""

import cv2
import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.propose import PROPOSED
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.prefilling import accept_predictions, propose_selection
from stereotrack_core.project.project import Project
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.writing import write_png, write_recording_description
from stereotrack_core.work import Work

FRAMES, STEP = 12, 3


def accept_proposed(project, selection):
    return accept_predictions(project, (PROPOSED,), selection, "proposals")


@pytest.fixture
def moving(tmp_path, make) -> Recording:
    """Two views of a texture that goes three pixels to the right with every frame."""
    rng = np.random.default_rng(0)
    texture = cv2.GaussianBlur(rng.uniform(0, 255, (480, 800)), (0, 0), 3)
    texture = cv2.normalize(texture, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    folder = tmp_path / "data" / "moving"
    cameras = {name: make.CAMERAS[name] for name in ("N", "O")}
    for name in cameras:
        (folder / name).mkdir(parents=True)
        for k in range(FRAMES):
            start = 100 - STEP * k
            write_png(folder / name / f"{k}.png", np.ascontiguousarray(texture[:, start:][:, :640]))
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in cameras)
    write_recording_description(Recording(folder, "moving", 10.0, views, cameras))
    return open_recording(folder)


@pytest.fixture
def project(moving):
    with Project.create(moving.folder.parent / "moving.stereotrack", moving.folder) as made:
        yield made


def test_what_is_found_is_proposed_and_accepted_as_one_edit(project, moving):
    project.apply(
        place_clicks((Click(2, "N", "head", (200.0, 200.0)), Click(2, "O", "head", (300.0, 150.0))))
    )
    selection = Selection(range(4, 10))
    found = propose_selection(project, moving, selection)
    assert found == "12 points predicted in frames 4 – 9."
    assert project.clicks.count() == 2
    places = {p.key: p.position for p in project.predictions.of_source(PROPOSED)}
    assert {key.frame for key in places} == set(range(4, 10))
    for key, (x, y) in places.items():
        start = 200.0 if key.camera == "N" else 300.0
        assert x == pytest.approx(start + STEP * (key.frame - 2), abs=2.0)
        assert y == pytest.approx(200.0 if key.camera == "N" else 150.0, abs=2.0)
    project.apply(accept_proposed(project, Selection(range(4, 7), ("head",))))
    assert project.clicks.count() == 2 + 6
    project.undo()
    assert project.clicks.count() == 2


def test_it_goes_backward_from_clicks_behind_and_not_beyond_other_clicks(project, moving):
    project.apply(place_clicks((Click(9, "N", "head", (250.0, 200.0)),)))
    project.apply(place_clicks((Click(5, "N", "head", (238.0, 200.0)),)))
    propose_selection(project, moving, Selection(range(3, 10)))
    frames = {p.frame for p in project.predictions.of_source(PROPOSED)}
    assert frames == {3, 4, 6, 7, 8}


def test_nothing_to_follow_is_said_and_it_can_be_stopped(project, moving):
    with pytest.raises(InputError, match="no click near frames 3 – 5"):
        propose_selection(project, moving, Selection(range(3, 6)))
    with pytest.raises(InputError, match="there are no proposals in frames 3 – 5"):
        accept_proposed(project, Selection(range(3, 6)))
    project.apply(place_clicks((Click(2, "N", "head", (200.0, 200.0)),)))
    with pytest.raises(Cancelled):
        propose_selection(project, moving, Selection(range(3, 6)), Work(stopped=lambda: True))
    assert not project.predictions.of_source(PROPOSED)
