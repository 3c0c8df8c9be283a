"""Smooth ways through key postures."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.postures import Posture, state_of
from stereotrack_core.simulation.skeleton import JointState, between, difference, moved


class KeyedWay:
    """Interpolates joint states in time, at ascending times in seconds; the first is held before.

    Between two keys a cubic Bezier curve on the rotations (Shoemake 1985,
    doi:10.1145/325165.325242); the velocity at a key is the harmonic mean of those before and
    after, none where they differ in sign (Fritsch and Butland 1984, doi:10.1137/0905021), so that
    nothing swings beyond its keys.
    """

    def __init__(self, times: FloatArray, states: Sequence[JointState]) -> None:
        self._times = np.asarray(times, dtype=np.float64)
        self._states = tuple(states)
        steps = [difference(a, b) for a, b in itertools.pairwise(states)]
        speeds = np.array(steps) / np.diff(self._times)[:, None]
        self._velocities = np.zeros((len(states), speeds.shape[1]))
        before, after = speeds[:-1], speeds[1:]
        same = before * after > 0
        total = np.where(same, before + after, 1.0)
        self._velocities[1:-1] = np.where(same, 2 * before * after / total, 0.0)

    def at(self, time: float) -> JointState:
        """The state at a time in seconds."""
        times = self._times
        if time <= times[0]:
            return self._states[0]
        k = min(int(np.searchsorted(times, time, side="left")), len(times) - 1)
        length = times[k] - times[k - 1]
        share = float(min((time - times[k - 1]) / length, 1.0))
        start, end = self._states[k - 1], self._states[k]
        points = [
            start,
            moved(start, self._velocities[k - 1] * length / 3),
            moved(end, -self._velocities[k] * length / 3),
            end,
        ]
        while len(points) > 1:
            points = [between(a, b, share) for a, b in itertools.pairwise(points)]
        return points[0]


Key = tuple[float, Posture]  # the seconds that it takes to reach a posture from the one before


@dataclass(frozen=True, eq=False)
class Motion:
    """A named motion at pace 1; `states` gives those of a person in a number of frames."""

    seconds: float
    states: Callable[[Person, int], list[JointState]]


def keyed(*keys: Key) -> Motion:
    """A motion through keys; the first key's seconds are spent holding it."""
    times = np.cumsum([seconds for seconds, _ in keys])

    def states(person: Person, frames: int) -> list[JointState]:
        way = KeyedWay(times, [state_of(person, posture) for _, posture in keys])
        return [way.at(times[-1] * frame / max(frames - 1, 1)) for frame in range(frames)]

    return Motion(float(times[-1]), states)
