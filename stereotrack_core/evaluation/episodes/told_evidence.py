"""Causes by a run alone, where its clouds cannot be made again: hidden limbs, views that failed."""

from __future__ import annotations

import numpy as np

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import Episode, Evidence
from stereotrack_core.tracking.frame import Run

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
            words = f"view {row['view']} gives nothing in {100.0 * share:.0f} % of the frames"
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
        f"the body does not explain {100.0 * float(np.median(own)):.0f} % of the cloud, "
        f"{100.0 * more:.0f} % more than usual"
    )
    return [Evidence("neighbour", min(1.0, 2.0 * more), more, "share", words)]
