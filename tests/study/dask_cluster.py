"""A real Dask cluster on this machine: a scheduler and workers, each a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


class DaskCluster:
    """A scheduler and some workers with one thread each; encrypted with `options` of Dask's."""

    def __init__(self, folder: Path, workers: int, *options: str) -> None:
        self.file = folder / "scheduler.json"
        self._log = (folder / "cluster.log").open("ab")
        common = ("--scheduler-file", str(self.file), *options)
        local = ("--host", "127.0.0.1", "--no-dashboard")
        self._scheduler = self._started("scheduler", *common, "--port", "0", *local)
        while not self._is_announced():
            time.sleep(0.05)
        self.workers = [
            self._started(
                "worker", *common, "--nthreads", "1", "--no-nanny", *local,
                "--local-directory", str(folder), "--death-timeout", "300",
            )
            for _ in range(workers)
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


def computed_again(dask_scheduler=None) -> dict[str, int]:
    """How often each key was computed more than needed; runs on the scheduler.

    What a worker had found and died with, before anybody fetched it, has to be computed again.
    """
    counts: Counter[str] = Counter()
    for key, start, finish, *_ in dask_scheduler.transition_log:
        if finish == "memory":
            counts[str(key)] += 1
        elif start == "memory" and finish != "forgotten":
            counts[str(key)] -= 1
    return {key: count - 1 for key, count in counts.items()}
