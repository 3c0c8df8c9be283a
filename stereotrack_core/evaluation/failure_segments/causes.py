"""The probable cause of a failure from all that speaks for any."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.failure_segments.looks import Look
from stereotrack_core.evaluation.failure_segments.segment import (
    UNCLEAR,
    Cause,
    Evidence,
    FailureSegment,
    Verdict,
    turns,
)
from stereotrack_core.evaluation.limbs import limb_ends
from stereotrack_core.evaluation.summary import points_at
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.recording.landmarks import LandmarkTrajectory
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

_DOUBT = 0.25  # weight of not knowing; what nothing speaks for more strongly is unclear


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


CROSSED = 0.16  # metres between the axes of two arms' limbs from which they cross
BESIDE_TORSO = 0.18  # metres between the axes of limb and torso from which they are close
_BEFORE = 0.3  # seconds before a failure that belong to how it came about
_SLOW, _FAST = 16.0, 40.0  # degrees a frame that say nothing, and everything
_FIRST = 0.3  # seconds from the first tracked frame that count as first frames


@dataclass(frozen=True, eq=False)
class Whereabouts:
    """Where the limbs were in the frames of a run, as far as it can be known."""

    frame: IntArray  # (F,)
    points: FloatArray  # (F, 9, 3); the reference's where it knows all, else the run's
    true: BoolArray  # (F,). Whether they are the reference's.
    fps: float
    begun: int  # first frame that is tracked

    def at(self, frames: IntArray) -> FloatArray:
        """Landmarks (n, 9, 3) of some frames; NaN where the run has none of them."""
        return points_at(LandmarkTrajectory(self.frame, self.points), frames)


def whereabouts(run: Run, fps: float, reference: LandmarkTrajectory | None) -> Whereabouts:
    """Take the reference where it knows all landmarks, else the run."""
    points = run.landmarks.copy()
    true = np.zeros(len(run.frame), dtype=np.bool_)
    if reference is not None:
        _, own, other = np.intersect1d(run.frame, reference.frame, return_indices=True)
        whole = np.isfinite(reference.points[other]).all(axis=(1, 2))
        points[own[whole]] = reference.points[other[whole]]
        true[own[whole]] = True
    begun = int(run.frame[run.tracked][0]) if run.tracked.any() else 0
    return Whereabouts(run.frame, points, true, fps, begun)


def geometry_evidence(failure: FailureSegment, where: Whereabouts) -> list[Evidence]:
    """Evidence from where the limbs are, in a failure and just before it."""
    lead = round(_BEFORE * where.fps)
    inside = (where.frame >= failure.first) & (where.frame <= failure.last)
    limbs = [i for i, limb in enumerate(LIMBS) if limb in failure.limbs]
    arms = [i for i in limbs if LIMBS[i] not in {"torso", "head"}]
    found = _first_frames(failure, where)
    if arms:
        crossing = _crossing(where, inside, arms)
        found += crossing
        found += _beside_torso(where, inside, arms, crossing[0].strength if crossing else 0.0)
        early = (where.frame >= failure.first - lead) & (where.frame <= failure.first + 1)
        found += _too_fast(where, early, arms)
    return found


def _near(away: FloatArray, frame: IntArray, limit: float) -> tuple[float, float, int]:
    """Share of frames nearer than a limit; least distance, metres, and its frame."""
    if not len(away):
        return 0.0, np.inf, 0
    place = int(np.nanargmin(np.where(np.isfinite(away), away, np.inf)))
    return float(np.mean(away < limit)), float(away[place]), int(frame[place])


def _crossing(where: Whereabouts, inside: BoolArray, arms: list[int]) -> list[Evidence]:
    away = _to_other_arm(where.points[inside])[:, arms].min(axis=1, initial=np.inf)
    share, least, frame = _near(away, where.frame[inside], CROSSED)
    if share <= 0.0:
        return []
    near = f"close to each other in {100.0 * share:.0f} % of the frames"
    words = f"the arms are {100.0 * least:.0f} cm apart in frame {frame}, and {near}"
    return [Evidence("crossing", min(1.0, 1.6 * share), least, "m", words)]


def _beside_torso(
    where: Whereabouts, inside: BoolArray, arms: list[int], crossing: float
) -> list[Evidence]:
    away = _to_torso(where.points[inside])[:, arms].min(axis=1, initial=np.inf)
    share, least, frame = _near(away, where.frame[inside], BESIDE_TORSO)
    near = f"close to it in {100.0 * share:.0f} % of the frames"
    words = f"{100.0 * least:.0f} cm from the centre of the torso in frame {frame}, {near}"
    # arms that cross in front of the body are close to it as well
    strength = min(1.0, 1.1 * share) * (1.0 - 0.8 * crossing)
    return [Evidence("torso", strength, least, "m", words)] if strength > 0.05 else []


def _too_fast(where: Whereabouts, early: BoolArray, arms: list[int]) -> list[Evidence]:
    # a jump of the run itself is a sign of the failure, not its cause
    turn = turns(where.frame.astype(np.float64), where.points)[:, arms]
    turn = np.where(where.true[:, None], turn, np.minimum(turn, 0.8 * _FAST))
    at = np.flatnonzero(early)
    if not len(at) or not np.isfinite(turn[at]).any():
        return []
    place = at[int(np.nanargmax(np.nanmax(turn[at], axis=1, initial=0.0)))]
    most = float(np.nanmax(turn[place]))
    strength = float(np.clip((most - _SLOW) / (_FAST - _SLOW), 0.0, 1.0))
    if strength <= 0.0:
        return []
    where_fast = f"between frames at frame {where.frame[place]}"
    words = f"the limb rotates by {most:.0f}° {where_fast}, {most * where.fps:.0f}° per second"
    return [Evidence("fast", strength, most * where.fps, "deg/s", words)]


def _first_frames(failure: FailureSegment, where: Whereabouts) -> list[Evidence]:
    after = (failure.first - where.begun) / where.fps
    if after > _FIRST:
        return []
    later = max(0, failure.first - where.begun)
    words = "it starts with the first tracked frame"
    if later:
        words = f"it starts {later} frame{'' if later == 1 else 's'} after the first tracked frame"
    return [Evidence("initialisation", 0.9, after, "s", words)]


_SEES = 0.4  # share of a limb that a view measures from which it sees it
_LOSES = 0.5  # share of a limb, or of its usual points, that a view loses from which it has a hole
_STRAY = 0.03  # share of the cloud near a limb, over the usual, that is not the person's
_MISFIT, _WIDE_MISFIT = 0.015, 0.035  # metres between views that say nothing, and everything


def look_evidence(
    failure: FailureSegment, views: Sequence[str], inside: Sequence[Look], usual: Sequence[Look]
) -> list[Evidence]:
    """Evidence from looks at frames of a failure, against frames of the run outside of any."""
    if not inside:
        return []
    limbs = [LIMBS.index(limb) for limb in failure.limbs]
    found = _holes(views, inside, usual, limbs)
    blind = {e.words.split()[1] for e in found}
    # cameras that do not fit do so whether somebody fails or not
    misfit = _misfit(views, [*inside, *usual])
    # where they do not, what they measure before a limb may be the limb
    doubt = max((e.strength for e in misfit), default=0.0)
    for each in _hidden(views, inside, limbs, blind):
        found.append(replace(each, strength=each.strength * (1.0 - doubt)))
    stray = _mean_of_looks(inside, "stray")[limbs].max()
    before = _mean_of_looks(usual, "stray")[limbs].max() if usual else 0.0
    more = float(stray - min(before, 0.5 * stray))
    if more >= _STRAY:
        words = f"{100.0 * stray:.0f} % of the cloud is near the limb but belongs to no limb"
        strength = min(1.0, more / (4.0 * _STRAY))
        found.append(Evidence("neighbour", strength, float(stray), "share", words))
    return [*found, *misfit]


def _mean_of_looks(looks: Sequence[Look], name: str) -> FloatArray:
    values = np.array([getattr(look, name) for look in looks], dtype=np.float64)
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=0)
    return np.asarray(total / np.maximum(known.sum(axis=0), 1))


def _holes(
    views: Sequence[str], inside: Sequence[Look], usual: Sequence[Look], limbs: list[int]
) -> list[Evidence]:
    """Views that measure nothing where the limb is, or have lost most of their points."""
    unknown = _mean_of_looks(inside, "unknown")[:, limbs].mean(axis=1)
    points = _mean_of_looks(inside, "points")
    if usual:
        unknown = unknown - _mean_of_looks(usual, "unknown")[:, limbs].mean(axis=1)
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


def _misfit(views: Sequence[str], looks: Sequence[Look]) -> list[Evidence]:
    """A view's points that lie beside those of the others, in the mean over all frames."""
    offsets = np.array([look.offset for look in looks])
    if len(views) < 2 or not len(offsets):
        return []
    known = np.isfinite(offsets).all(axis=2).sum(axis=0) >= max(1, len(looks) // 3)
    if known.sum() < 2:
        return []
    every, nowhere = range(len(views)), np.full(3, np.nan)
    mean = np.array([np.nanmean(offsets[:, v], axis=0) if known[v] else nowhere for v in every])
    others = np.array([np.nanmedian(np.delete(mean, v, axis=0), axis=0) for v in range(len(views))])
    off = np.nan_to_num(np.linalg.norm(mean - others, axis=1))
    v = int(np.argmax(off))
    strength = float(np.clip((off[v] - _MISFIT) / (_WIDE_MISFIT - _MISFIT), 0.0, 1.0))
    if strength <= 0.0:
        return []
    words = f"view {views[v]} is offset by {1000.0 * off[v]:.0f} mm from the other views"
    return [Evidence("calibration", strength, float(off[v]), "m", words)]


_SIDES = ("left", "right")
_BESIDE = 0.35  # share of an upper arm, from the shoulder, that is always near the torso


def _to_other_arm(points: FloatArray) -> FloatArray:
    """Metres (F, 6) of arm limbs to the other arm's forearm, forearms to all of it; else NaN."""
    start, end = np.moveaxis(limb_ends(points), 2, 0)
    result: FloatArray = np.full(start.shape[:2], np.nan)
    for side, other in (_SIDES, _SIDES[::-1]):
        upper, fore = LIMBS.index(f"{side}_upper_arm"), LIMBS.index(f"{side}_forearm")
        theirs = LIMBS.index(f"{other}_upper_arm"), LIMBS.index(f"{other}_forearm")

        def away(mine: int, its: int) -> FloatArray:
            return segment_distance(start[:, mine], end[:, mine], start[:, its], end[:, its])

        result[:, upper] = away(upper, theirs[1])
        result[:, fore] = np.minimum(away(fore, theirs[0]), away(fore, theirs[1]))
    return result


def _to_torso(points: FloatArray) -> FloatArray:
    """Metres (F, 6) of arm limbs to the torso's middle line, but for shoulders; else NaN."""
    start, end = np.moveaxis(limb_ends(points), 2, 0)
    torso = LIMBS.index("torso")
    result: FloatArray = np.full(start.shape[:2], np.nan)
    for limb, name in enumerate(LIMBS):
        if name in {"torso", "head"}:
            continue
        from_here = start[:, limb]
        if name.endswith("upper_arm"):
            from_here = from_here + _BESIDE * (end[:, limb] - from_here)
        result[:, limb] = segment_distance(from_here, end[:, limb], start[:, torso], end[:, torso])
    return result
