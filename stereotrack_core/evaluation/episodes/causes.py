"""The probable cause of an episode from all that speaks for any."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

from stereotrack_core.evaluation.episodes.episode import UNCLEAR, Cause, Evidence, Verdict

_WEIGHT: MappingProxyType[Cause, float] = MappingProxyType(
    {
        "calibration": 1.6,
        "hole": 1.5,
        "neighbour": 1.4,
        "initialisation": 1.3,
        "hidden": 1.2,
        "crossing": 1.1,
        "fast": 1.0,
        "torso": 0.7,
    }
)
"""How much a cause counts against others of the same strength: what makes a measurement wrong comes
before what makes it difficult, as an arm that cannot be measured may cross the other besides."""

_DOUBT = 0.25
"""Weight of not knowing; what nothing speaks for more strongly is unclear."""


def verdict_of(evidence: Sequence[Evidence]) -> Verdict:
    """The cause that most speaks for, with its share of all that speaks for any."""
    strongest: dict[Cause, float] = {}
    for each in evidence:
        weight = _WEIGHT[each.cause] * each.strength
        strongest[each.cause] = max(weight, strongest.get(each.cause, 0.0))
    ordered = tuple(sorted(evidence, key=lambda e: -_WEIGHT[e.cause] * e.strength))
    if not strongest:
        return UNCLEAR
    cause = max(strongest, key=lambda name: strongest[name])
    if strongest[cause] <= _DOUBT:
        return Verdict("unclear", 0.0, ordered)
    total = sum(strongest.values()) + _DOUBT
    return Verdict(cause, strongest[cause] / total, ordered)
