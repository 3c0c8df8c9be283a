"""Jobs in processes of this machine."""

import dataclasses
import os
import signal
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.runner import local as pool
from stereotrack_core.experiments.runner.job import do_batch
from stereotrack_core.experiments.runner.local import Batches, LocalWorkers
from stereotrack_core.experiments.sweep.points import Point, grid_points, parsed_axis

FIRST = "STEREOTRACK_TEST_FIRST"
"""Variable of the file that tells which process was the first to track something."""


NOBODY = SimpleNamespace(stopped=lambda: False)


def longer(job, end):
    return dataclasses.replace(job, spec=dataclasses.replace(job.spec, frames=range(end)))


def handed_out(batches):
    found = []
    while (batch := batches.next()) is not None:
        assert len({job.clouds for job in batch.jobs}) == 1
        found.append(batch)
    return found


@pytest.mark.parametrize(
    ("views", "seeds", "workers", "together", "sizes"),
    [
        ("N", 12, 1, 8, [6, 6]),
        ("N", 12, 2, 8, [6, 6]),
        ("N", 24, 2, 8, [6, 6, 6, 6]),
        ("N", 3, 2, 8, [2, 1]),
        ("N", 5, 8, 8, [1] * 5),
        ("N,NS", 12, 2, 8, [6, 6, 6, 6]),
        ("N,O,S,W,NO,NS,NW,OS", 3, 2, 8, [3] * 8),
        ("N", 6, 2, 1, [1] * 6),
    ],
)
def test_batches_share_clouds_and_come_out_even(plan, views, seeds, workers, together, sizes):
    points = grid_points([parsed_axis(f"views={views}")])
    jobs = plan(*points, seeds=tuple(range(seeds)))
    found = handed_out(Batches(jobs, workers, together, NOBODY))
    assert [len(batch.jobs) for batch in found] == sizes
    told = [job.identity for batch in found for job in batch.jobs]
    assert sorted(told) == sorted(job.identity for job in jobs)
    work = [len(batch.jobs) * len(batch.jobs[0].views) for batch in found]
    assert work == sorted(work, reverse=True)


def test_long_runs_go_together_in_smaller_batches(plan):
    jobs = plan(Point(), seeds=tuple(range(12)))
    long = [longer(job, 1200) for job in jobs]
    endless = [longer(job, 9000) for job in jobs]
    assert [len(one.jobs) for one in handed_out(Batches(jobs, 1, None, NOBODY))] == [6, 6]
    assert [len(one.jobs) for one in handed_out(Batches(long, 1, None, NOBODY))] == [3] * 4
    assert [len(one.jobs) for one in handed_out(Batches(endless, 1, None, NOBODY))] == [1] * 12


def test_what_costs_the_same_goes_to_different_batches(plan):
    points = grid_points([parsed_axis("data_points=100,900")])
    found = handed_out(Batches(plan(*points, seeds=(0, 1)), 2, 8, NOBODY))
    assert [{job.seed for job in batch.jobs} for batch in found] == [{0}, {1}]


def test_jobs_that_are_tried_again_come_last_and_alone(plan):
    jobs = plan(Point(), seeds=(0, 1, 2, 3))
    batches = Batches(jobs, 1, 2, NOBODY)
    batches.heard(batches.next(), ValueError("by chance"))
    found = [(len(batch.jobs), batch.tried) for batch in handed_out(batches)]
    assert found == [(2, 0), (1, 1), (1, 1)]


def do_until_killed(batch, asker):
    """Do jobs; the first process that has tracked something says who it is and stays there."""
    first, own = Path(os.environ[FIRST]), Path(f"{os.environ[FIRST]}-{os.getpid()}")

    def on_frames(count):
        own.write_text(str(os.getpid()))
        try:
            os.link(own, first)
        except FileExistsError:
            asker.on_frames(count)
        else:
            asker.on_frames(count)
            time.sleep(600)

    for result in do_batch(batch.jobs, on_frames=on_frames):
        asker.tell(result)


class Killing:
    """Kills the process that stays where it is."""

    def __init__(self, watched, first):
        self._watched, self._first = watched, first
        self.killed = None

    def on_frames(self, count):
        self._watched.on_frames(count)
        if self.killed is None and self._first.exists():
            self.killed = int(self._first.read_text())
            os.kill(self.killed, signal.SIGKILL)

    def __getattr__(self, name):
        return getattr(self._watched, name)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no such signal")
def test_a_killed_process_loses_nothing_and_processes_give_what_one_gives(
    plan, watched, tmp_path, monkeypatch
):
    monkeypatch.setenv(FIRST, str(tmp_path / "first"))
    monkeypatch.setattr(pool, "_do", do_until_killed)
    jobs = plan(*grid_points([parsed_axis("views=N,NS"), parsed_axis("iterations=2,3")]))
    missing = dataclasses.replace(jobs[0], identity="gone", clouds="gone", folder="/nowhere")
    with LocalWorkers(2, together=2) as workers:
        watcher = Killing(watched(), tmp_path / "first")
        workers.do([*jobs, missing], watcher)
        assert len(workers.pids) <= 2
        assert watcher.killed not in {None, *workers.pids}
    results = watcher.results
    assert sorted(watcher.told) == sorted([*(job.identity for job in jobs), "gone"])
    assert results.pop("gone").final
    assert {result.status for result in results.values()} == {"done"}
    assert max(result.attempts for result in results.values()) == 2
    for job in jobs[:2]:
        (alone,) = do_batch([job])
        for name in ("forearms", "upper_arms_p95", "unexplained_fraction"):
            assert results[job.identity].measures[name] == alone.measures[name]


def test_stopping_keeps_what_was_told(plan, watched):
    watcher = watched(enough=1)
    with LocalWorkers(1, together=1) as workers:
        with pytest.raises(Cancelled):
            workers.do(plan(Point(), seeds=tuple(range(40))), watcher)
        assert workers.pids == ()
    assert 1 <= len(watcher.told) < 40
