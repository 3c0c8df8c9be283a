"""Programs that are killed at any moment: what was finished stays, nothing is half there."""

import multiprocessing
import os
import random
import signal
import sys
import time
from collections.abc import Iterator

import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import has_frames
from stereotrack_core.program import main
from stereotrack_core.study.store import journal_of, stored_results
from tests.conftest import FAST
from tests.same_run import same_run

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no SIGKILL here"),
]

# Kills of each kind, at moments drawn from a seed, over the time that the work takes.
KILLS = int(os.environ.get("STEREOTRACK_KILLS", "200"))


def run_program(words: list[str]) -> None:
    """Run a command line without what it says."""
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_RDWR), stream)
    sys.exit(main(words))


def killed_after(seconds: float | None, *words: object) -> int:
    """Do it in a process that is killed after so long (None: never); how it ended."""
    forking = multiprocessing.get_context("forkserver")
    forking.set_forkserver_preload(["stereotrack_core.program", "numba", "scipy.linalg"])
    process = forking.Process(target=run_program, args=([*map(str, words)],))
    process.start()
    if seconds is not None:
        time.sleep(seconds)
        process.kill()
    process.join()
    return process.exitcode


def seconds_of(*words: object) -> float:
    """How long a command takes once everything is compiled."""
    assert killed_after(None, *words) == 0
    begun = time.monotonic()
    assert killed_after(None, *words) == 0
    return time.monotonic() - begun


def moments(name: str, longest: float) -> Iterator[float]:
    """Moments of the kills, in seconds."""
    chance = random.Random(name)
    return (chance.uniform(0.0, 1.05 * longest) for _ in range(KILLS))


def test_a_run_that_is_killed_again_and_again_is_finished_at_last(sound, tmp_path):
    """Each attempt goes on from what the one before has kept."""
    whole, place = tmp_path / "whole.npz", tmp_path / "run.npz"
    part = place.with_name("run.npz.part")
    longest = seconds_of("track", sound, "-o", whole, *FAST)
    wanted, older, kept, finished = read_run(whole), b"", 0, 0
    for seconds in moments("track", longest):
        resumes = has_frames(part)
        words = ("--resume",) if resumes else FAST
        status = killed_after(seconds, "track", sound, "-o", place, *words)
        assert status in (0, -signal.SIGKILL)
        now = place.read_bytes() if place.exists() else b""
        if part.exists():
            assert now == older or same_run(read_run(place), wanted)
            left = read_run(part).frame.tolist() if has_frames(part) else []
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
        assert killed_after(None, "track", sound, "-o", place, "--resume") == 0
    assert same_run(read_run(place), wanted)
    assert not has_frames(part)


def test_a_sweep_goes_on_from_every_result_that_it_has_told(sound, tmp_path):
    quick = ("--preset", "fast", "--set", "fit_shape=no", "--frames", "0:3", "--init", "tpose")
    grid = ("--grid", "iterations=2,3", "--workers", 1)
    longest = seconds_of("sweep", sound, *quick, *grid, "-o", tmp_path / "whole.csv")
    table = tmp_path / "sweep.csv"
    journal = journal_of(table)
    known: dict[str, object] = {}
    for seconds in moments("sweep", longest):
        killed_after(seconds, "sweep", sound, *quick, *grid, "-o", table)
        found = stored_results(table)
        assert known.keys() <= found.keys()
        known = found
        if len(known) == 2:
            for path in (journal, table):
                path.unlink(missing_ok=True)
            known = {}
