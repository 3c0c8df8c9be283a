"""Decides over the first frames of a run whether the person faces the way that it has begun with.

The evidence of single frames (:mod:`heading`) is added up until the posterior probability of one of
the two headings passes a level. Until then the heading is undecided, and both stay possible.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Memory
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.heading import (
    MOST,
    MOST_WALKED,
    WALKING,
    ahead,
    evidence,
)
from stereotrack_core.tracking.initialise.trunk import turned_round

DECIDED = 0.99
"""Posterior probability from which a heading is decided."""

WATCHED = 100
"""Tracked frames in which it has to be decided."""

_UNLIKELY = 0.4
"""Posterior probability below which a heading gives way to the other where the frames are over."""

_LEAST = 3
"""Tracked frames before anything is decided."""

ENOUGH = 20
"""Tracked frames from which it says something that a heading is not decided."""

_APART = 0.5
"""Seconds from which looks at limbs are independent, and beyond which a body may have turned."""

_WALKS = 0.3
"""Metres per second from which somebody walks."""

_NAMES = tuple(MOST)
_MOST = np.array([MOST[name] for name in _NAMES])
_KEPT = "heading."
"""Begins the names of a watch's numbers in a run's memory."""

_EVERY_FRAME = frozenset({"toes", "feet", "cameras", "keypoints", "clicks"})
"""Of which each frame is a look."""


@dataclass
class HeadingWatch:
    """Adds up what speaks for the heading that a run has begun with.

    Attributes
    ----------
    active : bool
        Whether it still takes frames: neither decided, nor over.
    against : int or None
        The frame at which the other heading was decided to be right.
    corrected : bool
        Whether the frames before that have been tracked again with it.
    """

    fps: float
    active: bool = True
    against: int | None = None
    corrected: bool = False
    first: tuple[int, Pose] | None = None
    """Frame and pose with which the track has begun."""
    _sums: FloatArray = field(default_factory=lambda: np.zeros(len(_NAMES)))
    _looks: FloatArray = field(default_factory=lambda: np.zeros(len(_NAMES)))
    _walked: float = 0.0
    _seen: int = 0
    _turned: float = 1.0
    _last: tuple[int, FloatArray, FloatArray] | None = None

    @property
    def ratio(self) -> float:
        """Log-likelihood ratio of the heading that the run has begun with."""
        looks = np.maximum(self._looks, 1e-9)
        pieces = self._sums / looks * np.minimum(self._looks, _MOST)
        walked = np.clip(WALKING * self._walked, -MOST_WALKED, MOST_WALKED)
        return float(pieces.sum() + walked)

    @property
    def probability(self) -> float:
        """Of the heading that the run states."""
        return float(1.0 / (1.0 + np.exp(-self.ratio)))

    @property
    def state(self) -> str:
        """``decided``, ``corrected`` or ``undecided``."""
        if self._seen < _LEAST or self.probability < DECIDED:
            return "undecided"
        return "corrected" if self.corrected else "decided"

    @property
    def faced_away(self) -> bool:
        """Whether the other heading is right, and frames before have not been tracked again."""
        return self.against is not None and not self.corrected

    def to_dict(self) -> dict[str, Any]:
        """What a run states of its heading."""
        chance = round(self.probability, 4)
        found: dict[str, Any] = {"state": self.state, "probability": chance, "frames": self._seen}
        return {**found, "against": self.against} if self.against is not None else found

    def take(
        self, finder: PoseFinder, pose: Pose | None, cloud: Cloud, *, last: bool = False
    ) -> None:
        """Take in a frame and the pose that it was tracked with; the run's `last` settles it.

        A body that is lost may come back in another heading; frames after that say nothing of
        those before.
        """
        if not self.active:
            return
        self._add(finder, pose, cloud)
        self.active = self.active and not last and self._seen < WATCHED
        undecided = self.against is None and self._seen >= ENOUGH
        if not self.active and undecided and self.probability < _UNLIKELY:
            self.against = cloud.frame

    def _add(self, finder: PoseFinder, pose: Pose | None, cloud: Cloud) -> None:
        if pose is None or self.first is None:
            return
        forward = ahead(finder.setup.body.frames(pose), finder.setup.upright)
        seconds = self._follow(cloud.frame, pose.position, forward)
        if not self.active:
            return
        self._sums, self._looks = self._sums.copy(), self._looks.copy()  # a saved state holds them
        for name, found in evidence(finder, pose, cloud).items():
            k = _NAMES.index(name)
            look = 1.0 if name in _EVERY_FRAME or not self._seen else min(1.0, seconds / _APART)
            self._sums[k] += look * self._turned * found
            self._looks[k] += look
        self._seen += 1
        if self._seen >= _LEAST and max(self.probability, 1.0 - self.probability) >= DECIDED:
            self.active = False
            self.against = cloud.frame if self.probability < 0.5 else None

    def _follow(self, frame: int, position: FloatArray, forward: FloatArray) -> float:
        """Seconds since the frame before; the way between both counts as walked."""
        before, self._last = self._last, (frame, position, forward)
        if before is None:
            return _APART
        seconds = (frame - before[0]) / self.fps
        if seconds > 1.0 / self.fps + _APART:
            self.active = False
        if before[2] @ forward < -0.5:
            self._turned = -self._turned  # nobody turns so fast: the tracker has changed its mind
        way = position - before[1]
        along = 0.5 * float(way @ (forward + before[2]))
        if np.linalg.norm(way) > _WALKS * seconds and before[2] @ forward > 0.5:
            self._walked += self._turned * along
        return seconds

    def correct(self) -> tuple[int, Pose]:
        """Take the other heading; frame and pose with which the track begins then."""
        assert self.first is not None  # noqa: S101 - nothing is decided before a track begins
        self.corrected = True
        self._sums, self._walked = -self._sums, -self._walked
        self.first = self.first[0], turned_round(self.first[1])
        return self.first

    def memory(self) -> Memory:
        """All that the next frame depends on."""
        numbers = [
            *(self.active, self.corrected, self._walked, self._seen, self._turned),
            np.nan if self.against is None else self.against,
        ]
        kept = {"state": np.array(numbers, float), "sums": self._sums, "looks": self._looks}
        if self.first is not None:
            frame, pose = self.first
            kept |= {"first": np.array(frame, float), "position": pose.position}
            kept["rotations"] = pose.rotations
        if self._last is not None:
            kept["last"] = np.concatenate([[self._last[0]], *self._last[1:]])
        return {_KEPT + name: array for name, array in kept.items()}

    def recall(self, memory: Memory) -> None:
        """Go on as the watch would whose memory this is; runs of older versions watched nothing."""
        kept = {n.removeprefix(_KEPT): a for n, a in memory.items() if n.startswith(_KEPT)}
        if not kept:
            self.active = False
            return
        active, corrected, self._walked, seen, self._turned, against = kept["state"].tolist()
        self.active, self.corrected, self._seen = bool(active), bool(corrected), int(seen)
        self.against = None if np.isnan(against) else int(against)
        self._sums, self._looks = kept["sums"], kept["looks"]
        if "first" in kept:
            self.first = int(kept["first"]), Pose(kept["position"], kept["rotations"])
        if "last" in kept:
            frame, *rest = kept["last"].tolist()
            self._last = int(frame), np.array(rest[:3]), np.array(rest[3:])
