"""Search for arms of a body that has just been found: nothing is expected of them."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.arm_search.arms import Arms, ArmShape, joined
from stereotrack_core.tracking.arm_search.kernels import unexplained_sums
from stereotrack_core.tracking.arm_search.proposals import arms_around
from stereotrack_core.tracking.arm_search.score import anatomy_cost, change_cost
from stereotrack_core.tracking.arm_search.search import ArmSearch, Evidence
from stereotrack_core.tracking.parameters import TrackingParameters

_SQUARED_SCALE = 0.035**2
"""As in the search from frame to frame."""

_KEPT, _PAIRS = 10, 20
"""Places of each arm that differ, and pairs of them."""

_APART = np.radians(30.0)
"""Angle from which two places of an arm differ."""

_NATURAL = 2.0
"""Factor on what speaks against an arm's anatomy, in addition: there is no history that could
outweigh it."""

_ANYWHERE = np.radians(90.0)


class FreeArmSearch(ArmSearch):
    """A search whose best places differ, and for which change costs nothing."""

    def __init__(self, body: BodyModel, parameters: TrackingParameters) -> None:
        super().__init__(body, parameters.replaced(search_refined=_PAIRS))

    def _own_cost(
        self, evidence: Evidence, shape: ArmShape, arms: Arms, expected: Arms
    ) -> FloatArray:
        own = super()._own_cost(evidence, shape, arms, expected) - change_cost(expected, arms)
        return own + _NATURAL * anatomy_cost(evidence.scene, shape, arms)

    def _best_of(
        self, evidence: Evidence, shape: ArmShape, arms: Arms, expected: Arms, other: FloatArray
    ) -> tuple[Arms, FloatArray, FloatArray]:
        """Best of the arms that differ, with their distances and own costs."""
        rng = np.random.default_rng((shape.side, len(arms)))
        arms = joined(arms, arms_around(arms[:1], len(arms), _ANYWHERE, _ANYWHERE, rng))
        distances = self._distances(evidence, shape, arms)
        own = self._own_cost(evidence, shape, arms, expected)
        chosen: dict[int, None] = {0: None}
        for others in (evidence.body_distance, np.minimum(evidence.body_distance, other)):
            explained = np.empty(len(arms))
            unexplained_sums(others, distances, _SQUARED_SCALE, explained)
            cost = own + evidence.weight * explained
            chosen |= dict.fromkeys(_apart(arms, np.argsort(cost, kind="stable")))
        index = list(chosen)
        return arms[index], distances[index], own[index]


def _apart(arms: Arms, order: IntArray) -> list[int]:
    """The first of the arms, in this order, that differ from each other."""
    chosen: list[int] = []
    free = np.ones(len(arms), dtype=np.bool_)
    for k in order:
        if not free[k]:
            continue
        chosen.append(int(k))
        upper = angle_between(arms.upper, arms.upper[k])
        fore = angle_between(arms.fore, arms.fore[k])
        free &= np.maximum(upper, fore) > _APART
        if len(chosen) == _KEPT:
            break
    return chosen
