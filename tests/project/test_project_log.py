"""A project that a person edits in a window: nobody waits for the drive or for a long edit."""

import shutil
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress

import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import PlaceClicks, place
from stereotrack_core.project.connection import LogWriter
from stereotrack_core.project.database import ProjectDamaged
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project

PATIENCE_S = 60.0


def click(frame):
    return Click(frame, "N_right", "head", (frame + 0.5, 3.25))


@pytest.fixture
def edited(path) -> Iterator[Project]:
    with Project.open(path, who="A", interactive=True) as project:
        yield project


class Long(Edit):
    """An edit that ends when the test says so."""

    kind = "long"

    def __init__(self):
        self.begun, self.go = threading.Event(), threading.Event()

    def words(self):
        return "a long edit"

    def changes(self, state, stamp):
        self.begun.set()
        assert self.go.wait(PATIENCE_S)
        return PlaceClicks(tuple(map(click, range(100, 200)))).changes(state, stamp)


@contextmanager
def editing(project):
    """A long edit is under way in another thread within the block."""
    edit = Long()
    thread = threading.Thread(target=project.apply, args=(edit,))
    thread.start()
    assert edit.begun.wait(PATIENCE_S)
    try:
        yield
    finally:
        edit.go.set()
        thread.join(PATIENCE_S)


def test_what_is_there_is_read_while_a_long_edit_is_made(edited):
    edited.apply(place(click(3)))
    with editing(edited):
        assert edited.clicks.at(3) == edited.clicks.all()
        assert edited.history.to_undo().words == "place head in N_right, frame 3"
        assert edited.view_settings.get("lanes") is None
        for change in (lambda: edited.apply(place(click(4))), edited.undo, edited.redo):
            with pytest.raises(InputError, match=r"is being written to.*Repeat this"):
                change()
    assert edited.clicks.count() == 101
    assert edited.apply(place(click(4))) is not None


def test_one_file_is_left_by_who_closes_it(path, edited):
    edited.apply(place(click(3)))
    assert path.with_name(f"{path.name}-wal").exists()
    edited.close()
    assert [one.name for one in path.parent.iterdir()] == [path.name]
    with closing(sqlite3.connect(path)) as database:
        assert database.execute("PRAGMA journal_mode").fetchone()[0] == "delete"
        assert database.execute("SELECT count(*) FROM click").fetchone()[0] == 1


def test_a_reader_does_not_make_the_next_program_refuse_it(path, edited):
    edited.apply(place(click(3)))
    with closing(sqlite3.connect(path)) as reader:
        assert len(reader.execute("SELECT * FROM click").fetchall()) == 1
        edited.close()
        for read_only in (True, False):
            with Project.open(path, read_only=read_only) as project:
                assert project.clicks.count() == 1


def test_a_copy_has_what_was_edited_before_the_last_moment(path, edited, tmp_path):
    for frame in range(50):
        edited.apply(place(click(frame)))
    found, end = 0, time.monotonic() + PATIENCE_S
    while found < 50 and time.monotonic() < end:
        copy = tmp_path / "copy" / path.name
        copy.parent.mkdir(exist_ok=True)
        shutil.copyfile(path, copy)
        # a copy that was made while the log was taken into the file is damaged, and refused
        with suppress(ProjectDamaged), Project.open(copy, read_only=True) as project:
            found = project.clicks.count()
            assert "copied or moved while" in project.notes[0].what
    assert found == 50


def test_a_crash_leaves_all_of_it_beside_the_file(path, tmp_path, monkeypatch):
    monkeypatch.setattr(LogWriter, "soon", lambda _log: None)  # killed before it was written
    with Project.open(path, who="A", interactive=True) as project:
        for frame in range(50):
            project.apply(place(click(frame)))
        killed = tmp_path / "killed"
        killed.mkdir()
        for one in (path, path.with_name(f"{path.name}-wal")):
            shutil.copyfile(one, killed / one.name)
    for read_only in (True, False):
        with Project.open(killed / path.name, read_only=read_only) as found:
            assert found.clicks.count() == 50


def test_a_drive_of_the_network_keeps_to_one_file(path):
    with Project.open(path, interactive=True, mounts=[("/", "nfs4")]) as project:
        project.apply(place(click(3)))
        assert not path.with_name(f"{path.name}-wal").exists()


def test_closing_waits_for_whoever_reads(path):
    """SQLite ends the program where a connection is closed that another thread reads from."""
    for _ in range(40):
        with Project.open(path, who="A", interactive=True) as project:
            project.apply(PlaceClicks(tuple(map(click, range(300)))))
            begun, ended = threading.Event(), []

            def read(project=project, begun=begun, ended=ended):
                try:
                    while True:
                        project.clicks.all()
                        begun.set()
                except sqlite3.ProgrammingError as error:
                    ended.append(str(error))

            thread = threading.Thread(target=read)
            thread.start()
            assert begun.wait(PATIENCE_S)
        thread.join(PATIENCE_S)
        assert "closed" in ended[0]
