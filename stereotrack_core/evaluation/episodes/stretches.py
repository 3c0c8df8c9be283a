"""Stretches of frames in which a value is high: hysteresis, bridged gaps, a least length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import Episode, Found, Measure
from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Failures"


@dataclass(frozen=True)
class EpisodeRules(ParameterGroup):
    """From which error, for how long, and what is taken together."""

    episode_error: float = parameter(45.0, _GROUP, (1.0, 180.0), unit="deg")(
        "Error of a limb's direction at which a failure begins."
    )
    episode_release: float = parameter(0.75, _GROUP, (0.1, 1.0))(
        "Fraction of that error below which it ends."
    )
    episode_chance: float = parameter(0.55, _GROUP, (0.01, 0.99))(
        "Failure probability of a limb at which a failure begins, if there is no reference."
    )
    episode_calm: float = parameter(0.5, _GROUP, (0.1, 1.0))(
        "Fraction of that probability below which it ends."
    )
    episode_least: float = parameter(0.3, _GROUP, (0.0, 60.0), unit="s")(
        "Minimum duration of a failure."
    )
    episode_bridge: float = parameter(0.5, _GROUP, (0.0, 60.0), unit="s")(
        "Gaps within a failure that are shorter than this are bridged."
    )


@dataclass(frozen=True)
class Stretch:
    """Frames from the first to the last one, both included, and where the value is highest."""

    first: int
    last: int
    peak: float
    peak_frame: int

    def overlap(self, other: Stretch) -> int:
        """Number of frames that both have."""
        return max(0, min(self.last, other.last) - max(self.first, other.first) + 1)


def high_stretches(
    frame: IntArray, value: FloatArray, enter: float, leave: float, least: int, bridge: int
) -> list[Stretch]:
    """Stretches in which a value is high.

    One begins where the value exceeds `enter`, reaches back and forth to where it falls below
    `leave`, and is joined to the next one over gaps of at most `bridge` frames. NaN is not high.

    Parameters
    ----------
    frame : (F,) int64, ascending
    value : (F,) float64
    enter, leave : float
        `leave` is at most `enter`.
    least : int
        Frames that a stretch has at least.
    bridge : int
        Frames of a gap that is bridged at most; frames that are absent count as a gap.
    """
    with np.errstate(invalid="ignore"):
        seed, high = value > enter, value > leave
    found: list[list[int]] = []
    for run in _runs(high, frame):
        if seed[run[0] : run[1] + 1].any():
            gap = int(frame[run[0]] - frame[found[-1][1]] - 1) if found else bridge + 1
            if gap <= bridge:
                found[-1][1] = run[1]
            else:
                found.append(run)
    return [
        _stretch(frame, value, first, last)
        for first, last in found
        if frame[last] - frame[first] + 1 >= least
    ]


def _runs(high: BoolArray, frame: IntArray) -> list[list[int]]:
    """First and last index of each run of successive frames that are high."""
    places = np.flatnonzero(high)
    if not len(places):
        return []
    breaks = np.flatnonzero(np.diff(frame[places]) > 1) + 1
    return [[int(part[0]), int(part[-1])] for part in np.split(places, breaks)]


def _stretch(frame: IntArray, value: FloatArray, first: int, last: int) -> Stretch:
    peak = first + int(np.nanargmax(value[first : last + 1]))
    return Stretch(int(frame[first]), int(frame[last]), float(value[peak]), int(frame[peak]))


_TOGETHER = 0.5
"""Frames that stretches of different arms share, over those of either, from which they are one
episode."""


def joined(
    stretches: Mapping[str, Sequence[Stretch]], found: Found, measure: Measure
) -> tuple[Episode, ...]:
    """Episodes of stretches by limb, in the order of their first frames.

    Stretches of the two halves of an arm are one episode where they share a frame; those of
    other limbs where they are nearly the same: where the frames that both have are at least half
    of those that either has.
    """
    every = [(limb, stretch) for limb in LIMBS for stretch in stretches.get(limb, ())]
    pairs = [
        (i, j) for (i, one), (j, other) in combinations(enumerate(every), 2) if _belong(one, other)
    ]
    links = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(pairs)), (links[0], links[1])), shape=(len(every),) * 2)
    count, label = connected_components(graph, directed=False) if every else (0, [])
    episodes = [
        _episode([each for each, own in zip(every, label, strict=True) if own == k], found, measure)
        for k in range(count)
    ]
    return tuple(sorted(episodes, key=lambda e: (e.first, e.last, e.limbs)))


def _belong(one: tuple[str, Stretch], other: tuple[str, Stretch]) -> bool:
    shared = one[1].overlap(other[1])
    if not shared or one[0] == other[0]:
        return False
    if _arm(one[0]) is not None and _arm(one[0]) == _arm(other[0]):
        return True
    either = sum(stretch.last - stretch.first + 1 for _, stretch in (one, other)) - shared
    return shared >= _TOGETHER * either


def _arm(limb: str) -> str | None:
    side, _, part = limb.partition("_")
    return side if part in {"upper_arm", "forearm"} else None


def _episode(members: Sequence[tuple[str, Stretch]], found: Found, measure: Measure) -> Episode:
    limb, worst = max(members, key=lambda member: member[1].peak)
    return Episode(
        first=min(stretch.first for _, stretch in members),
        last=max(stretch.last for _, stretch in members),
        limbs=tuple(name for name in LIMBS if any(name == own for own, _ in members)),
        found=found,
        measure=measure,
        peak=worst.peak,
        peak_frame=worst.peak_frame,
        peak_limb=limb,
    )


def frames_of(seconds: float, fps: float) -> int:
    """Number of frames in some seconds, to the nearest one."""
    return round(seconds * fps)


def episodes_by_error(
    errors: LimbErrors, fps: float, rules: EpisodeRules | None = None
) -> tuple[Episode, ...]:
    """Stretches in which the error of a limb's direction exceeds the threshold long enough.

    Frames that are not tracked count with the 90 degrees that they have in `errors`; the head
    has no errors.
    """
    rules = rules or EpisodeRules()
    least = max(1, frames_of(rules.episode_least, fps))
    bridge = frames_of(rules.episode_bridge, fps)
    enter = rules.episode_error
    stretches = {
        limb: high_stretches(
            errors.frame,
            np.degrees(errors.of_limb(limb)),
            enter,
            rules.episode_release * enter,
            least,
            bridge,
        )
        for limb in LIMBS
    }
    return joined(stretches, "truth", "error")
