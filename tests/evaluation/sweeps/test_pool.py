"""Jobs in processes of this machine."""

import dataclasses
import os
import signal

import pytest

from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.sweeps.batches import Batches
from stereotrack_core.evaluation.sweeps.points import Point, grid_points, parsed_axis
from stereotrack_core.evaluation.sweeps.pool import LocalWorkers
from stereotrack_core.evaluation.sweeps.work import do_batch


def test_batches_share_clouds_and_become_small(plan):
    points = grid_points([parsed_axis("views=N,NS"), parsed_axis("iterations=2,3,4,5,6,7")])
    batches = Batches(plan(*points, seeds=(0, 1)), workers=2, together=5)
    sizes, clouds, seen = [], None, []
    while (batch := batches.next(clouds)) is not None:
        clouds = batch.jobs[0].clouds
        assert {job.clouds for job in batch.jobs} == {clouds}
        sizes.append(len(batch.jobs))
        seen += batch.jobs
    assert len({job.identity for job in seen}) == len(seen) == 24
    assert sizes[:2] == [5, 5]
    assert sizes[-1] == 1
    assert seen[0].views == ("N", "S"), "what takes longest comes first"
    assert len(batches) == 0


def test_jobs_that_are_tried_again_come_last_and_alone(plan):
    jobs = plan(Point(), seeds=(0, 1, 2, 3))
    batches = Batches(jobs[:2], workers=1, together=2)
    batches.put_back(jobs[2], 1)
    batches.put_back(jobs[3], 1)
    found = []
    while (batch := batches.next()) is not None:
        found.append((len(batch.jobs), batch.tried))
    assert found == [(1, 0), (1, 0), (1, 1), (1, 1)]


class Killing:
    """Kills a process as soon as it has tracked something."""

    def __init__(self, watched, workers):
        self._watched, self._workers = watched, workers
        self.killed = []

    def on_frames(self, count):
        self._watched.on_frames(count)
        if not self.killed:
            self.killed.append(self._workers.pids[0])
            os.kill(self.killed[0], signal.SIGKILL)

    def __getattr__(self, name):
        return getattr(self._watched, name)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no such signal")
def test_a_killed_process_loses_nothing_and_processes_give_what_one_gives(plan, watched):
    jobs = plan(*grid_points([parsed_axis("views=N,NS"), parsed_axis("iterations=2,3")]))
    missing = dataclasses.replace(jobs[0], identity="gone", clouds="gone", folder="/nowhere")
    with LocalWorkers(2, together=2) as workers:
        watcher = Killing(watched(), workers)
        workers.do([*jobs, missing], watcher)
        assert len(workers.pids) <= 2
    results = watcher.results
    assert sorted(watcher.told) == sorted([*(job.identity for job in jobs), "gone"])
    assert results.pop("gone").final
    assert {result.status for result in results.values()} == {"done"}
    assert max(result.attempts for result in results.values()) == 2
    for job in jobs[:2]:
        (alone,) = do_batch([job])
        for name in ("forearms", "upper_arms_p95", "coverage"):
            assert results[job.identity].measures[name] == alone.measures[name]


def test_stopping_keeps_what_was_told(plan, watched):
    watcher = watched(enough=1)
    with LocalWorkers(1, together=1) as workers:
        with pytest.raises(Cancelled):
            workers.do(plan(Point(), seeds=tuple(range(40))), watcher)
        assert workers.pids == ()
    assert 1 <= len(watcher.told) < 40
