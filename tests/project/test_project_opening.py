"""Who may open a project, from where, and in which format; nothing is changed by refusing."""

import errno
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from contextlib import closing
from pathlib import Path

import pytest

from stereotrack_core import locks
from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.locks import lock_path
from stereotrack_core.project import opening
from stereotrack_core.project.clicks import place
from stereotrack_core.project.project import Project
from tests.project.conftest import PROCESSES

ROOT = Path(__file__).parents[2]
ELBOW = Click(1, "N_right", "left_elbow", (10.25, 20.5))


def hold(path, pipe) -> None:
    with Project.open(path, who="B"):
        pipe.send("open")
        pipe.recv()


@pytest.fixture
def held(project, project_path):
    project.apply(place(ELBOW))
    project.close()
    pipe, other = PROCESSES.Pipe()
    process = PROCESSES.Process(target=hold, args=(project_path, other))
    process.start()
    assert pipe.recv() == "open"
    yield process
    process.kill()
    process.join()


def test_the_second_program_is_told_who_has_it(held, project_path):
    with pytest.raises(InputError, match=f"process {held.pid} on .*Close it there"):
        Project.open(project_path)


def test_the_second_program_may_read(held, project_path):
    with Project.open(project_path, read_only=True) as reading:
        assert [click.key for click in reading.clicks.all()] == [ELBOW.key]
        with pytest.raises(InputError, match="read-only"):
            reading.apply(place(ELBOW))


def test_a_crashed_owner_does_not_stand_in_the_way(held, project_path):
    held.kill()
    held.join()
    with Project.open(project_path) as again:
        assert "did not close it; all edits are saved" in again.notes[0].what
        assert str(held.pid) in again.notes[0].what
    with Project.open(project_path) as again:
        assert again.notes == ()


def test_nothing_is_left_beside_a_closed_project(project, project_path):
    before = {project_path.name, "walk"}
    assert lock_path(project_path).exists()
    project.close()
    project.close()
    assert {path.name for path in project_path.parent.iterdir()} == before


def test_a_link_to_a_project_is_the_project(project, project_path, tmp_path):
    link = tmp_path / "link.stereotrack"
    link.symlink_to(project_path)
    with pytest.raises(InputError, match="already open"):
        Project.open(link)
    project.close()
    with Project.open(link) as again:
        assert again.path == project_path


@pytest.mark.parametrize("how", ["deleted", "moved", "replaced"])
def test_edits_never_go_into_a_file_that_is_gone(project, project_path, tmp_path, how):
    project.apply(place(ELBOW))
    copy = tmp_path / "copy.stereotrack"
    if how == "moved":
        project_path.rename(tmp_path / "moved.stereotrack")
    else:
        project_path.unlink()
    if how == "replaced":
        project_path.touch()
    with pytest.raises(InputError, match=r"while it was open.*Save a copy"):
        project.undo()
    project.save_copy(copy)
    with Project.open(copy) as saved:
        assert saved.notes == ()
        assert [click.key for click in saved.clicks.all()] == [ELBOW.key]
        assert saved.undo() is not None


def test_a_copy_is_whole_and_the_project_goes_on(project, project_path, tmp_path):
    project.apply(place(ELBOW))
    copy = tmp_path / "mine.stereotrack"
    project.save_copy(copy)
    project.undo()
    with pytest.raises(InputError, match="the project itself"):
        project.save_copy(project_path)
    with Project.open(copy) as saved:
        assert saved.clicks.count() == 1


def test_on_a_drive_without_locks_the_note_in_the_file_counts(project, project_path, monkeypatch):
    def no_locks(file: object, operation: int) -> None:
        raise OSError(errno.ENOLCK, "no locks available")

    project.close()
    monkeypatch.setattr("stereotrack_core.locks.fcntl.flock", no_locks)
    with Project.open(project_path), pytest.raises(InputError, match="force unlock the project"):
        Project.open(project_path)
    Project.open(project_path).close()


def test_another_machine_on_a_network_drive_is_asked_for(project, project_path, monkeypatch):
    """The system's lock may not reach from machine to machine; the note in the file does."""
    project.close()
    monkeypatch.setattr(opening, "machine_mounts", lambda: (("/", "nfs4"),))
    left = locks.Owner("other-machine", 5, "B", locks.now())
    with closing(sqlite3.connect(project_path, isolation_level=None)) as database:
        opening.write_owner(database, left)
    with pytest.raises(InputError, match=r"process 5 on other-machine.*force unlock the project"):
        Project.open(project_path)
    with Project.open(project_path, take_over=True) as taken:
        taken.apply(place(ELBOW))
        assert not project_path.with_name(f"{project_path.name}-wal").exists()
        assert any("process 5 on other-machine" in note.what for note in taken.notes)


@pytest.mark.parametrize("version", [0, 4])
def test_a_project_of_another_format_is_refused_and_left_alone(project, project_path, version):
    project.close()
    with closing(sqlite3.connect(project_path)) as database:
        database.execute(f"PRAGMA user_version = {version}")
    before = project_path.read_bytes()
    for read_only in (False, True):
        with pytest.raises(
            InputError, match=rf"has format {version}, and .* reads formats 1 to 3.*created"
        ):
            Project.open(project_path, read_only=read_only)
    assert project_path.read_bytes() == before
    assert not lock_path(project_path).exists()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "there is no such file"),
        (b"", "the file is empty"),
        (b"frame,view,landmark,x,y,visibility\n", "not a stereotrack project"),
        (b"SQLite format 3\0".ljust(60, b"\0"), "ends after 60 bytes"),
    ],
)
def test_other_files_are_refused(tmp_path, content, said):
    path = tmp_path / "some.stereotrack"
    if content is not None:
        path.write_bytes(content)
    for read_only in (False, True):
        with pytest.raises(InputError, match=said):
            Project.open(path, read_only=read_only)


def test_a_project_is_not_made_over_another_file(recording, tmp_path):
    path = tmp_path / "taken.stereotrack"
    path.write_text("mine")
    with pytest.raises(InputError, match="a file of this name already"):
        Project.create(path, recording.folder)
    assert path.read_text() == "mine"


@pytest.fixture
def folder():
    """A folder that every user of the machine can come to."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


@pytest.mark.skipif(not hasattr(os, "setuid"), reason="needs a user without rights")
@pytest.mark.parametrize("how", ["closed", "open"])
def test_a_project_in_a_read_only_folder_is_read_as_it_is(project, project_path, folder, how):
    project.apply(place(ELBOW))
    if how == "closed":
        project.close()
    else:
        with project._access.alone() as database:
            database.execute("PRAGMA wal_checkpoint").fetchall()
    shutil.copyfile(project_path, folder / project_path.name)
    content, note, refused = asked_without_rights(folder / project_path.name)
    assert content == "[(10.25, 20.5)]"
    assert ("copied or moved while" in note) == (how == "open")
    assert "cannot write beside" in refused


ASKER = """
import os, sys
from pathlib import Path
path = Path(sys.argv[1])
for file in path.parent.iterdir():
    file.chmod(0o444)
path.parent.chmod(0o555)
from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
if os.getuid() == 0:
    os.setuid(65534)
with Project.open(path, read_only=True) as project:
    print([click.position for click in project.clicks.all()])
    print([note.what for note in project.notes])
try:
    Project.open(path)
except InputError as error:
    print(error)
"""


def asked_without_rights(path: Path) -> list[str]:
    """What a process that may not write to the folder finds in a project."""
    result = subprocess.run(
        [sys.executable, "-c", ASKER, str(path)], capture_output=True, text=True, cwd=ROOT
    )
    path.parent.chmod(0o755)
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()
