"""What the commands that track many recordings share: ``sweep`` and ``study run``."""

from __future__ import annotations

import dataclasses
from argparse import Namespace
from typing import Any, TypeVar

from stereotrack_core.experiments.runner.cluster import ClusterWorkers
from stereotrack_core.experiments.runner.local import LocalWorkers
from stereotrack_core.experiments.sweep.points import HowToTrack
from stereotrack_core.worker_processes import usable_cores

T = TypeVar("T", bound=HowToTrack)


def request_of(args: Namespace, kind: type[T]) -> T:
    """What was asked for by options; those that the command does not have are as usual."""
    given: dict[str, Any] = {}
    for field in dataclasses.fields(kind):
        value = getattr(args, field.name, field.default)
        given[field.name] = tuple(value) if isinstance(value, list) else value
    return kind(**given)


def executor_of(request: HowToTrack) -> ClusterWorkers | LocalWorkers:
    """Who does the jobs: a cluster, or processes of this machine."""
    if request.scheduler:
        return ClusterWorkers(
            request.scheduler, certificates=request.certificates(), retries=request.retries
        )
    count = request.workers or usable_cores()
    return LocalWorkers(count, together=request.together, retries=request.retries)
