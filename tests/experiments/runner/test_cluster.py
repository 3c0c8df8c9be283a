"""Jobs on a real Dask cluster of this machine."""

import dataclasses
import sys
import time

import pytest

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.experiments.runner import cluster as cluster_module
from stereotrack_core.experiments.runner.cluster import (
    ChanceError,
    ClusterWorkers,
    do_job,
    lacking,
)
from stereotrack_core.experiments.runner.job import do_batch, failure
from stereotrack_core.experiments.sweep.points import Point, grid_points, parsed_axis
from tests.experiments.runner.dask_cluster import DaskCluster, computed_again, knows


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory):
    running = DaskCluster(tmp_path_factory.mktemp("dask"), workers=2)
    yield running
    running.close()


def until(fact, seconds=300):
    end = time.monotonic() + seconds
    while not fact():
        assert time.monotonic() < end
        time.sleep(0.05)


class KillsAWorker:
    """Kills one of the workers at the first result, once the scheduler knows that it was told."""

    def __init__(self, watched, running, client):
        self._watched, self._running, self._client = watched, running, client
        self.killed = None

    def on_result(self, job, result):
        self._watched.on_result(job, result)
        if self.killed is None:
            until(lambda: not self._client.run_on_scheduler(knows, job.identity))
            self.killed = self._running.kill_worker()

    def __getattr__(self, name):
        return getattr(self._watched, name)


def test_a_killed_worker_loses_nothing_and_nothing_is_computed_twice(plan, watched, two_workers):
    points = grid_points([parsed_axis("iterations=2,3,4,5")])
    jobs = plan(*points, seeds=(0, 1))
    with ClusterWorkers(str(two_workers.file)) as executor:
        until(lambda: executor.count == 2)
        with pytest.raises(InputError, match=r"worker tcp.*cannot use the recording cones"):
            executor.check([dataclasses.replace(jobs[0], folder="/not/on/the/worker")])
        watcher = KillsAWorker(watched(), two_workers, executor._client)
        executor.do(jobs, watcher)
        assert watcher.killed is not None
        until(lambda: executor.count == 1)
        assert sorted(watcher.told) == sorted(job.identity for job in jobs), "each told once"
        assert {result.status for result in watcher.results.values()} == {"done"}
        again = executor._client.run_on_scheduler(computed_again)
        assert [again[job.identity] for job in jobs] == [0] * len(jobs)
        assert watcher.frames == sum(len(job.frames) for job in jobs)
        (alone,) = do_batch(jobs[:1])
        told = watcher.results[jobs[0].identity].measures
        assert told["forearms"] == alone.measures["forearms"]

        few = watched(enough=1)
        with pytest.raises(Cancelled):
            executor.do(plan(*points, seeds=(4, 5, 6)), few)
        assert len(few.told) < 12


def test_what_a_worker_lacks_is_said(plan, copied):
    (job,) = plan(Point(), recording=copied.open())
    version = cluster_module.__version__
    assert lacking((job,), version) == ""
    assert "version" in lacking((job,), "9.9")
    (copied.folder / "calibration.toml").write_text("")
    assert "cannot use the recording cones" in lacking((job,), version)


def test_a_worker_that_may_not_read_the_recording_says_so(plan, monkeypatch):
    def refuse(_job):
        raise PermissionError(13, "Permission denied", "recording.toml")

    (job,) = plan(Point())
    monkeypatch.setattr(cluster_module, "recording_of", refuse)
    assert "Permission denied" in lacking((job,), cluster_module.__version__)


class Fetched:
    """A future whose worker dies with its result, which another then finds again, or nobody."""

    key = "job"

    def __init__(self, then):
        self.status, self._then = "lost", then

    def exception(self):
        self.status = self._then

    def result(self):
        return "found again"


def test_a_result_that_died_with_its_worker_is_waited_for(plan, monkeypatch):
    (job,) = plan(Point())
    executor = ClusterWorkers.__new__(ClusterWorkers)
    executor._address = "tcp://a:1"
    assert executor._result(job, Fetched("finished")) == "found again"
    with pytest.raises(InputError, match="lost the jobs"):
        executor._result(job, Fetched("cancelled"))


def test_a_failure_by_chance_is_left_to_dask_to_repeat(plan, monkeypatch):
    (job,) = plan(Point())
    monkeypatch.setattr(cluster_module.cv2, "setNumThreads", lambda count: None)
    for error, final in ((ValueError("oops"), False), (InputError("wrong"), True)):
        told = failure(job.identity, error, final=final)
        monkeypatch.setattr(cluster_module, "do_batch", lambda jobs, told=told: iter([told]))
        if final:
            assert do_job(job) == told
        else:
            with pytest.raises(ChanceError, match="ValueError: oops"):
                do_job(job)


def test_without_a_scheduler_it_is_said_what_to_do(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="scheduler file was not found"):
        ClusterWorkers(str(tmp_path / "none.json"))
    with pytest.raises(InputError, match=r"no scheduler answers at this address.*dask scheduler"):
        ClusterWorkers("tcp://127.0.0.1:9", patience=0.5)
    with pytest.raises(InputError, match="no scheduler answers"):
        ClusterWorkers("nonsense://x", patience=0.5)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"stereotrack\[cluster\]"):
        ClusterWorkers("tcp://127.0.0.1:9")


def test_an_address_that_needs_certificates_says_so():
    with pytest.raises(InputError, match="needs certificates"):
        ClusterWorkers("tls://127.0.0.1:1", patience=0.5)
