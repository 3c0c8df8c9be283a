"""A project from a stranger does nothing unasked and nothing without end; its clicks can be had."""

from __future__ import annotations

import os
import shutil
import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.program import main
from stereotrack_core.project import connection
from stereotrack_core.project.clicks import PlaceClicks, place
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.history import History
from stereotrack_core.project.merging import clicks_of_project
from stereotrack_core.project.project import Project
from stereotrack_core.project.rescue import rescue
from stereotrack_core.project.validity import made, sense
from stereotrack_core.project.whereabouts import projects_of
from tests.project.conftest import write_recording
from tests.project.spoiling import DEEP, ENDLESS, SCHEMA

CLICKS = tuple(
    Click(frame, camera, "head", (frame + 0.5, 2.5))
    for frame in range(69)
    for camera in ("N_left", "N_right", "S_cam")
)
REFUSED = [
    statement for statement in SCHEMA if statement.startswith(("CREATE", "ALTER", "ANALYZE"))
]
REPLACED = [statement for statement in SCHEMA if "; CREATE" in statement]


@pytest.fixture(scope="module")
def theirs(tmp_path_factory) -> Path:
    """A project with 207 clicks of a recording that is in the same folder, from somebody else."""
    folder = tmp_path_factory.mktemp("theirs")
    path = folder / "theirs.stereotrack"
    with Project.create(path, write_recording(folder / "walk").folder, who="B") as project:
        project.apply(PlaceClicks(CLICKS))
    return path


@pytest.fixture
def stranger(theirs, tmp_path) -> Path:
    """The same, to be changed."""
    path = tmp_path / "from-elsewhere" / theirs.name
    path.parent.mkdir()
    return Path(shutil.copyfile(theirs, path))


def change(path: Path, statements: str) -> None:
    """What somebody does to a project with a tool for databases."""
    with closing(sqlite3.connect(path)) as database:
        database.executescript(statements)


def refusals(path: Path, project: Project) -> list[str]:
    """What every way in says."""
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


@pytest.mark.parametrize("statements", REFUSED + REPLACED)
def test_what_is_not_of_this_program_is_refused_and_left_behind(
    stranger, project, tmp_path, statements
):
    change(stranger, statements)
    before = stranger.read_bytes()
    for said in refusals(stranger, project):
        assert "was modified by another program" in said
        assert "recover what is readable" in said
    assert projects_of(tmp_path / "walk", stranger.parent) == ()
    assert stranger.read_bytes() == before
    assert [one.name for one in stranger.parent.iterdir()] == [stranger.name]
    saved = rescue(stranger, tmp_path / "rescued.stereotrack")
    with Project.open(saved.path) as rescued:
        assert [click.key for click in rescued.clicks.all()] == [click.key for click in CLICKS]
        rescued.apply(place(Click(100, "N_left", "head", (1.5, 2.5))))
        assert rescued.clicks.count() == len(CLICKS) + 1


@pytest.mark.parametrize("what", ["export", "report", "import", "into"])
def test_every_command_refuses_it(stranger, project, tmp_path, capsys, what):
    project.close()
    change(stranger, SCHEMA[0])
    before = stranger.read_bytes()
    out = tmp_path / "out"
    status = main(
        {
            "export": ["export", str(stranger), "--format", "csv", "-o", f"{out}.csv"],
            "report": ["report", str(stranger), "-o", f"{out}.html"],
            "import": ["import", "labels", str(stranger), "--into", str(project.path)],
            "into": ["import", "labels", str(project.path), "--into", str(stranger)],
        }[what]
    )
    assert status == 2
    assert "the trigger 't' is not as this program creates it" in capsys.readouterr().err
    assert not list(tmp_path.glob("out*"))
    assert stranger.read_bytes() == before


def test_spaces_and_the_index_that_older_programs_did_not_make_do_not_matter(stranger):
    change(
        stranger,
        "DROP INDEX flagged_click; PRAGMA writable_schema = ON;"
        " UPDATE sqlite_schema SET sql = replace(sql, ',', '  ,\n ') WHERE type = 'table'",
    )
    with Project.open(stranger) as project:
        assert project.clicks.count() == len(CLICKS)


def test_a_table_of_pages_that_lead_back_to_each_other_is_not_read_for_ever(
    stranger, project, tmp_path, monkeypatch
):
    """Few pages that refer to each other so often that no machine comes to the end of the rows."""
    monkeypatch.setattr(connection, "_FREE_STEPS", 1_000_000)
    with closing(sqlite3.connect(stranger)) as database:
        (root,) = database.execute(
            "SELECT rootpage FROM sqlite_schema WHERE name = 'keyframe'"
        ).fetchone()
        database.execute("INSERT INTO keyframe VALUES (1, 0, 'A', '', 0)")
        database.commit()
    content = bytearray(stranger.read_bytes())
    leaf = content[(root - 1) * 8192 : root * 8192]
    first, count = len(content) // 8192 + 1, 8
    for number in range(count):  # each but the last leads 400 times to the next one
        content += leaf if number == count - 1 else interior(first + number + 1)
    content[(root - 1) * 8192 : root * 8192] = interior(first)
    content[28:32] = struct.pack(">I", len(content) // 8192)
    stranger.write_bytes(content)
    for said in refusals(stranger, project):
        assert "reading it does not finish" in said
    saved = rescue(stranger, tmp_path / "rescued.stereotrack")
    with Project.open(saved.path) as rescued:
        assert rescued.clicks.count() == len(CLICKS)


def interior(child: int) -> bytes:
    """A page of a table's tree, all of whose children are the same page."""
    cells = 400
    page = bytearray(8192)
    page[:12] = struct.pack(">BHHHBI", 5, 0, cells, 8192 - 5 * cells, 0, child)
    for cell in range(cells):
        at = 8192 - 5 * (cell + 1)
        page[12 + 2 * cell : 14 + 2 * cell] = struct.pack(">H", at)
        page[at : at + 5] = struct.pack(">IB", child, 1)
    return bytes(page)


WRONG: dict[str, tuple[object, ...]] = {
    "INTEGER": (b"\x01", "many", -1, 2**60, 1.5),
    "REAL": (b"\x01", "far", 9e999, 1e300),
    "TEXT": (b"text", "a\0b"),
    "BLOB": ("text", 5),
}


def columns(table: str) -> list[tuple[str, str]]:
    """Columns of a table and their declared types."""
    with closing(sqlite3.connect(":memory:")) as database:
        database.execute(made()[table].statement)
        return [(row[1], row[2]) for row in database.execute(f"PRAGMA table_info({table})")]


ROWS = """
INSERT INTO repeat_click SELECT 1, * FROM click LIMIT 1;
INSERT INTO prediction VALUES (1, 'N_left', 'head', 'x', 1.5, 2.5, 0.5);
INSERT INTO keypoint VALUES (1, 'N_left', 'nose', 'x', 0, 1.5, 2.5, 0.5);
INSERT INTO frame_flag VALUES (1, '', 'gap', '', 'A', '', 0);
INSERT INTO keyframe VALUES (1, 0, 'A', '', 0);
INSERT INTO content VALUES ('aa', x'00');
INSERT INTO reference VALUES ('r', '{}', 'aa', 'A', '', 0);
INSERT INTO run VALUES ('r', '{}', 'aa', 'A', '', 0);
INSERT INTO subject VALUES ('P', '{}', NULL, 'A', '', 0);
INSERT INTO landmark_set VALUES ('l', '{}', NULL, 'A', '', 0);
INSERT INTO parameter_set VALUES ('p', '{}', NULL, 'A', '', 0);
INSERT INTO description VALUES ('1', '{}', NULL, 'A', '', 0);
INSERT INTO choice VALUES ('subject', 'P');
INSERT INTO view_setting VALUES ('frame', '3');
"""
OWNED = "INSERT INTO owner VALUES (1, 'pc', 5, 'A', '');"


@pytest.mark.parametrize("table", sense())
def test_a_value_of_another_kind_is_refused_in_every_column(stranger, table):
    change(stranger, ROWS)
    Project.open(stranger, read_only=True).close()
    change(stranger, OWNED)
    whole = stranger.read_bytes()
    for column, kind in columns(table):
        for value in WRONG[kind]:
            stranger.write_bytes(whole)
            with closing(sqlite3.connect(stranger)) as database:
                database.execute("PRAGMA ignore_check_constraints = ON")
                database.execute("PRAGMA synchronous = OFF")
                try:
                    database.execute(f"UPDATE OR REPLACE {table} SET {column} = ?", (value,))
                except sqlite3.IntegrityError:  # the number that SQLite finds rows by
                    continue
                database.commit()
            with pytest.raises(InputError, match=r"invalid row|cannot be read|decode"):
                Project.open(stranger, read_only=True)


@pytest.mark.parametrize(
    "facts", ["[]", "5", "null", "{", f'{{"a": {DEEP}}}', f'{{"a": {ENDLESS}}}', '{"a": 1']
)
@pytest.mark.parametrize("table", ["subject", "run"])
def test_facts_of_another_kind_are_refused(stranger, project, table, facts):
    change(stranger, ROWS)
    with closing(sqlite3.connect(stranger)) as database:
        database.execute(f"UPDATE {table} SET facts = ?", (facts,))
        database.commit()
    for said in refusals(stranger, project):
        assert "the project file is damaged" in said


@pytest.mark.parametrize("version", [0, -5, 3, 2**31 - 1])
def test_a_format_that_nobody_knows_is_refused(stranger, project, version):
    change(stranger, f"PRAGMA user_version = {version}")
    for said in refusals(stranger, project):
        assert f"it has format {version}, and this program reads formats 1 to 2" in said


@pytest.mark.parametrize(
    "kind", ["folder", "pipe", "device", "links", "missing", "unreadable name"]
)
def test_what_is_no_file_is_refused_at_once(project, tmp_path, kind):
    path = tmp_path / "some.stereotrack"
    match kind:
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case "device":
            path.symlink_to("/dev/zero")
        case "links":
            path.symlink_to(path)
        case "unreadable name":
            path = tmp_path / ("a" * 300 + ".stereotrack")
    for said in refusals(path, project):
        assert str(path.parent) in said or kind == "device"
    with pytest.raises(InputError):
        rescue(path, tmp_path / "rescued.stereotrack")
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("end", ["-journal", "-wal", "-shm"])
def test_a_pipe_beside_a_project_is_not_waited_for(stranger, project, end):
    os.mkfifo(f"{stranger}{end}")
    for said in refusals(stranger, project):
        assert f"{end}: this is not a file" in said


def test_a_pipe_in_the_place_of_the_lock_is_not_waited_for(stranger):
    os.mkfifo(stranger.with_name(f".{stranger.name}.lock"))
    with pytest.raises(InputError, match="lock: this is not a file"):
        Project.open(stranger)


def test_what_the_history_would_bring_back_is_looked_at(stranger):
    """Undo writes rows that somebody else may have made up."""
    change(stranger, 'UPDATE edit_change SET before = \'[1.5,"far",2,"",null,"hand","","",0]\'')
    with Project.open(stranger) as project:
        with pytest.raises(ProjectDamaged, match="the history has an invalid row"):
            project.undo()
        assert project.clicks.count() == len(CLICKS)


def test_nothing_is_saved_that_would_not_be_opened_again(project, monkeypatch):
    project.apply(place(CLICKS[0]))
    with pytest.raises(InputError, match="a value of click is out of range"):
        project.apply(place(Click(10**9, "N_left", "head", (1.0, 2.0))))
    with pytest.raises(InputError, match="a value of click is out of range"):
        project.apply(place(Click(3, "N_left", "head\0", (1.0, 2.0))))
    assert project.clicks.count() == 1
    assert len(History(project._access).entries()) == 1


def test_a_recording_whose_path_is_made_up_is_not_found(stranger, capsys, tmp_path):
    change(
        stranger,
        "UPDATE recording SET absolute = '/no' || char(27) || '[31m/where' || char(10) || 'else',"
        " relative = '', name = 'walk' || char(7)",
    )
    assert main(["export", str(stranger), "--format", "csv", "-o", str(tmp_path / "c.csv")]) == 2
    said = capsys.readouterr().err.rstrip("\n")
    assert "the project's recording was not found" in said
    assert said.isprintable()


def test_a_project_that_lost_its_recording_asks_for_it(stranger, recording):
    change(stranger, "DELETE FROM recording")
    with Project.open(stranger) as project:
        assert project.find_recording().folder is None
        assert "the recording of the project is not known" in project.find_recording().finding.what
        project.use_recording(recording.folder)
        assert project.find_recording().folder == recording.folder
