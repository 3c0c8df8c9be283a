"""A second look at stretches in which an arm may be lost: tried again, and the best way taken.

Where arms cross or are hidden, two places of an arm often explain a frame about equally well. Which
of them is taken is then a matter of chance, and it stays taken for as long as the arms stay. The
frames of the whole stretch together tell the two apart much better than each of them alone.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.estimate import Estimate, Memory
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.iekf import IteratedEstimator, PoseFilter
from stereotrack_core.tracking.initialise.people import own_part
from stereotrack_core.tracking.shared_clouds import ReadCloud
from stereotrack_core.tracking.state import State
from stereotrack_core.tracking.tracker import SETTLED, PersonTracker, Tracker

LOOKING_AGAIN = "looking again at frames with doubtful arms"
"""The stage, in words."""

SECOND_LOOK = "second_look"
"""The same as a stage of the frames that come again."""

_ARMS = [*UPPER_ARMS, *FOREARMS]

_DOUBTFUL = 0.08
"""Probability that some arm segment is lost from which a frame is looked at again."""

_LEAST = 0.5
"""Sum of these probabilities, the frames expected to be lost, from which a stretch is worth a look:
four undisturbed views of mesh-P4 have up to 0.4, and looking there cost a sixth of the time."""

_BEFORE, _AFTER = 4, 8
"""Frames without doubt before and after a stretch that are tracked again with it."""

LONGEST = 100
"""Frames after which a stretch is looked at although it goes on."""

_AGREE = np.radians(15.0)
"""Angle of every arm segment up to which one way may go over to another."""

_SAME = np.radians(30.0)
"""Angle up to which tries have come to the same place of an arm segment."""

_AGREED = 0.2
"""Factor on the probability that it is lost then (docs/failures.md)."""

_FIRST = 2
"""Tries that are made at first; all others only where these or the way gone come elsewhere."""

_GAIN = 20.0
"""Cost by which another way must be better altogether to be taken."""

_SEEDS_APART = 1000
"""Between the seeds of the tries, so that those of runs with seeds 0, 1, 2, ... differ."""

_TOGETHER = 2
"""Tries that are followed at the same time; each is the same however many are."""

_KEPT = "second_look"
"""Name of what the tracker's memory keeps of it."""


@dataclass
class SecondLook:
    """Collects tracked frames while arms are doubtful, and looks at them again afterwards.

    Attributes
    ----------
    tries : int
        How often a stretch is tracked again.
    changed : list of (int, int)
        First and last frames of the stretches that have been changed.
    """

    tries: int
    changed: list[tuple[int, int]] = field(default_factory=list)
    _held: list[TrackedFrame] = field(default_factory=list)
    _expected: float = 0.0
    _calm: int = 0

    def take(self, tracked: TrackedFrame, tracker: Tracker) -> None:
        """Take in the next frame.

        One that is not tracked, or whose pose is on trial or was clicked, ends a stretch without a
        look.
        """
        if not self.tries or not _is_sure(tracker) or not tracked.tracked or tracked.cloud.clicks:
            self.forget()
        else:
            self._hold(tracked)

    def _hold(self, tracked: TrackedFrame) -> None:
        self._held.append(tracked.without_cloud())
        lost = float(np.nan_to_num(tracked.estimate.limb_lost[_ARMS]).max())
        doubtful = lost > _DOUBTFUL
        self._expected += lost * doubtful
        self._calm = 0 if doubtful else self._calm + 1
        if self._calm >= _AFTER and not self.due:
            self._expected = 0.0
        if not self._expected:
            del self._held[: -_BEFORE - 1]

    @classmethod
    def after(cls, frames: Iterable[TrackedFrame]) -> SecondLook:
        """What is held after the frames of a run that was tracked without clicks."""
        look, started, on_trial = cls(0), False, 0
        for frame in frames:
            if not frame.tracked:
                on_trial = SETTLED - 1 if started else 0
            if not frame.tracked or on_trial or spent_on(frame):
                look.forget()
            if spent_on(frame):
                look._held = [frame.without_cloud()]
            elif frame.tracked and not on_trial:
                look._hold(frame)
                if look.due:  # the run had no second look
                    look.forget()
            on_trial = max(0, on_trial - frame.tracked)
            started = started or frame.tracked
        return look

    def forget(self) -> None:
        """Begin with the next frame."""
        self._held, self._expected, self._calm = [], 0.0, 0

    @property
    def due(self) -> bool:
        """Whether a stretch is over, or long enough, and worth a look."""
        return self.pending and (self._calm >= _AFTER or len(self._held) > LONGEST)

    @property
    def pending(self) -> bool:
        """Whether there is enough for a look, though more frames may belong to it."""
        return self._expected >= _LEAST and len(self._held) > 1

    @property
    def first(self) -> int | None:
        """The first frame that a look may change; None where no frame is held."""
        return self._held[1].frame if len(self._held) > 1 else None

    @property
    def frames(self) -> range:
        """The frames that a look goes over."""
        return range(self._held[1].frame, self._held[-1].frame + 1)

    def look(
        self,
        tracker: Tracker,
        clouds: Callable[[range], AbstractContextManager[Iterable[ReadCloud]]],
        told: Callable[[int, int], None],
    ) -> list[TrackedFrame]:
        """Track the stretch again, and let the tracker go on from the best way through it.

        Parameters
        ----------
        tracker : Tracker
            That has tracked them.
        clouds : callable
            Gives the clouds of :attr:`frames`, as they are read; may be asked twice.
        told : callable
            Told before each frame how many of how many are done; may raise :class:`Cancelled`.

        Returns
        -------
        list of TrackedFrame
            The frames as they shall be, at least with what is said of lost arms.
        """
        assert isinstance(tracker, PersonTracker)  # noqa: S101 - no other's frames are taken
        begun, (origin, *found) = perf_counter(), self._held
        ways, apart = [_Way.from_frame(origin, tracker, 0)], np.full((1, 1, 1, 1), np.inf)
        for tries in (range(1, self.tries + 1)[:_FIRST], range(1, self.tries + 1)[_FIRST:]):
            if tries and not (apart < _SAME).all():
                new = [_Way.from_frame(origin, tracker, k) for k in tries]
                with clouds(self.frames) as made:
                    _follow(ways[0], new, found, made, told)
                ways += new
                apart = _apart(tracker, [way.poses for way in ways])
        costs = np.array([way.costs for way in ways]).T
        chosen = best_way(costs, (apart < _AGREE).all(axis=-1))
        if chosen[-1]:
            tracker.resume(ways[chosen[-1]].filter.state)
        if chosen.any():
            first = int(np.flatnonzero(chosen)[0])
            self.changed.append((found[first].frame, found[-1].frame))
        spent = (perf_counter() - begun) / len(found)
        result = []
        for i, (frame, way) in enumerate(zip(found, chosen, strict=True)):
            agreed = (apart[i, way] < _SAME).all(axis=0)
            estimate = _surer(ways[way].estimates[i], agreed, switched=way != chosen[max(0, i - 1)])
            result.append(_exchanged(frame, estimate, tracker, spent))
        self.forget()
        self._held = result[-1:]
        return result

    def memory(self) -> Memory:
        """What the next look depends on, besides the frames that are done."""
        first = self._held[0].frame if self._held else -1
        changed = [number for stretch in self.changed for number in stretch]
        numbers = [first, self._expected, self._calm, *changed]
        return MappingProxyType({_KEPT: np.array(numbers, np.float64)})

    def recall(self, memory: Memory, done: Sequence[TrackedFrame]) -> None:
        """Go on as the look would whose memory this is; older versions had none."""
        if _KEPT not in memory:
            return
        first, self._expected, *rest = memory[_KEPT].tolist()
        self._calm, *changed = map(int, rest)
        self._held = [one for one in done if first >= 0 and one.frame >= first]
        self.changed = list(zip(changed[::2], changed[1::2], strict=True))


def spent_on(frame: TrackedFrame) -> float:
    """Seconds that a second look spent on a frame; equal for all frames of one look, 0 without."""
    return frame.seconds.get(SECOND_LOOK, 0.0)


def last_settled(frames: Mapping[int, TrackedFrame], frame: int) -> int | None:
    """The last frame of a run, up to `frame`, whose stated pose alone decides how it went on.

    The tracker went on from another pose inside a stretch that was looked at again, and from more
    than one while a pose was on trial after a loss. None if there is no such frame.
    """
    while frame in frames:
        spent = spent_on(frames[frame])
        if spent and frame + 1 in frames and spent_on(frames[frame + 1]) == spent:
            while frame in frames and spent_on(frames[frame]) == spent:
                frame -= 1
            continue
        near = range(frame - SETTLED + 1, frame + 1)
        lost = max((k for k in near if k in frames and not frames[k].tracked), default=None)
        if lost is None:
            return frame
        was_there = any(one.tracked for k, one in frames.items() if k < lost)
        if frame > lost and not was_there:  # the first pose of a run is settled at once
            return frame
        frame = lost
        while frame in frames and not frames[frame].tracked:
            frame -= 1
    return None


def _is_sure(tracker: Tracker) -> bool:
    """Whether poses are no longer on trial; of a baseline they never are sure enough."""
    if not isinstance(tracker, PersonTracker):
        return False
    return tracker.settled and isinstance(tracker.leader.estimator, IteratedEstimator)


@dataclass(eq=False)
class _Way:
    """One way through a stretch."""

    filter: PoseFilter
    cost: Callable[[Pose, Cloud], float]
    """What speaks against a pose in a cloud."""
    estimates: list[Estimate | None] = field(default_factory=list)
    """None from the frame on in which it was lost."""
    costs: list[float] = field(default_factory=list)

    @classmethod
    def from_frame(cls, origin: TrackedFrame, tracker: PersonTracker, number: int) -> _Way:
        """One that begins where the tracker was; each number has a chance of its own."""
        own = replace(tracker.setup, seed=tracker.setup.seed + number * _SEEDS_APART)
        known = copy.copy(tracker.leader.correspondences)
        known.setup = own
        follower = PoseFilter(own, IteratedEstimator(own), known)
        follower.resume(State(origin.estimate.pose, origin.estimate.P, origin.frame))
        return cls(follower, tracker.finder.cost)

    @property
    def poses(self) -> list[Pose | None]:
        """Where tracked."""
        return [None if one is None else one.pose for one in self.estimates]

    def judge(self, estimate: Estimate, cloud: Cloud) -> None:
        """Append the estimate that the run stated in this frame."""
        self._add(estimate, self.cost(estimate.pose, self._own(cloud)))

    def follow(self, cloud: Cloud) -> None:
        """Append the estimate that the filter finds in this frame."""
        own, estimate = self._own(cloud), None
        lost = bool(self.estimates) and self.estimates[-1] is None
        if not lost and len(own.points) >= self.filter.setup.parameters.least_points:
            estimate = self.filter.step(own)
        if estimate is None or not estimate.tracked:
            self._add(None, np.inf)
        else:
            self._add(replace(estimate, correspondences=None), self.cost(estimate.pose, own))

    def _own(self, cloud: Cloud) -> Cloud:
        """The person's part of a cloud, cut around the pose of the frame before, as in a step."""
        setup, last = self.filter.setup, self.estimates[-1] if self.estimates else None
        pose = self.filter.state.pose if last is None else last.pose
        return own_part(cloud, setup.body, pose, setup.upright)

    def _add(self, estimate: Estimate | None, cost: float) -> None:
        self.estimates.append(estimate)
        self.costs.append(cost)


def _follow(
    gone: _Way,
    tries: Sequence[_Way],
    found: Sequence[TrackedFrame],
    clouds: Iterable[ReadCloud],
    told: Callable[[int, int], None],
) -> None:
    """Follow tries over the clouds of a stretch, and judge there the way that was gone."""
    judged = bool(gone.estimates)
    with ThreadPoolExecutor(_TOGETHER, thread_name_prefix="second look") as together:
        for done, (frame, (cloud, _)) in enumerate(zip(found, clouds, strict=True)):
            told(done, len(found))
            for _way in together.map(partial(_Way.follow, cloud=cloud), tries):
                pass  # what went wrong in it is raised here
            if not judged:
                gone.judge(frame.estimate, cloud)


def _apart(tracker: PersonTracker, ways: Sequence[Sequence[Pose | None]]) -> FloatArray:
    """Angles (F, W, W, 4) between the arm segments of two ways; NaN where one is lost."""
    directions = np.full((len(ways[0]), len(ways), len(_ARMS), 3), np.nan)
    for k, way in enumerate(ways):
        for i, pose in enumerate(way):
            if pose is not None:
                directions[i, k] = tracker.setup.body.frames(pose).rotations[_ARMS, :, 2]
    return angle_between(directions[:, :, None], directions[:, None])


def best_way(costs: FloatArray, agree: BoolArray) -> IntArray:
    """Which of the ways (F,) to be on in each frame, for the least sum of costs.

    From one frame to the next it goes over to another way only where both agree in the first
    (Viterbi, doi:10.1109/TIT.1967.1054010). Way 0 is kept where nothing is clearly better.

    Parameters
    ----------
    costs : (F, W) float64
        Infinite where a way is lost.
    agree : (F, W, W) bool
    """
    count, ways = costs.shape
    least, before = costs[0], np.zeros((count, ways), dtype=np.int64)
    for i in range(1, count):
        reached = np.where(agree[i - 1] | np.eye(ways, dtype=np.bool_), least[None], np.inf)
        before[i] = reached.argmin(axis=1)
        least = reached.min(axis=1) + costs[i]
    last = int(least.argmin())
    if not costs[:, 0].sum() - least[last] > _GAIN:
        return np.zeros(count, dtype=np.int64)
    chosen = np.full(count, last)
    for i in range(count - 1, 0, -1):
        chosen[i - 1] = before[i, chosen[i]]
    return chosen


def _surer(estimate: Estimate | None, agreed: BoolArray, *, switched: bool) -> Estimate:
    """An estimate that says whether chance has decided where its arm segments (4,) are.

    Where the way is another than before, no backward pass goes beyond it.
    """
    assert estimate is not None  # noqa: S101 - a way that is lost costs infinitely much
    lost = estimate.limb_lost.copy()
    lost[_ARMS] *= np.where(agreed, _AGREED, 1.0)
    return replace(estimate, limb_lost=lost, prior=None if switched else estimate.prior)


def _exchanged(
    frame: TrackedFrame, estimate: Estimate, tracker: PersonTracker, spent: float
) -> TrackedFrame:
    """A frame with another estimate."""
    seconds = {**frame.seconds, SECOND_LOOK: spent}
    points = landmarks(tracker.setup.body, estimate.pose)
    return replace(frame, estimate=estimate, landmarks=points, seconds=seconds)
