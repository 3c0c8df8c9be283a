"""Which way a person faces: what frames say for a heading, and when that decides.

A body looks much the same from the front and from behind, with left and right exchanged. Each piece
of evidence is a log-likelihood ratio: positive for the way that a pose faces, negative for the
opposite way (:func:`turned_round`), 0 where nothing is seen that tells them apart. How much each
weighs is chosen, not learned, from recordings whose heading is known (docs/accuracy-elsewhere.md).
The evidence of single frames is added up until the posterior probability of one of the two headings
passes a level. Until then the heading is undecided, and both stay possible.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import SHANKS, TORSO
from stereotrack_core.depth.cloud import Cloud, ViewDepth
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import FirstFrame
from stereotrack_core.tracking.initialise.finder import PoseFinder
from stereotrack_core.tracking.initialise.seeds import upright_pose
from stereotrack_core.tracking.initialise.trunk import (
    away_cost,
    feet_ahead,
    lean_cost,
    legs_cost,
    turned_round,
)
from stereotrack_core.tracking.residuals.clicks import missed
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation

# Pieces of evidence, and independent looks that each is worth at most: frames of somebody who
# stands still say the same again and again.
MOST: Mapping[str, float] = MappingProxyType(
    {"toes": 3.0, "feet": 3.0, "legs": 3.0, "arms": 4.0}
    | {"cameras": 1.0, "keypoints": 3.0, "clicks": 2.0}
)
# Log-likelihood ratios of one look at evidence that could not be clearer, also of arms that cannot
# bend the other way round, and of hands in front of the elbows.
_TOES, _FEET, _LEGS, _CAMERAS, _KEYPOINTS, _CLICKS = 2.0, 0.7, 0.7, 1.5, 3.0, 4.0
_FORWARD, _HANDS = 1.5, 1.0
WALKING = 5.0  # log-likelihood ratio of a metre walked to the front
MOST_WALKED = 6.0  # and of any way: people seldom walk backwards for long
# Least sine of the angle between a view's line of sight and a foot, seen from above, from which the
# view shows whether toes point to one side.
_BESIDE = 0.64
_LEG = np.arange(0.12, 0.21, 0.02)  # heights over the ankle, metres, where a leg is looked for
_ASIDE = np.arange(-0.12, 0.121, 0.01)  # distances from it to the front, metres
_SOLE = np.arange(0.10, -0.26, -0.01)  # heights over the ankle, metres, at which a foot may end
# Metres over the sole, and from the ankle on, where there are toes in front and nothing behind.
_OVER_SOLE, _ALONG_FOOT = 0.03, np.array([0.10, 0.12, 0.14])


def ahead(frames: PartFrames, upright: Upright) -> FloatArray:
    """Level unit vector (3,), world, along which the torso faces; 0 where that is up or down."""
    y = frames.rotations[TORSO, :, 1]
    level = y - (y @ upright.up) * upright.up
    return np.asarray(level / max(float(np.linalg.norm(level)), 1e-6))


def _toes_in(
    body: BodyModel, frames: PartFrames, view: ViewDepth, forward: FloatArray, up: FloatArray
) -> Iterator[float]:
    """Where a view that sees feet from the side shows the toes: 1 in front, -1 behind.

    Clouds hardly have feet, as the floor is too near; the outlines of the person have.
    """
    if view.outline is None:
        return
    centre = view.geometry.world_from_depth.translation
    for shank in SHANKS:
        along = frames.rotations[shank, :, 2]
        ankle = frames.origins[shank] + body.skeleton.lengths[shank] * along
        sight = ankle - centre
        sight = sight - (sight @ up) * up
        beside = np.linalg.norm(np.cross(sight, forward)) / max(float(np.linalg.norm(sight)), 1e-6)
        if beside < _BESIDE:
            continue
        legs = ankle + _LEG[:, None, None] * up + _ASIDE[:, None] * forward
        leg = _inside(view, legs.reshape(-1, 3)).reshape(len(_LEG), len(_ASIDE))
        if not leg.any(axis=1).all():
            continue
        ankle = ankle + float((leg * _ASIDE).sum() / leg.sum()) * forward
        below = _inside(view, ankle + _SOLE[:, None] * up) > 0
        if not below[0] or below.all():
            continue
        sole = ankle + (_SOLE[np.argmin(below)] + _OVER_SOLE) * up
        toes, heel = (sole + way * _ALONG_FOOT[:, None] * forward for way in (1.0, -1.0))
        yield float(_inside(view, toes).mean() - _inside(view, heel).mean())


def _inside(view: ViewDepth, points: FloatArray) -> FloatArray:
    """Whether a view's outline covers points (N, 3), world; 0 or 1 (N,)."""
    u, v, z = view.geometry.project(points)
    person = view.person
    rows, columns = np.rint(v), np.rint(u)
    seen = (z > 0) & (rows >= 0) & (columns >= 0)
    seen &= (rows < person.shape[0]) & (columns < person.shape[1])
    result = np.zeros(len(points))
    result[seen] = person[rows[seen].astype(int), columns[seen].astype(int)]
    return result


def evidence(finder: PoseFinder, pose: Pose, cloud: Cloud) -> dict[str, float]:
    """One look at each piece of evidence of :data:`MOST` that a frame has, for a pose in it."""
    setup, back = finder.setup, turned_round(pose)
    body, upright = setup.body, setup.upright
    here, there = (body.frames(upright_pose(each, upright)) for each in (pose, back))
    cameras = upright.points(setup.cameras)
    costs = [legs_cost(frames) + lean_cost(frames) for frames in (there, here)]
    found = {
        "legs": _LEGS * _beyond(costs[0] - costs[1], 5.0, 20.0),
        "arms": arms_forward(finder, pose),
        "cameras": _CAMERAS * (away_cost(there, cameras) - away_cost(here, cameras)) / 20.0,
    }
    frames = body.frames(pose)
    forward, views = ahead(frames, upright), cloud.depths.values()
    if toes := [toe for view in views for toe in _toes_in(body, frames, view, forward, upright.up)]:
        found["toes"] = _TOES * float(np.mean(toes))
    if feet := feet_ahead(body, here, upright.points(cloud.points)):
        found["feet"] = _FEET * float(np.clip(np.mean(feet) / 0.05, -1.0, 1.0))
    seen = KeypointObservation(cloud.keypoints, setup.parameters.keypoint_sigma)
    fits = [seen.fitted(body, each) for each in (back, pose)]
    if fits[0] is not None and fits[1] is not None:
        gain = (fits[0].cost() - fits[1].cost()) / 0.3
        most = _KEYPOINTS * fits[0].independence
        found["keypoints"] = most * float(np.clip(gain, -1.0, 1.0))
    if cloud.clicks:
        off = missed(body, back, cloud.clicks) - missed(body, pose, cloud.clicks)
        found["clicks"] = _CLICKS * float(np.clip(off / 20.0, -1.0, 1.0))
    return found


def arms_forward(finder: PoseFinder, pose: Pose) -> float:
    """What the arms say: they reach to the front, and elbows bend one way only."""
    body = finder.setup.body
    anatomy = finder.arms_cost(turned_round(pose)) - finder.arms_cost(pose)
    frames = body.frames(pose)
    at = dict(zip(LANDMARKS, landmarks(body, pose), strict=True))
    forearms = [at[f"{side}_hand"] - at[f"{side}_elbow"] for side in ("left", "right")]
    before = float(np.mean(forearms, axis=0) @ frames.rotations[TORSO, :, 1])
    return _FORWARD * _beyond(anatomy, 3.0, 9.0) + _HANDS * _beyond(before, 0.05, 0.10)


def _beyond(value: float, dead: float, full: float) -> float:
    """-1 to 1, and 0 for values up to `dead`; 1 from `dead` + `full` on."""
    return float(np.sign(value) * np.clip((abs(value) - dead) / full, 0.0, 1.0))


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
        """Probability that the heading of the run is right."""
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
        """State, probability and evidence of the heading, as a run stores them."""
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
