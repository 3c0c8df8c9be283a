"""Projects of the format before: read as they are, brought up to date when they are written to."""

import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, Prediction, Visibility
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.detectors import removal
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import ADDED_STATEMENTS
from stereotrack_core.recording.keypoints import keypoints_of

ROWS = (
    (2, "S_cam", "left_wrist", 3.5, 4.5, 0.75, "pose", 0),
    (1, "S_cam", "left_wrist", 1.5, 2.5, 0.5, "pose", 0),
    (1, "S_cam", "left_wrist", 9.0, 2.5, 0.5, "pose", 1),
    (1, "S_cam", "nose", 1.0, 2.0, 1.0, "other", 0),
)


PREDICTED = Prediction(1, "S_cam", "head", "fit", (1.0, 2.0), 0.5)


@pytest.fixture(params=(1, 2))
def version(request):
    return request.param


@pytest.fixture
def old(project, project_path, version):
    """A project of an older format with a click and a prediction."""
    project.apply(place_clicks((Click(0, "S_cam", "head", (1.0, 2.0)),)))
    project.predictions.replace("fit", [PREDICTED])
    project.close()
    with closing(sqlite3.connect(project_path, isolation_level=None)) as database:
        for table in ("keypoint",) * (version == 1) + ("scenario", "camera_use"):
            database.execute(f"DROP TABLE {table}")
        database.execute("ALTER TABLE prediction DROP COLUMN visibility")
        database.execute(f"PRAGMA user_version = {version}")
    return project_path


def test_writing_brings_it_up_to_date_and_keeps_a_copy(old, version):
    copy = old.with_name(f"walk.format{version}.stereotrack")
    with Project.open(old) as project:
        assert copy.name in project.notes[0].remedy
        project.keypoints.put(DetectorState(("other", "pose"), keypoints_of(ROWS), ()))
    with Project.open(old) as again:
        assert not again.notes
        assert again.clicks.count() == 1
        assert again.keypoints.sources() == {"other": 1, "pose": 3}
        assert again.predictions.at(1) == (PREDICTED,)
        again.predictions.replace("fit", [replace(PREDICTED, visibility=Visibility.GUESSED)])
        assert again.predictions.at(1)[0].visibility == Visibility.GUESSED
    with closing(sqlite3.connect(copy)) as database:
        assert database.execute("PRAGMA user_version").fetchone() == (version,)
        assert database.execute("SELECT count(*) FROM click").fetchone() == (1,)


def test_read_only_it_has_no_keypoints_and_stays_as_it_is(old):
    before = old.read_bytes()
    with Project.open(old, read_only=True) as project:
        assert not len(project.keypoints.all())
        assert project.keypoints.state(("pose",)).sources == ("pose",)
        assert project.predictions.at(1) == (PREDICTED,)
        assert not project.scenarios.names()
        assert not project.marks.unused_cameras()
    assert old.read_bytes() == before


def test_a_table_that_the_format_does_not_have_is_foreign(old):
    with closing(sqlite3.connect(old, isolation_level=None)) as database:
        database.execute("CREATE TABLE scenario (frame INTEGER)")
    with pytest.raises(InputError, match="modified by another program"):
        Project.open(old)


def test_a_step_that_goes_wrong_changes_nothing(old, monkeypatch):
    before = old.read_bytes()
    wrong = {**ADDED_STATEMENTS, 3: ADDED_STATEMENTS[3][:1]}
    monkeypatch.setattr("stereotrack_core.project.database._missing", lambda _: wrong[3])
    with pytest.raises(ProjectDamaged, match="is missing"):
        Project.open(old)
    assert old.read_bytes() == before


def test_keypoints_come_back_and_are_no_edits(project):
    found = keypoints_of(ROWS)
    project.keypoints.put(DetectorState(("other", "pose"), found, ()))
    stored = project.keypoints.all()
    assert stored.fingerprint() != ""
    np.testing.assert_array_equal(stored.frame, [1, 1, 1, 2])
    assert stored.of_frame(2).place.tolist() == [[3.5, 4.5]]
    assert len(project.keypoints.at(1)) == 3
    assert project.keypoints.all("other").keypoint.tolist() == ["nose"]
    before, after = removal(project, "pose")
    project.keypoints.put(after)
    assert project.keypoints.sources() == {"other": 1}
    project.keypoints.put(before)
    assert project.keypoints.all().fingerprint() == stored.fingerprint()
    assert project.undo() is None
