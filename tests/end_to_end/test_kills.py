"""Programs that are killed at any moment: what was finished stays, nothing is half there."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import has_frames
from stereotrack_core.study.store import journal_of, stored_results
from tests.end_to_end.conftest import FAST
from tests.same_run import same_run

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no SIGKILL here"),
]

PROGRAM = Path(__file__).with_name("killed_program.py")
ROOT = PROGRAM.parents[2]
KILLS = int(os.environ.get("STEREOTRACK_KILLS", "200"))
"""Kills of each kind, at moments drawn from a seed, over the time that the work takes."""


class Victims:
    """Processes that work until they are killed, one after the other."""

    def __init__(self) -> None:
        self.server = subprocess.Popen(
            [sys.executable, str(PROGRAM)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"},
        )

    def do(self, seconds: float | None, *words: object) -> int:
        """Do it in a child that is killed after so long (None: never); how it ended."""
        self.server.stdin.write(json.dumps([seconds, *map(str, words)]) + "\n")
        self.server.stdin.flush()
        line = self.server.stdout.readline()
        assert line, "the program that forks has ended"
        return int(line)

    def seconds_of(self, *words: object) -> float:
        """Load whatever a command loads by doing it; how long it takes then in a child."""
        assert self.do(0, *words) == 0
        begun = time.monotonic()
        assert self.do(None, *words) == 0
        return time.monotonic() - begun

    def close(self) -> None:
        self.server.stdin.close()
        self.server.wait()
        self.server.stdout.close()


@pytest.fixture
def victims() -> Iterator[Victims]:
    started = Victims()
    yield started
    started.close()


def moments(name: str, longest: float) -> Iterator[float]:
    """Moments of the kills, in seconds."""
    chance = random.Random(name)
    return (chance.uniform(0.0, 1.05 * longest) for _ in range(KILLS))


def test_a_run_that_is_killed_again_and_again_is_finished_at_last(victims, sound, tmp_path):
    """Each attempt goes on from what the one before has kept."""
    whole, place = tmp_path / "whole.npz", tmp_path / "run.npz"
    part = place.with_name("run.npz.part")
    longest = victims.seconds_of("track", sound, "-o", whole, *FAST)
    wanted, older, kept, finished = read_run(whole), b"", 0, 0
    for seconds in moments("track", longest):
        resumes = has_frames(part)
        words = ("--resume",) if resumes else FAST
        status = victims.do(seconds, "track", sound, "-o", place, *words)
        assert status in (0, -signal.SIGKILL)
        now = place.read_bytes() if place.exists() else b""
        if part.exists():
            assert now == older or same_run(read_run(place), wanted)
            left = _frames_of(part)
            assert left == list(range(len(left)))
            assert len(left) >= kept or not resumes
            kept = len(left)
        elif now != older or status == 0:
            finished += 1
            run = read_run(place)
            assert same_run(run, wanted)
            kept = 0
        older = now
    assert finished > 0
    if has_frames(part):
        assert victims.do(None, "track", sound, "-o", place, "--resume") == 0
    assert same_run(read_run(place), wanted)
    assert not has_frames(part)


def _frames_of(part: Path) -> list[int]:
    return read_run(part).frame.tolist() if has_frames(part) else []


def test_a_sweep_goes_on_from_every_result_that_it_has_told(victims, sound, tmp_path):
    quick = ("--preset", "fast", "--set", "fit_shape=no", "--frames", "0:3", "--init", "tpose")
    grid = ("--grid", "iterations=2,3", "--workers", 1)
    longest = victims.seconds_of("sweep", sound, *quick, *grid, "-o", tmp_path / "whole.csv")
    table = tmp_path / "sweep.csv"
    journal = journal_of(table)
    known: dict[str, object] = {}
    for seconds in moments("sweep", longest):
        victims.do(seconds, "sweep", sound, *quick, *grid, "-o", table)
        found = stored_results(table)
        assert known.keys() <= found.keys()
        known = found
        if len(known) == 2:
            for path in (journal, table):
                path.unlink(missing_ok=True)
            known = {}
