"""A program that is killed while editing loses nothing that it has acknowledged."""

import os
import random
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import islice

import pytest

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.project.clicks import delete_clicks, move_clicks, place_clicks
from stereotrack_core.project.database import make_database
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.project import Project
from tests.project.conftest import PROCESSES

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no SIGKILL here")
MOST_EDITS = 40
LONGEST = 0.03
"""Acknowledged edits before a process is killed, and seconds after the last of them, at most."""

Step = Callable[[Project], object]
LANDMARKS = ("left_elbow", "right_elbow", "head")
CAMERAS = ("N_right", "S_cam")


def steps(seed: int) -> Iterator[Step]:
    """Edits without end: single ones, many clicks at once, undo and redo."""
    choose = random.Random(seed)
    while True:
        kind = choose.choices(("one", "many", "move", "delete", "undo", "redo"), (6, 1, 2, 2, 2, 1))
        match kind[0]:
            case "one":
                yield _applied(place_clicks((_click(choose, choose.randrange(40)),)))
            case "many":
                first = choose.randrange(1000)
                clicks = tuple(_click(choose, first + i) for i in range(200))
                yield _applied(place_clicks(clicks))
            case "move":
                yield _applied(move_clicks((_key(choose),), (choose.uniform(-1, 1), 0.5)))
            case "delete":
                yield _applied(delete_clicks((_key(choose), _key(choose))))
            case "undo":
                yield Project.undo
            case "redo":
                yield Project.redo


def _applied(edit: Edit) -> Step:
    return lambda project: project.apply(edit)


def _key(choose: random.Random) -> ClickKey:
    return ClickKey(choose.randrange(40), choose.choice(CAMERAS), choose.choice(LANDMARKS))


def _click(choose: random.Random, frame: int) -> Click:
    position = (choose.uniform(0, 63), choose.uniform(0, 47))
    return Click(frame, choose.choice(CAMERAS), choose.choice(LANDMARKS), position)


def edit_until_killed(path, seed, acknowledge) -> None:
    with Project.open(path, who="A") as project:
        for step in steps(seed):
            step(project)
            acknowledge.send_bytes(b".")


def edit_and_die(path, seed, edits, seconds) -> int:
    """Kill a process so long after so many edits, and count what it acknowledged."""
    heard, acknowledge = PROCESSES.Pipe(duplex=False)
    process = PROCESSES.Process(target=edit_until_killed, args=(path, seed, acknowledge))
    process.start()
    acknowledge.close()
    for _ in range(edits):
        heard.recv_bytes()
    time.sleep(seconds)
    process.kill()
    process.join()
    with heard, suppress(EOFError):
        while heard.recv_bytes():
            edits += 1
    return edits


def content(project: Project) -> tuple[object, ...]:
    """Clicks, deleted ones too, and the whole history; but for the time of day."""
    clicks = [replace(click, at="") for click in project.clicks.all(with_deleted=True)]
    entries = project.history.entries(limit=10**9)
    return clicks, [(entry.number, entry.words, entry.who, entry.state) for entry in entries]


@pytest.mark.parametrize("kills", [8, pytest.param(200, marks=pytest.mark.slow)])
def test_nothing_acknowledged_is_lost_and_nothing_is_half_done(tmp_path, kills):
    """A twin that nobody kills makes the same edits; both hold the same after every kill."""
    moments = random.Random(3)
    path, twin_path = tmp_path / "killed.stereotrack", tmp_path / "twin.stereotrack"
    make_database(path)
    make_database(twin_path)
    with Project.open(twin_path, who="A") as twin:
        for seed in range(kills):
            least, seconds = moments.randrange(MOST_EDITS), moments.uniform(0.0, LONGEST)
            acknowledged = edit_and_die(path, seed, least, seconds)
            edits = steps(seed)
            for step in islice(edits, acknowledged):
                step(twin)
            with Project.open(path) as killed:
                found = content(killed)
            if found != content(twin):  # the last edit was saved, but killed before it could say so
                next(edits)(twin)
            assert found == content(twin)
        with Project.open(path) as killed:
            while killed.undo() is not None:
                twin.undo()
            assert content(killed) == content(twin)
            assert killed.clicks.all(with_deleted=True) == ()
