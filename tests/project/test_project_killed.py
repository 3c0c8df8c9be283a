"""A program that is killed while editing loses nothing that it has acknowledged."""

from __future__ import annotations

import os
import random
import runpy
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import pytest

from stereotrack_core.project.database import make_database
from stereotrack_core.project.project import Project

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no SIGKILL here")

PROGRAM = Path(__file__).with_name("editing_process.py")
EDITING = runpy.run_path(str(PROGRAM))
MOST_EDITS = 40
LONGEST = 0.03
"""Acknowledged edits before a process is killed, and seconds after the last of them, at most."""


class Editors:
    """Processes that edit a project, one after the other, until they are killed."""

    def __init__(self) -> None:
        self.server = subprocess.Popen(
            [sys.executable, str(PROGRAM)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=PROGRAM.parents[2],
            env={**os.environ, "PYTHONPATH": str(PROGRAM.parents[2])},
        )

    def edit_and_die(
        self, path: Path, seed: int, edits: int, seconds: float, *, interactive: bool
    ) -> int:
        """Let one edit, kill it so long after so many edits, and count what it acknowledged."""
        self.server.stdin.write(f"{seed} {interactive} {path}\n")
        self.server.stdin.flush()
        process = int(self.server.stdout.readline())
        for _ in range(edits):
            assert self.server.stdout.readline() == ".\n"
        time.sleep(seconds)
        os.kill(process, signal.SIGKILL)
        acknowledged = edits
        while (line := self.server.stdout.readline()) == ".\n":
            acknowledged += 1
        assert line == f"ended {-signal.SIGKILL}\n"
        return acknowledged

    def close(self) -> None:
        self.server.stdin.close()
        self.server.wait()
        self.server.stdout.close()


@pytest.fixture
def editors() -> Iterator[Editors]:
    started = Editors()
    yield started
    started.close()


def content(project: Project) -> tuple[object, ...]:
    """Clicks, deleted ones too, and the whole history; but for the time of day."""
    clicks = [replace(click, at="") for click in project.clicks.all(with_deleted=True)]
    entries = project.history.entries(limit=10**9)
    return clicks, [(entry.number, entry.words, entry.who, entry.state) for entry in entries]


@pytest.mark.parametrize("interactive", [False, True])
@pytest.mark.parametrize("kills", [8, pytest.param(200, marks=pytest.mark.slow)])
def test_nothing_acknowledged_is_lost_and_nothing_is_half_done(
    tmp_path, editors, kills, interactive
):
    """A twin that nobody kills makes the same edits; both hold the same after every kill."""
    moments = random.Random(3)
    path, twin_path = tmp_path / "killed.stereotrack", tmp_path / "twin.stereotrack"
    make_database(path)
    make_database(twin_path)
    with Project.open(twin_path, who="A") as twin:
        for seed in range(kills):
            edits, seconds = moments.randrange(MOST_EDITS), moments.uniform(0.0, LONGEST)
            acknowledged = editors.edit_and_die(path, seed, edits, seconds, interactive=interactive)
            steps = EDITING["steps"](seed)
            for step in islice(steps, acknowledged):
                EDITING["make"](twin, step)
            with Project.open(path) as killed:
                found = content(killed)
            if found != content(twin):  # the last edit was saved, but killed before it could say so
                EDITING["make"](twin, next(steps))
            assert found == content(twin)
        with Project.open(path) as killed:
            while killed.undo() is not None:
                twin.undo()
            assert content(killed) == content(twin)
            assert killed.clicks.all(with_deleted=True) == ()
