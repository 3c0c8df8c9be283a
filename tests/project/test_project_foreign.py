"""A project from a stranger does nothing unasked: what this program does not write is refused."""

import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import place_clicks
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.merging import clicks_of_project
from stereotrack_core.project.project import Project
from stereotrack_core.project.whereabouts import projects_of
from tests.project.conftest import write_recording

CLICKS = tuple(
    Click(frame, camera, "head", (frame + 0.5, 2.5))
    for frame in range(69)
    for camera in ("N_left", "N_right", "S_cam")
)
TRIGGER = "CREATE TRIGGER t AFTER INSERT ON owner BEGIN DELETE FROM click; END"
FOREIGN = (
    TRIGGER,
    "DROP TABLE click; CREATE VIEW click AS WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1"
    " FROM r) SELECT i AS frame, 'N_left' AS camera, 'head' AS landmark, 1.5 AS x, 2.5 AS y,"
    " 2 AS visibility, '' AS flag, NULL AS sigma, 'hand' AS origin, 'A' AS who, '' AS at,"
    " 0 AS deleted FROM r",
    "DROP TABLE keyframe; CREATE TABLE keyframe (frame INTEGER NOT NULL PRIMARY KEY,"
    " done INTEGER NOT NULL, who TEXT NOT NULL, at TEXT NOT NULL,"
    " deleted INTEGER GENERATED ALWAYS AS (length(hex(zeroblob(400000000)))) VIRTUAL)",
    "CREATE TABLE more (a)",
    "ALTER TABLE click ADD COLUMN more TEXT",
)


@pytest.fixture(scope="module")
def theirs(tmp_path_factory) -> Path:
    """A project with 207 clicks of a recording that is in the same folder, from somebody else."""
    folder = tmp_path_factory.mktemp("theirs")
    path = folder / "theirs.stereotrack"
    with Project.create(path, write_recording(folder / "walk").folder, who="B") as project:
        project.apply(place_clicks(CLICKS))
    return path


@pytest.fixture
def stranger(theirs, tmp_path) -> Path:
    """The same, to be changed."""
    path = tmp_path / "from-elsewhere" / theirs.name
    path.parent.mkdir()
    return Path(shutil.copyfile(theirs, path))


def change(path: Path, statements: str) -> None:
    with closing(sqlite3.connect(path)) as database:
        database.executescript(statements)


def refusals(path: Path, project: Project) -> list[str]:
    ways = [
        lambda: Project.open(path),
        lambda: Project.open(path, read_only=True),
        lambda: clicks_of_project(path, project),
    ]
    said = []
    for way in ways:
        with pytest.raises(InputError) as refusal:
            way()
        said.append(str(refusal.value))
    return said


@pytest.mark.parametrize("statements", FOREIGN)
def test_what_is_not_of_this_program_is_refused(stranger, project, tmp_path, statements):
    change(stranger, statements)
    before = stranger.read_bytes()
    for said in refusals(stranger, project):
        assert "was modified by another program" in said
    assert projects_of(tmp_path / "walk", stranger.parent) == ()
    assert stranger.read_bytes() == before
    assert [one.name for one in stranger.parent.iterdir()] == [stranger.name]


@pytest.mark.parametrize(
    "statement",
    ["UPDATE click SET x = 'far'", "UPDATE click SET frame = 1000000000 WHERE frame = 3"],
)
def test_a_click_that_makes_no_sense_is_damage(stranger, statement):
    change(stranger, statement)
    with (
        Project.open(stranger, read_only=True) as project,
        pytest.raises(ProjectDamaged, match="is damaged"),
    ):
        project.clicks.all()


@pytest.mark.parametrize("kind", ["folder", "pipe", "device", "missing"])
def test_what_is_no_file_is_refused_at_once(project, tmp_path, kind):
    path = tmp_path / "some.stereotrack"
    match kind:
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case "device":
            path.symlink_to("/dev/zero")
    for said in refusals(path, project):
        assert str(path.parent) in said or kind == "device"
    assert not list(tmp_path.glob(".*"))


def test_a_project_that_lost_its_recording_asks_for_it(stranger, recording):
    change(stranger, "DELETE FROM recording")
    with Project.open(stranger) as project:
        assert project.find_recording().folder is None
        assert "the recording of the project is not known" in project.find_recording().finding.what
        project.use_recording(recording.folder)
        assert project.find_recording().folder == recording.folder
