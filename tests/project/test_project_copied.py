"""The one file has every edit: a copy of it alone, also of an open or a crashed project, or one
that was moved away, has all that was acknowledged before, or says that it is not whole."""

import itertools
import random
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import place
from stereotrack_core.project.database import ProjectDamaged, make_database
from stereotrack_core.project.project import Project
from tests.project.conftest import PROCESSES

CLICKS, SOME = 300, 80


def click(number: int) -> Click:
    """The click of that number; every one is of another frame."""
    return Click(number, "N_right", "head", (number % 60 + 0.5, 3.25))


def click_when_told(path, pipe) -> None:
    """Click at every word; ``unfinished`` begins an edit that does not fit into memory."""
    with Project.open(path, who="A") as project:
        for number in itertools.count():
            if pipe.recv() == "unfinished":
                with project._access.writing() as database:
                    database.execute("PRAGMA cache_size = 1")
                    database.execute("UPDATE click SET x = x + 1")
                    database.execute("UPDATE edit_change SET after = after || ' '")
                    pipe.send("half")
                    pipe.recv()
            project.apply(place(click(number)))
            pipe.send("clicked")


class Clicker:
    def __init__(self, path: Path) -> None:
        self.pipe, other = PROCESSES.Pipe()
        self.process = PROCESSES.Process(target=click_when_told, args=(path, other))
        self.process.start()
        other.close()

    def clicks(self, times: int) -> None:
        for _ in range(times):
            self.pipe.send("click")
        assert {self.pipe.recv() for _ in range(times)} == {"clicked"}

    def begins_what_never_ends(self) -> None:
        self.pipe.send("unfinished")
        assert self.pipe.recv() == "half"

    def kill(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


@pytest.fixture
def clicker(path) -> Iterator[Clicker]:
    started = Clicker(path)
    yield started
    started.kill()


def alone(path: Path, folder: Path) -> Path:
    """A copy of the file without anything that lies beside it."""
    folder.mkdir()
    shutil.copyfile(path, folder / path.name)
    return folder / path.name


def check_has(path: Path, count: int) -> None:
    """All of the first clicks and no others, each one an edit that can be undone; and it is told
    once that the file was copied or moved."""
    for read_only in (True, False):
        with Project.open(path, read_only=read_only) as project:
            assert [one.key for one in project.clicks.all()] == [click(k).key for k in range(count)]
            (note,) = project.notes
            assert "copied or moved while" in note.what
            assert "all edits until then are saved" in note.what
    with Project.open(path) as project:
        assert project.notes == ()
        assert project.undo() is not None
        assert project.clicks.count() == count - 1


def test_a_copy_of_an_open_project_has_every_click(path, clicker, tmp_path):
    done = 0
    for count in sorted(random.Random(6).sample(range(1, CLICKS), 5)):
        clicker.clicks(count - done)
        done = count
        check_has(alone(path, tmp_path / f"{count}"), count)


def test_a_copy_after_a_kill_has_every_click(path, clicker, tmp_path):
    clicker.clicks(CLICKS)
    clicker.kill()
    check_has(alone(path, tmp_path / "copy"), CLICKS)


def test_an_edit_that_a_kill_ended_is_taken_back(crashed):
    assert journal_of(crashed).stat().st_size
    with Project.open(crashed, read_only=True) as reading:
        assert reading.clicks.count() == SOME
    with Project.open(crashed) as project:
        assert [one.position for one in project.clicks.all()] == [
            click(k).position for k in range(SOME)
        ]
        assert "all edits are saved" in project.notes[0].what
        assert project.undo() is not None
    assert not journal_of(crashed).exists()


def journal_of(path: Path) -> Path:
    return path.with_name(path.name + "-journal")


@pytest.mark.parametrize("killed", [False, True])
def test_a_copy_in_the_middle_of_an_edit_says_so(path, clicker, tmp_path, killed):
    clicker.clicks(SOME)
    clicker.begins_what_never_ends()
    if killed:
        clicker.kill()
        copy = path.rename(tmp_path / "moved.stereotrack")
    else:
        copy = alone(path, tmp_path / "copy")
    before = copy.read_bytes()
    for read_only in (True, False):
        with pytest.raises(ProjectDamaged, match=r"during an edit.*ends in -journal"):
            Project.open(copy, read_only=read_only)
    assert copy.read_bytes() == before
    if killed:  # what the sentence says to do
        journal_of(path).rename(journal_of(copy))
        with Project.open(copy) as project:
            assert project.clicks.count() == SOME


@pytest.fixture
def crashed(path, clicker) -> Path:
    """A project whose program was killed in the middle of an edit."""
    clicker.clicks(SOME)
    clicker.begins_what_never_ends()
    clicker.kill()
    return path


def test_a_backup_in_the_place_of_a_crashed_project_is_not_spoilt(crashed, tmp_path):
    """What the crash left beside it belongs to another file, and is not let loose on this one."""
    backup = tmp_path / "backup.stereotrack"
    make_database(backup)
    with Project.open(backup) as project:
        for number in range(20):
            project.apply(place(click(number)))
    backup.replace(crashed)
    before = crashed.read_bytes()
    with pytest.raises(ProjectDamaged, match="If such a file belongs to a different copy"):
        Project.open(crashed)
    assert crashed.read_bytes() == before
    journal_of(crashed).unlink()
    with Project.open(crashed) as project:
        assert project.clicks.count() == 20
        assert project.notes == ()


def test_what_is_read_meanwhile_does_not_stop_the_writer_for_good(path, monkeypatch):
    """Somebody else's tool holds the file for reading: an edit waits, and is refused in words."""
    monkeypatch.setattr("stereotrack_core.project.connection.BUSY_SECONDS", 0.05)
    with Project.open(path) as project, closing(sqlite3.connect(path)) as other:
        project.apply(place(click(0)))
        project.apply(place(click(1)))
        reading = other.execute("SELECT * FROM click")
        reading.fetchone()
        with pytest.raises(InputError, match="another program is reading or writing it"):
            project.apply(place(click(2)))
        reading.close()
        project.apply(place(click(2)))
        assert project.clicks.count() == 3
        assert len(project.history.entries()) == 3
