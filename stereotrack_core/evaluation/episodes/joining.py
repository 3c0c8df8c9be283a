"""Stretches of single limbs become episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import Episode, Found, Measure
from stereotrack_core.evaluation.episodes.stretches import Stretch

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
