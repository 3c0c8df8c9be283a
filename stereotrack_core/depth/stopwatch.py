"""Seconds per stage."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping


class Stopwatch:
    """Books the time between laps on named stages."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._since = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Book the time since the last lap, or since the start, on a stage."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._since
        self._since = now


def summed(watches: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Seconds per stage over several stopwatches."""
    total: dict[str, float] = {}
    for seconds in watches:
        for stage, value in seconds.items():
            total[stage] = total.get(stage, 0.0) + value
    return total
