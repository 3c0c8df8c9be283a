"""Projects of the format before: read as they are, brought up to date when they are written to."""

import sqlite3
from contextlib import closing

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.detectors import removal
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.project import Project
from stereotrack_core.recording.keypoints import keypoints_of

ROWS = (
    (2, "S_cam", "left_wrist", 3.5, 4.5, 0.75, "pose", 0),
    (1, "S_cam", "left_wrist", 1.5, 2.5, 0.5, "pose", 0),
    (1, "S_cam", "left_wrist", 9.0, 2.5, 0.5, "pose", 1),
    (1, "S_cam", "nose", 1.0, 2.0, 1.0, "other", 0),
)


@pytest.fixture
def old(project, project_path):
    """A project of format 1 with a click."""
    project.apply(place_clicks((Click(0, "S_cam", "head", (1.0, 2.0)),)))
    project.close()
    with closing(sqlite3.connect(project_path, isolation_level=None)) as database:
        database.execute("DROP TABLE keypoint")
        database.execute("PRAGMA user_version = 1")
    return project_path


def test_writing_brings_it_up_to_date_and_keeps_a_copy(old):
    copy = old.with_name("walk.format1.stereotrack")
    with Project.open(old) as project:
        assert copy.name in project.notes[0].remedy
        project.keypoints.put(DetectorState(("other", "pose"), keypoints_of(ROWS), ()))
    with Project.open(old) as again:
        assert not again.notes
        assert again.clicks.count() == 1
        assert again.keypoints.sources() == {"other": 1, "pose": 3}
    with closing(sqlite3.connect(copy)) as database:
        assert database.execute("PRAGMA user_version").fetchone() == (1,)
        assert database.execute("SELECT count(*) FROM click").fetchone() == (1,)


def test_read_only_it_has_no_keypoints_and_stays_as_it_is(old):
    before = old.read_bytes()
    with Project.open(old, read_only=True) as project:
        assert not len(project.keypoints.all())
        assert project.keypoints.state(("pose",)).sources == ("pose",)
    assert old.read_bytes() == before


def test_a_table_that_the_format_does_not_have_is_foreign(old):
    with closing(sqlite3.connect(old, isolation_level=None)) as database:
        database.execute("CREATE TABLE keypoint (frame INTEGER)")
    with pytest.raises(InputError, match="modified by another program"):
        Project.open(old)


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
