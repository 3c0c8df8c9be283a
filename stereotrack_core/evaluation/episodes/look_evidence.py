"""Causes seen in clouds and images: hidden, holes, points of something else, calibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.episode import Episode, Evidence
from stereotrack_core.evaluation.episodes.looks import Look

_SEES = 0.4
"""Share of a limb that a view measures from which it sees it."""

_LOSES = 0.5
"""Share of a limb, or of its usual points, that a view loses from which it has a hole."""

_STRAY = 0.03
"""Share of the cloud near a limb that is not the person's, over the usual, from which it tells."""

_MISFIT, _WIDE_MISFIT = 0.015, 0.035
"""Metres between a view and the others that say nothing, and everything."""


def look_evidence(
    episode: Episode, views: Sequence[str], inside: Sequence[Look], usual: Sequence[Look]
) -> list[Evidence]:
    """Evidence from looks at frames of an episode, against frames of the run outside of any.

    Parameters
    ----------
    episode : Episode
    views : sequence of str
        In the order of the looks' rows.
    inside, usual : sequence of Look
    """
    if not inside:
        return []
    limbs = [LIMBS.index(limb) for limb in episode.limbs]
    found = _holes(views, inside, usual, limbs)
    blind = {e.words.split()[1] for e in found}
    # cameras that do not fit do so whether somebody fails or not
    misfit = _misfit(views, [*inside, *usual])
    # where they do not, what they measure before a limb may be the limb
    doubt = max((e.strength for e in misfit), default=0.0)
    for each in _hidden(views, inside, limbs, blind):
        found.append(replace(each, strength=each.strength * (1.0 - doubt)))
    return [*found, *_strangers(inside, usual, limbs), *misfit]


def _mean(looks: Sequence[Look], name: str) -> FloatArray:
    values = np.array([getattr(look, name) for look in looks], dtype=np.float64)
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=0)
    result: FloatArray = total / np.maximum(known.sum(axis=0), 1)
    return result


def _holes(
    views: Sequence[str], inside: Sequence[Look], usual: Sequence[Look], limbs: list[int]
) -> list[Evidence]:
    """Views that measure nothing where the limb is, or have lost most of their points."""
    unknown = _mean(inside, "unknown")[:, limbs].mean(axis=1)
    points = _mean(inside, "points")
    if usual:
        unknown = unknown - _mean(usual, "unknown")[:, limbs].mean(axis=1)
        # a view that fails for long may have failed in some of the other frames as well
        most = np.percentile([look.points for look in usual], 75.0, axis=0)
        lost = 1.0 - points / np.maximum(most, 1.0)
    else:
        lost = 1.0 - points / max(float(np.median(points)), 1.0)
    worst = np.maximum(unknown, np.where(lost > 0.6, lost, 0.0))
    v = int(np.argmax(worst))
    if worst[v] < _LOSES:
        return []
    if lost[v] >= unknown[v]:
        words = f"view {views[v]} has {100.0 * lost[v]:.0f} % fewer points than usual"
    else:
        words = f"view {views[v]} has no measurement on {100.0 * unknown[v]:.0f} % more of the limb"
        words += " than usual"
    return [Evidence("hole", min(1.0, 1.3 * float(worst[v])), float(worst[v]), "share", words)]


def _hidden(
    views: Sequence[str], inside: Sequence[Look], limbs: list[int], blind: set[str]
) -> list[Evidence]:
    """The limb is seen by one view at most, as something stands before it in the others."""
    agreed = np.array([look.agreed for look in inside])[:, :, limbs].min(axis=2)
    before = np.array([look.before for look in inside])[:, :, limbs].max(axis=2)
    seeing = float((agreed > _SEES).sum(axis=1).mean())
    fit = [v for v, name in enumerate(views) if name not in blind]
    behind = float((before[:, fit] > _SEES).mean()) if fit else 0.0
    most = 1.6 if len(views) > 1 else 0.8
    strength = float(np.clip(1.0 - seeing / most, 0.0, 1.0)) * min(1.0, 1.5 * behind)
    if strength <= 0.05:
        return []
    words = f"on average {seeing:.1f} of {len(views)} views see it; in {100.0 * behind:.0f} % of "
    words += "the views it is occluded"
    return [Evidence("hidden", strength, seeing, "views", words)]


def _strangers(inside: Sequence[Look], usual: Sequence[Look], limbs: list[int]) -> list[Evidence]:
    stray = _mean(inside, "stray")[limbs].max()
    before = _mean(usual, "stray")[limbs].max() if usual else 0.0
    more = float(stray - min(before, 0.5 * stray))
    if more < _STRAY:
        return []
    words = f"{100.0 * stray:.0f} % of the cloud is near the limb but belongs to no limb"
    return [Evidence("neighbour", min(1.0, more / (4.0 * _STRAY)), float(stray), "share", words)]


def _misfit(views: Sequence[str], looks: Sequence[Look]) -> list[Evidence]:
    """A view's points that lie beside those of the others, in the mean over all frames."""
    offsets = np.array([look.offset for look in looks])
    if len(views) < 2 or not len(offsets):
        return []
    known = np.isfinite(offsets).all(axis=2).sum(axis=0) >= max(1, len(looks) // 3)
    if known.sum() < 2:
        return []
    mean = np.array(
        [
            np.nanmean(offsets[:, v], axis=0) if known[v] else np.full(3, np.nan)
            for v in range(len(views))
        ]
    )
    others = np.array([np.nanmedian(np.delete(mean, v, axis=0), axis=0) for v in range(len(views))])
    off = np.nan_to_num(np.linalg.norm(mean - others, axis=1))
    v = int(np.argmax(off))
    strength = float(np.clip((off[v] - _MISFIT) / (_WIDE_MISFIT - _MISFIT), 0.0, 1.0))
    if strength <= 0.0:
        return []
    words = f"view {views[v]} is offset by {1000.0 * off[v]:.0f} mm from the other views"
    return [Evidence("calibration", strength, float(off[v]), "m", words)]
