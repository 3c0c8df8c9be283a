"""Timing of functions that are to be compared."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np


def seconds_of(function: Callable[[], object]) -> float:
    """Wall time of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def median_seconds(
    functions: Mapping[str, Callable[[], object]],
    *,
    budget: float = 1.0,
    most_calls: int = 200,
) -> dict[str, float]:
    """Median wall time of each function, called in turn so that all see the same machine.

    Parameters
    ----------
    functions : mapping from name to function
        Each is called once before, without being timed, unless that call alone takes longer
        than the budget: then it is the measurement.
    budget : float
        Seconds for each function; one that is slow is called at least once.
    most_calls : int
        Calls of each function at most.
    """
    first = {name: seconds_of(function) for name, function in functions.items()}
    spent = dict.fromkeys(functions, 0.0)
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(most_calls):
        waiting = [name for name in functions if spent[name] + first[name] <= budget]
        if not waiting:
            break
        for name in waiting:
            needed = seconds_of(functions[name])
            spent[name] += needed
            times[name].append(needed)
    return {name: median(times[name] or [first[name]]) for name in functions}


def median(values: Sequence[float]) -> float:
    """Median as a plain number."""
    return float(np.median(values))
