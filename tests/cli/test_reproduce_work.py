"""``stereotrack reproduce`` with several processes: lost ones, and stopping."""

import multiprocessing
import os
import signal
from contextlib import suppress

import numpy as np
import pytest

from stereotrack_core import worker_processes
from stereotrack_core.cli import reproduce
from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.reproduction.plan import Group, Places, PlannedRun, kept_run
from stereotrack_core.experiments.reproduction.runs import missing_runs
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.worker_processes import Lost


@pytest.fixture(scope="module")
def brief(tmp_path_factory):
    """Two frames."""
    small = SceneOptions().replaced(width=320, height=240, focal=200.0)
    folder = tmp_path_factory.mktemp("cli") / "brief"
    simulate(folder, Simulation(person="P2", motion="t-pose", frames=2, views="NS", options=small))
    return folder


@pytest.fixture
def job(brief, tmp_path):
    """A recording and two groups of runs, to be tracked by two processes."""
    opened = open_recording(brief)
    groups = [Group(opened.name, (PlannedRun("fast", seed=seed),)) for seed in (0, 1)]
    return Places(tmp_path / "ö made"), opened, groups


def track(job, on_group=lambda: None):
    places, recording, groups = job
    reproduce._track(places, [recording], groups, 2, on_group)


@pytest.fixture(autouse=True)
def no_process_is_left():
    """Whatever ends the work, its processes end with it; others may be there before."""
    before = set(multiprocessing.active_children())
    yield
    assert set(multiprocessing.active_children()) <= before


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no such signal")
def test_runs_of_a_killed_process_are_made_anew_and_leave_nothing_half_written(
    job, monkeypatch, capsys
):
    places, recording, groups = job
    path = places.run(recording.name, groups[0].runs[0])
    path.parent.mkdir(parents=True)
    half = path.with_name(f".{path.stem}-{'0' * 32}{path.suffix}")
    half.touch()
    killed = []

    def kill_one(workers, seconds):
        if not killed:
            killed.append(workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)
        return with_words(workers, seconds)

    with_words = worker_processes.with_words
    monkeypatch.setattr(worker_processes, "with_words", kill_one)
    told = []
    track(job, lambda: told.append(True))
    assert len(told) == 2
    assert "exit code -9" in capsys.readouterr().err
    assert sorted(one.name for one in path.parent.iterdir()) == [
        *("fast-seed0.npz", "fast-seed1.npz"),
    ]
    for group in groups:
        (entry,) = group.runs
        assert kept_run(places, recording, fingerprint(recording), entry) is not None
    assert np.isfinite(read_npz(path).landmarks).any()


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no such signal")
def test_a_group_that_is_lost_twice_ends_the_work(job, monkeypatch):
    def kill_all(workers, seconds):
        for worker in workers:
            with suppress(ProcessLookupError):  # it may have been killed and buried already
                os.kill(worker.pid, signal.SIGKILL)
        return with_words(workers, seconds)

    with_words = worker_processes.with_words
    monkeypatch.setattr(worker_processes, "with_words", kill_all)
    with pytest.raises(Lost):
        track(job)


def test_what_is_wrong_in_a_process_is_said_here(job):
    places = job[0]
    places.folder.mkdir()
    (places.folder / "runs").write_text("in the way")
    with pytest.raises(OSError, match="runs"):
        track(job)


@pytest.mark.parametrize("times", [1, 2])
def test_interrupts_end_every_process_and_keep_what_is_finished(job, times, monkeypatch):
    def interrupt(workers, seconds):
        for _ in range(times):
            os.kill(os.getpid(), signal.SIGINT)
        return with_words(workers, seconds)

    with_words = worker_processes.with_words
    monkeypatch.setattr(worker_processes, "with_words", interrupt)
    with pytest.raises((Cancelled, KeyboardInterrupt)):
        track(job)
    places, recording, groups = job
    assert missing_runs(places, [recording], groups) == tuple(groups)
