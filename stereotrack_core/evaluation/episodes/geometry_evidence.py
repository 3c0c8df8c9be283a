"""Causes that can be seen from the landmarks alone: crossing, torso, too fast, first frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.episodes.closeness import to_other_arm, to_torso, turns
from stereotrack_core.evaluation.episodes.episode import Episode, Evidence
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import Run

CROSSED = 0.16
"""Metres between the axes of two arms' limbs from which they cross."""

BESIDE_TORSO = 0.18
"""Metres between the axes of a limb and of the torso from which it is close to the torso."""

_BEFORE = 0.3
"""Seconds before an episode that belong to how it came about."""

_SLOW, _FAST = 16.0, 40.0
"""Degrees of a limb's turn from frame to frame that say nothing, and everything."""

_FIRST = 0.3
"""Seconds from the first tracked frame within which an episode is one of the first frames."""


@dataclass(frozen=True, eq=False)
class Whereabouts:
    """Where the limbs were in the frames of a run, as far as it can be known.

    Attributes
    ----------
    frame : (F,) int64
    points : (F, 9, 3) float64
        The reference's landmarks where it knows them all, else the run's.
    true : (F,) bool
        Whether they are the reference's.
    fps : float
    begun : int
        First frame that is tracked.
    """

    frame: IntArray
    points: FloatArray
    true: BoolArray
    fps: float
    begun: int

    def at(self, frames: IntArray) -> FloatArray:
        """Landmarks (n, 9, 3) of some frames; NaN where the run has none of them."""
        place = np.clip(np.searchsorted(self.frame, frames), 0, max(len(self.frame) - 1, 0))
        result: FloatArray = self.points[place].copy()
        result[self.frame[place] != frames] = np.nan
        return result


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


def geometry_evidence(episode: Episode, where: Whereabouts) -> list[Evidence]:
    """Evidence from where the limbs are, in an episode and just before it."""
    lead = round(_BEFORE * where.fps)
    inside = (where.frame >= episode.first) & (where.frame <= episode.last)
    limbs = [i for i, limb in enumerate(LIMBS) if limb in episode.limbs]
    arms = [i for i in limbs if LIMBS[i] not in {"torso", "head"}]
    found = _first_frames(episode, where)
    if arms:
        crossing = _crossing(where, inside, arms)
        found += crossing
        found += _beside_torso(where, inside, arms, crossing[0].strength if crossing else 0.0)
        early = (where.frame >= episode.first - lead) & (where.frame <= episode.first + 1)
        found += _too_fast(where, early, arms)
    return found


def _crossing(where: Whereabouts, inside: BoolArray, arms: list[int]) -> list[Evidence]:
    away = to_other_arm(where.points[inside])[:, arms].min(axis=1, initial=np.inf)
    share = float(np.mean(away < CROSSED)) if len(away) else 0.0
    if share <= 0.0:
        return []
    least, frame = _least(away, where.frame[inside])
    words = (
        f"the arms are {100.0 * least:.0f} cm apart in frame {frame}, and close to each other in "
        f"{100.0 * share:.0f} % of the frames"
    )
    return [Evidence("crossing", min(1.0, 1.6 * share), least, "m", words)]


def _beside_torso(
    where: Whereabouts, inside: BoolArray, arms: list[int], crossing: float
) -> list[Evidence]:
    away = to_torso(where.points[inside])[:, arms].min(axis=1, initial=np.inf)
    share = float(np.mean(away < BESIDE_TORSO)) if len(away) else 0.0
    if share <= 0.0:
        return []
    least, frame = _least(away, where.frame[inside])
    words = (
        f"{100.0 * least:.0f} cm from the centre of the torso in frame {frame}, close to it in "
        f"{100.0 * share:.0f} % of the frames"
    )
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
    words = (
        f"the limb rotates by {most:.0f}° between frames at frame {where.frame[place]}, "
        f"{most * where.fps:.0f}° per second"
    )
    return [Evidence("fast", strength, most * where.fps, "deg/s", words)]


def _first_frames(episode: Episode, where: Whereabouts) -> list[Evidence]:
    after = (episode.first - where.begun) / where.fps
    if after > _FIRST:
        return []
    later = max(0, episode.first - where.begun)
    words = "it starts with the first tracked frame"
    if later:
        words = f"it starts {later} frame{'' if later == 1 else 's'} after the first tracked frame"
    return [Evidence("initialisation", 0.9, after, "s", words)]


def _least(away: FloatArray, frame: IntArray) -> tuple[float, int]:
    place = int(np.nanargmin(np.where(np.isfinite(away), away, np.inf)))
    return float(away[place]), int(frame[place])
