"""A project that a person edits in a window: nobody waits for the drive or for a long edit."""

import multiprocessing
import shutil
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress

import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project import opening
from stereotrack_core.project.clicks import place, place_clicks
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project

PATIENCE_S = 60.0


def click(frame):
    return Click(frame, "N_right", "head", (frame + 0.5, 3.25))


@pytest.fixture
def edited(path) -> Iterator[Project]:
    with Project.open(path, who="A") as project:
        yield project


@contextmanager
def editing(project):
    """A long edit is under way in another thread within the block."""
    begun, go = threading.Event(), threading.Event()

    def changes(state, stamp):
        begun.set()
        assert go.wait(PATIENCE_S)
        return place_clicks(list(map(click, range(100, 200)))).changes(state, stamp)

    edit = Edit("long", "a long edit", changes)
    thread = threading.Thread(target=project.apply, args=(edit,))
    thread.start()
    assert begun.wait(PATIENCE_S)
    try:
        yield
    finally:
        go.set()
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


def test_the_log_is_brought_into_the_file_when_nobody_edits(path, edited):
    def in_the_file() -> int:
        """Clicks of the file without its log; 0 in the middle of being written."""
        alone = sqlite3.connect(f"{path.as_uri()}?immutable=1", uri=True)
        with closing(alone), suppress(sqlite3.DatabaseError):
            return alone.execute("SELECT count(*) FROM click").fetchone()[0]
        return 0

    edited.apply(place(click(3)))
    end = time.monotonic() + PATIENCE_S
    while not in_the_file():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_reader_does_not_make_the_next_program_refuse_it(path, edited):
    edited.apply(place(click(3)))
    with closing(sqlite3.connect(path)) as reader:
        assert len(reader.execute("SELECT * FROM click").fetchall()) == 1
        edited.close()
        for read_only in (True, False):
            with Project.open(path, read_only=read_only) as project:
                assert project.clicks.count() == 1


def test_a_copy_of_an_open_project_needs_what_is_beside_it(path, edited, tmp_path):
    for frame in range(120):
        edited.apply(place(click(frame)))
    both, alone = tmp_path / "both" / path.name, tmp_path / "alone" / path.name
    for copy, files in ((both, path.parent.glob(f"{path.name}*")), (alone, [path])):
        copy.parent.mkdir()
        for one in files:
            if not one.name.endswith("-shm"):
                shutil.copyfile(one, copy.with_name(one.name))
    for copy, least in ((both, 120), (alone, 0)):
        for read_only in (True, False):
            with Project.open(copy, read_only=read_only) as project:
                assert least <= project.clicks.count() <= 120
                (note,) = project.notes
                assert "copied or moved while" in note.what
                assert f"{path.name}-wal" in note.remedy
        with Project.open(copy) as project:
            assert project.notes == ()


def edit_without_end(path, pipe) -> None:
    """Click, and begin an edit that does not fit into memory."""
    with Project.open(path, who="A") as project:
        for frame in range(50):
            project.apply(place(click(frame)))
        with project._access.writing() as database:
            database.execute("PRAGMA cache_size = 1")
            database.execute("UPDATE click SET x = x + 1")
            pipe.send("half")
            pipe.recv()


@pytest.mark.parametrize("network", [False, True])
def test_an_edit_that_a_kill_ended_is_taken_back(path, network, monkeypatch):
    if network:
        monkeypatch.setattr(opening, "machine_mounts", lambda: (("/", "nfs4"),))
    pipe, other = multiprocessing.get_context("fork").Pipe()
    process = multiprocessing.get_context("fork").Process(
        target=edit_without_end, args=(path, other)
    )
    process.start()
    assert pipe.recv() == "half"
    process.kill()
    process.join()
    if not network:
        with Project.open(path, read_only=True) as project:
            assert project.clicks.count() == 50
    with Project.open(path) as project:
        assert [one.position for one in project.clicks.all()] == [
            click(k).position for k in range(50)
        ]
        assert "did not close it; all edits are saved" in project.notes[0].what
        assert project.undo() is not None
    assert [one.name for one in path.parent.iterdir()] == [path.name]


def test_closing_waits_for_whoever_reads(path):
    """SQLite ends the program where a connection is closed that another thread reads from."""
    for _ in range(40):
        with Project.open(path, who="A") as project:
            project.apply(place_clicks(tuple(map(click, range(300)))))
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
