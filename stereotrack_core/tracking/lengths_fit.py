"""Lengths of the body, estimated from frames of the sequence itself (docs/method.md 4.12).

Straight arms show how long they are altogether, but not where the elbows are; so frames with bent
elbows are sought, all over the sequence.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.proportions import AVERAGE, AVERAGE_HEIGHT, Proportions
from stereotrack_core.body.skeleton import ARM_PARTS, FOREARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.recording.description import Subject
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.shape_fit import LENGTH_SIGMAS, FreeBody, SeenPose, adjusted
from stereotrack_core.tracking.state import Setup

ESTIMATED = "estimated from the sequence"  # name of a subject with estimated lengths
LENGTH_FRAMES = 600  # frames, the first ones, from which lengths are estimated
ESTIMATING_LENGTHS = "estimating the limb lengths"  # the stage in which they are tracked, in words
_MOST = 400  # frames of which the data are kept; when there are more, every second one is forgotten
_BENT, _STRAIGHT = 16, 4  # frames with the elbows most bent, and others, that lengths are fitted to
_LEAST = 6  # fewer good frames than this tell nothing
_BENT_ELBOW = np.radians(50.0)
_SURE = 0.2  # largest probability that an arm is lost in frames that are used
_SEEN_OF_HEIGHT = 0.98  # part of somebody's height at which their highest points are seen
_AROUND = 0.3  # metres around the middle of somebody who stands in which the head is
_LEAST_NEAR = 0.25  # share of one person's points around the middle, arms out as well
_HEIGHTS = (1.2, 2.3)  # metres of people; beyond, the world's z = 0 is not the floor
_SOLE, _CROWN = 1.0, 99.5  # percentiles of a person's heights that are lowest and highest
_STANDING = 1.4  # metres: who seems smaller may sit or stoop
# Metres between which the lowest points lie of somebody who stands on z = 0. Floors are told from
# feet by 15 to 25 cm where views are far away.
_FEET = (-0.1, 0.3)
_EXPLAINED = 0.7  # part of the frames, the best explained ones, that is looked at


def subject_with(lengths: Proportions, own: Subject | None, name: str = ESTIMATED) -> Subject:
    """Who has these lengths; where the bones lie is taken from the recording's own subject."""
    found = Subject(name=name, **dataclasses.asdict(lengths))
    return found if own is None else dataclasses.replace(found, offsets=own.offsets)


@dataclass(frozen=True, eq=False)
class _Candidate:
    seen: SeenPose
    unexplained_fraction: float
    lost: float

    @property
    def bent(self) -> float:
        """Angle of the elbow that is bent more, radians."""
        cosine = self.seen.pose.rotations[list(FOREARMS), 2, 2].min()  # upper arms' z by forearms'
        return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def lengths_by_height(clouds: Sequence[Cloud], upright: Upright = Z_UP) -> Proportions:
    """Average proportions for the height in first clouds, if the floor is at z = 0."""
    seen = [_at(upright.points(cloud.points), _CROWN) for cloud in clouds if len(cloud.points)]
    height = float(np.median(seen)) / _SEEN_OF_HEIGHT if seen else float("nan")
    if not _HEIGHTS[0] <= height <= _HEIGHTS[1]:
        return AVERAGE
    ratio = height / AVERAGE_HEIGHT
    return Proportions(**{name: ratio * v for name, v in dataclasses.asdict(AVERAGE).items()})


def lengths_of_standing(clouds: Sequence[Cloud], upright: Upright = Z_UP) -> Proportions | None:
    """:func:`lengths_by_height` of somebody who is seen to stand upright on the floor, or None."""
    seen = [upright.points(cloud.points) for cloud in clouds if len(cloud.points)]
    if not seen:
        return None
    feet, crown = (float(np.median([_at(points, q) for points in seen])) for q in (_SOLE, _CROWN))
    stands = _FEET[0] <= feet <= _FEET[1] and _STANDING <= crown <= _HEIGHTS[1]
    return lengths_by_height(clouds, upright) if stands else None


def _at(points: FloatArray, percent: float) -> float:
    """Percentile of the heights of points around the middle of somebody, metres."""
    near = _near(points, np.median(points[:, :2], axis=0))
    if near.mean() < _LEAST_NEAR:  # the middle of several people may be where nobody is
        _, cell, count = np.unique(
            np.floor(points[:, :2] / _AROUND), axis=0, return_inverse=True, return_counts=True
        )
        fullest = np.ravel(cell) == count.argmax()
        near = _near(points, np.median(points[fullest, :2], axis=0))
    return float(np.percentile(points[near, 2], percent))


def _near(points: FloatArray, middle: FloatArray) -> BoolArray:
    return np.asarray(np.linalg.norm(points[:, :2] - middle, axis=1) < _AROUND)


class WellSeenFrames:
    """Collects frames while a sequence is tracked, and picks those that tell lengths."""

    def __init__(self) -> None:
        self._kept: list[_Candidate] = []
        self._every = 1
        self._given = 0

    def add(self, tracked: TrackedFrame) -> None:
        """Take a frame in that has been tracked by pairs of data and model."""
        estimate = tracked.estimate
        pairs = estimate.correspondences
        if tracked.pose is None or pairs is None:
            return
        if self._given % self._every == 0:
            seen = SeenPose(pairs.data, tracked.pose)
            lost = float(np.max(estimate.limb_lost[ARM_PARTS]))
            self._kept.append(_Candidate(seen, estimate.unexplained_fraction, lost))
        self._given += 1
        if len(self._kept) > _MOST:
            self._kept = self._kept[::2]
            self._every *= 2

    def picked(self) -> tuple[SeenPose, ...]:
        """The frames to fit to; none where too few are good."""
        if not self._kept:
            return ()
        limit = np.quantile([frame.unexplained_fraction for frame in self._kept], _EXPLAINED)
        good = [f for f in self._kept if f.lost < _SURE and f.unexplained_fraction <= limit]
        if len(good) < _LEAST:
            return ()
        by_bend = sorted(good, key=lambda frame: -frame.bent)
        bent = [frame for frame in good if frame.bent > _BENT_ELBOW]
        chosen = _spread(bent if len(bent) >= _BENT // 2 else by_bend[:_BENT], _BENT)
        chosen += _spread([frame for frame in good if frame not in chosen], _STRAIGHT)
        return tuple(frame.seen for frame in chosen)

    def lengths(self, expected: Proportions, setup: Setup) -> Proportions:
        """Lengths that the picked frames tell; what was expected where they are too few."""
        picked = self.picked()
        if not picked:
            return expected
        picked = tuple(dataclasses.replace(one, upright=setup.upright) for one in picked)
        free = FreeBody(expected, setup.body.shape, lengths=tuple(LENGTH_SIGMAS))
        theta, _ = adjusted(free, picked, setup.parameters, setup.joints)
        return free.parts(theta)[0]


def _spread(frames: Sequence[_Candidate], count: int) -> list[_Candidate]:
    """At most so many, evenly over the sequence."""
    if len(frames) <= count:
        return list(frames)
    return [frames[i] for i in np.linspace(0, len(frames) - 1, count).round().astype(int)]
