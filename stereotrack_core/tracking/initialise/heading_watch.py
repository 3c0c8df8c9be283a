"""Decides over the first frames of a run whether the person faces the way that it has begun with.

The evidence of single frames (:mod:`heading`) is added up until the posterior probability of one of
the two headings passes a level. Until then the heading is undecided, and both stay possible.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.frame import FirstFrame
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.heading import MOST, MOST_WALKED, WALKING, ahead, evidence
from stereotrack_core.tracking.initialise.trunk import turned_round

DECIDED = 0.99  # posterior probability from which a heading is decided
WATCHED = 100  # tracked frames in which it has to be decided
_UNLIKELY = 0.4  # posterior probability below which a heading gives way after the last frame
_LEAST = 3  # tracked frames before anything is decided
ENOUGH = 20  # tracked frames from which it says something that a heading is not decided
_APART = 0.5  # seconds from which looks at limbs are independent, and a body may have turned
_WALKS = 0.3  # metres per second from which somebody walks
_NAMES = tuple(MOST)
_MOST = np.array([MOST[name] for name in _NAMES])
_EVERY_FRAME = MOST.keys() - {"legs", "arms"}  # of which each frame is a look


@dataclass(frozen=True, eq=False)
class Place:
    """Where somebody was in a frame, and faced."""

    frame: int
    position: FloatArray  # (3,), world, metres
    forward: FloatArray  # (3,), world. Unit vector.


@dataclass(frozen=True, eq=False)
class HeadingWatch:
    """Evidence for the heading that a run has begun with, over its frames so far."""

    fps: float
    active: bool = True  # whether it still takes frames: neither decided, nor over
    against: int | None = None  # the frame at which the other heading was decided to be right
    corrected: bool = False  # whether the frames before that have been tracked again with it
    first: FirstFrame | None = None  # where the track has begun
    # (K,). Log-likelihood ratios of each piece of evidence, added up over its looks.
    sums: FloatArray = field(default_factory=lambda: np.zeros(len(_NAMES)))
    # (K,). Independent looks at each piece.
    looks: FloatArray = field(default_factory=lambda: np.zeros(len(_NAMES)))
    walked: float = 0.0  # metres forward less metres backward
    seen: int = 0  # tracked frames
    turned: float = 1.0  # -1 while the tracker faces the other way than it has begun with
    last: Place | None = None  # place in the last tracked frame

    @property
    def ratio(self) -> float:
        """Log-likelihood ratio of the heading that the run has begun with."""
        looks = np.maximum(self.looks, 1e-9)
        pieces = self.sums / looks * np.minimum(self.looks, _MOST)
        walked = np.clip(WALKING * self.walked, -MOST_WALKED, MOST_WALKED)
        return float(pieces.sum() + walked)

    @property
    def probability(self) -> float:
        """Of the heading that the run states."""
        return float(1.0 / (1.0 + np.exp(-self.ratio)))

    @property
    def state(self) -> str:
        """``decided``, ``corrected`` or ``undecided``."""
        if self.seen < _LEAST or self.probability < DECIDED:
            return "undecided"
        return "corrected" if self.corrected else "decided"

    @property
    def faced_away(self) -> bool:
        """Whether the other heading is right, and frames before have not been tracked again."""
        return self.against is not None and not self.corrected

    def to_dict(self) -> dict[str, Any]:
        """What a run states of its heading."""
        chance = round(self.probability, 4)
        found: dict[str, Any] = {"state": self.state, "probability": chance, "frames": self.seen}
        return found if self.against is None else {**found, "against": self.against}

    def updated(
        self, finder: PoseFinder, pose: Pose | None, cloud: Cloud, *, is_last: bool = False
    ) -> HeadingWatch:
        """The watch after a frame and the pose that it was tracked with; the last one settles it.

        A body that is lost may come back in another heading; frames after that say nothing of
        those before.
        """
        if not self.active:
            return self
        watch = self._with_pose(finder, pose, cloud)
        watch = replace(watch, active=watch.active and not is_last and watch.seen < WATCHED)
        undecided = watch.against is None and watch.seen >= ENOUGH
        if not watch.active and undecided and watch.probability < _UNLIKELY:
            return replace(watch, against=cloud.frame)
        return watch

    def _with_pose(self, finder: PoseFinder, pose: Pose | None, cloud: Cloud) -> HeadingWatch:
        if pose is None or self.first is None:
            return self
        forward = ahead(finder.setup.body.frames(pose), finder.setup.upright)
        watch, seconds = self._followed(Place(cloud.frame, pose.position, forward))
        if not watch.active:
            return watch
        sums, looks = self.sums.copy(), self.looks.copy()
        for name, found in evidence(finder, pose, cloud).items():
            k = _NAMES.index(name)
            look = 1.0 if name in _EVERY_FRAME or not self.seen else min(1.0, seconds / _APART)
            sums[k] += look * watch.turned * found
            looks[k] += look
        watch = replace(watch, sums=sums, looks=looks, seen=self.seen + 1)
        if watch.seen >= _LEAST and max(watch.probability, 1.0 - watch.probability) >= DECIDED:
            against = cloud.frame if watch.probability < 0.5 else None
            return replace(watch, active=False, against=against)
        return watch

    def _followed(self, now: Place) -> tuple[HeadingWatch, float]:
        """The watch with the way since the frame before as walked, and the seconds since then."""
        before, watch = self.last, replace(self, last=now)
        if before is None:
            return watch, _APART
        seconds = (now.frame - before.frame) / self.fps
        turned, same = self.turned, float(before.forward @ now.forward)
        if same < -0.5:
            turned = -turned  # nobody turns so fast: the tracker has changed its mind
        way, walked = now.position - before.position, self.walked
        if np.linalg.norm(way) > _WALKS * seconds and same > 0.5:
            walked += turned * 0.5 * float(way @ (now.forward + before.forward))
        active = self.active and seconds <= 1.0 / self.fps + _APART
        return replace(watch, active=active, turned=turned, walked=walked), seconds

    def turned_round(self) -> HeadingWatch:
        """The watch with the other heading, with which the track begins again."""
        assert self.first is not None  # noqa: S101 - nothing is decided before a track begins
        first = replace(self.first, pose=turned_round(self.first.pose))
        return replace(self, corrected=True, sums=-self.sums, walked=-self.walked, first=first)
