"""Jobs in processes of this machine, and on a real Dask cluster of it."""

import dataclasses
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.study import workers as workers_module
from stereotrack_core.study.job import do_batch
from stereotrack_core.study.points import Point, grid_points, parsed_axis
from stereotrack_core.study.workers import ClusterWorkers, LocalWorkers, do_job
from tests.study.conftest import Watched

ROOT = Path(__file__).resolve().parents[3]


class DaskCluster:
    """A scheduler and two workers with one thread each, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "scheduler.json"
        self._log = (folder / "cluster.log").open("ab")
        common = ("--scheduler-file", str(self.file))
        local = ("--host", "127.0.0.1", "--no-dashboard")
        self._scheduler = self._started("scheduler", *common, "--port", "0", *local)
        while not self._is_announced():
            time.sleep(0.05)
        self.workers = [
            self._started(
                "worker", *common, "--nthreads", "1", "--no-nanny", *local,
                "--local-directory", str(folder), "--death-timeout", "300",
            )
            for _ in range(2)
        ]  # fmt: skip

    def kill_worker(self) -> int:
        """Kill one of the workers in the middle of whatever it does; its process number."""
        process = self.workers.pop()
        process.kill()
        process.wait()
        return process.pid

    def close(self) -> None:
        for process in (*self.workers, self._scheduler):
            process.kill()
            process.wait()
        self._log.close()

    def _is_announced(self) -> bool:
        """Whether the scheduler's file is written to its end."""
        try:
            return bool(json.loads(self.file.read_text())["address"])
        except (FileNotFoundError, ValueError):
            return False

    def _started(self, kind: str, *arguments: str) -> subprocess.Popen:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
        return subprocess.Popen(command, env=environment, stdout=self._log, stderr=self._log)


def knows(key: str, dask_scheduler=None) -> bool:
    """Whether somebody still wants what a key stands for; runs on the scheduler."""
    return key in dask_scheduler.tasks


FIRST = "STEREOTRACK_TEST_FIRST"
"""Variable of the file that tells which process was the first to track something."""


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


class Killing(Watched):
    """Kills the process that stays where it is."""

    killed = None

    def __init__(self, first):
        super().__init__()
        self._first = first

    def on_frames(self, count):
        super().on_frames(count)
        if self.killed is None and self._first.exists():
            self.killed = int(self._first.read_text())
            os.kill(self.killed, signal.SIGKILL)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there is no such signal")
def test_a_killed_process_loses_nothing_and_processes_give_what_one_gives(
    plan, tmp_path, monkeypatch
):
    monkeypatch.setenv(FIRST, str(tmp_path / "first"))
    monkeypatch.setattr(workers_module, "_do", do_until_killed)
    jobs = plan(*grid_points([parsed_axis("views=N,NS"), parsed_axis("iterations=2,3")]))
    missing = dataclasses.replace(jobs[0], identity="gone", clouds="gone", folder="/nowhere")
    with LocalWorkers(2) as workers:
        watcher = Killing(tmp_path / "first")
        workers.do([*jobs, missing], watcher)
        pids = {one.pid for one in workers._processes}
        assert len(pids) <= 2
        assert watcher.killed not in {None, *pids}
    results = watcher.results
    assert sorted(watcher.told) == sorted([*(job.identity for job in jobs), "gone"])
    assert results.pop("gone").final
    assert {result.status for result in results.values()} == {"done"}
    assert max(result.attempts for result in results.values()) == 2
    for job in jobs[:2]:
        (alone,) = do_batch([job])
        for name in ("forearms", "upper_arms_p95", "unexplained_fraction"):
            assert results[job.identity].measures[name] == alone.measures[name]


def test_stopping_keeps_what_was_told(plan):
    watcher = Watched(enough=1)
    with LocalWorkers(1) as workers:
        with pytest.raises(Cancelled):
            workers.do(plan(Point(), seeds=tuple(range(40))), watcher)
        assert [one.pid for one in workers._processes] == [None]
    assert 1 <= len(watcher.told) < 40


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory):
    running = DaskCluster(tmp_path_factory.mktemp("dask"))
    yield running
    running.close()


def until(fact, seconds=300):
    end = time.monotonic() + seconds
    while not fact():
        assert time.monotonic() < end
        time.sleep(0.05)


class KillsAWorker(Watched):
    """Kills one of the workers at the first result, once the scheduler knows that it was told."""

    killed = None

    def __init__(self, running, client):
        super().__init__()
        self._running, self._client = running, client

    def on_result(self, job, result):
        super().on_result(job, result)
        if self.killed is None:
            until(lambda: not self._client.run_on_scheduler(knows, job.identity))
            self.killed = self._running.kill_worker()


def test_a_killed_worker_loses_nothing(plan, two_workers):
    points = grid_points([parsed_axis("iterations=2,3,4,5")])
    jobs = plan(*points, seeds=(0, 1))
    with ClusterWorkers(str(two_workers.file)) as executor:
        until(lambda: executor.count == 2)
        watcher = KillsAWorker(two_workers, executor._client)
        executor.do(jobs, watcher)
        assert watcher.killed is not None
        until(lambda: executor.count == 1)
        assert sorted(watcher.told) == sorted(job.identity for job in jobs), "each told once"
        assert {result.status for result in watcher.results.values()} == {"done"}
        assert watcher.frames == sum(len(job.frames) for job in jobs)
        (alone,) = do_batch(jobs[:1])
        told = watcher.results[jobs[0].identity].measures
        assert told["forearms"] == alone.measures["forearms"]

        few = Watched(enough=1)
        with pytest.raises(Cancelled):
            executor.do(plan(*points, seeds=(4, 5, 6)), few)
        assert len(few.told) < 12


def test_a_worker_of_another_version_computes_nothing(plan):
    (job,) = plan(Point())
    told = do_job(job, "0.0.0-other")
    assert told.final
    assert "not 0.0.0-other" in told.error


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
