"""The probable cause of an episode from all that speaks for any."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import UNCLEAR, Cause, Episode, Evidence, Verdict
from stereotrack_core.tracking.frame import Run

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


_STRANGE = 0.25
"""Unexplained fraction over the usual from which there are points of something else."""


def told_evidence(episode: Episode, run: Run) -> list[Evidence]:
    """Evidence from what a run states about views that gave nothing, and about its clouds."""
    return [*_blind_views(episode, run), *_unexplained(episode, run)]


def _blind_views(episode: Episode, run: Run) -> list[Evidence]:
    """Stretches in which a view gave nothing; ``track`` states them in the meta as ``blind``."""
    found = []
    stated = run.meta.get("blind")
    for row in stated if isinstance(stated, list) else []:
        if not isinstance(row, dict) or not {"view", "first", "end"} <= set(row):
            continue
        shared = min(int(row["end"]), episode.last + 1) - max(int(row["first"]), episode.first)
        share = shared / len(episode.frames)
        if share > 0.0:
            words = f"view {row['view']} provides no points in {100.0 * share:.0f} % of the frames"
            found.append(Evidence("hole", min(1.0, 1.2 * share), share, "share", words))
    return found


def _unexplained(episode: Episode, run: Run) -> list[Evidence]:
    inside = (run.frame >= episode.first) & (run.frame <= episode.last)
    usual = run.unexplained_fraction[~inside & np.isfinite(run.unexplained_fraction)]
    own = run.unexplained_fraction[inside & np.isfinite(run.unexplained_fraction)]
    if not len(own) or not len(usual) or not set(episode.limbs) & set(LIMBS[2:]):
        return []
    more = float(np.median(own) - np.median(usual))
    if more < _STRANGE:
        return []
    words = (
        f"the body leaves {100.0 * float(np.median(own)):.0f} % of the cloud unexplained, "
        f"{100.0 * more:.0f} % more than usual"
    )
    return [Evidence("neighbour", min(1.0, 2.0 * more), more, "share", words)]
