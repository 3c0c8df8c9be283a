"""A second look at stretches in which an arm may be lost: tried again, and the best way taken.

Where arms cross or are hidden, two places of an arm often explain a frame about equally well.
Chance then takes one, and it stays taken for as long as the arms stay. The frames of the whole
stretch together tell the two apart much better than each of them alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import ARM_PARTS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.clouds import ReadCloud
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.initialise.people import own_part
from stereotrack_core.tracking.model import TrackModel, TrackState
from stereotrack_core.tracking.run_spec import Hooks
from stereotrack_core.tracking.state import State
from stereotrack_core.tracking.step import SETTLED, PersonModel, PersonState

LOOKING_AGAIN = "looking again at frames with doubtful arms"  # the stage, in words
SECOND_LOOK = "second_look"  # the same as a stage of the frames that come again
_DOUBTFUL = 0.08  # probability that some arm segment is lost from which a frame is looked at again
# Sum of these probabilities, the frames expected to be lost, from which a stretch is worth a look:
# undisturbed views of mesh-P4 have up to 0.4, and looking there cost a sixth of the time.
_LEAST = 0.5
_BEFORE, _AFTER = 4, 8  # frames without doubt beside a stretch that are tracked again too
LONGEST = 100  # frames after which a stretch is looked at although it goes on
_AGREE = np.radians(15.0)  # angle of every arm segment up to which one way may go over to another
_SAME = np.radians(30.0)  # angle up to which tries have come to the same place of an arm segment
_AGREED = 0.2  # factor on the probability that it is lost then (docs/failures.md)
_FIRST = 2  # tries made at first; others only where these or the way gone disagree
_GAIN = 20.0  # cost by which another way must be better altogether to be taken
_SEEDS_APART = 1000  # between tries, so that those of runs with seeds 0, 1, ... differ
_TOGETHER = 2  # tries that are followed at the same time; each is the same however many are


@dataclass(frozen=True)
class LookNumbers:
    """Numbers of a second look from which a stopped run restores it."""

    first: int  # first frame that is held; -1 if none is
    expected: float
    calm: int
    changed: tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class SecondLook:
    """Tracked frames since arms have been doubtful, which are looked at again afterwards."""

    tries: int  # number of times that a stretch is tracked again; 0: never
    changed: tuple[tuple[int, int], ...] = ()  # stretches that were changed, as (first, last)
    held: tuple[TrackedFrame, ...] = ()  # without clouds; the first one is where the tries begin
    expected: float = 0.0  # sum of the probabilities that an arm is lost, over doubtful frames
    calm: int = 0  # frames without doubt since the last doubtful one

    def with_frame(self, tracked: TrackedFrame, *, sure: bool) -> SecondLook:
        """The look after the next frame; untracked, clicked or unsure ones end a stretch."""
        if not self.tries or not sure or not tracked.tracked or tracked.cloud.clicks:
            return self.forgotten()
        return self._holding(tracked)

    def _holding(self, tracked: TrackedFrame) -> SecondLook:
        lost = float(np.nan_to_num(tracked.estimate.limb_lost[ARM_PARTS]).max())
        doubtful = lost > _DOUBTFUL
        look = replace(
            self,
            held=(*self.held, tracked.without_cloud()),
            expected=self.expected + lost * doubtful,
            calm=0 if doubtful else self.calm + 1,
        )
        if look.calm >= _AFTER and not look.due:
            look = replace(look, expected=0.0)
        return look if look.expected else replace(look, held=look.held[-_BEFORE - 1 :])

    @classmethod
    def after(cls, frames: Iterable[TrackedFrame]) -> SecondLook:
        """The look after the frames of a run that was tracked without clicks."""
        look, started, on_trial = cls(0), False, 0
        for frame in frames:
            if not frame.tracked:
                on_trial = SETTLED - 1 if started else 0
            if not frame.tracked or on_trial or spent_on(frame):
                look = look.forgotten()
            if spent_on(frame):
                look = replace(look, held=(frame.without_cloud(),))
            elif frame.tracked and not on_trial:
                look = look._holding(frame)
                if look.due:  # the run had no second look
                    look = look.forgotten()
            on_trial = max(0, on_trial - frame.tracked)
            started = started or frame.tracked
        return look

    def forgotten(self) -> SecondLook:
        """The look that begins with the next frame."""
        return replace(self, held=(), expected=0.0, calm=0)

    @property
    def due(self) -> bool:
        """Whether a stretch is over, or long enough, and worth a look."""
        return self.pending and (self.calm >= _AFTER or len(self.held) > LONGEST)

    @property
    def pending(self) -> bool:
        """Whether there is enough for a look, though more frames may belong to it."""
        return self.expected >= _LEAST and len(self.held) > 1

    @property
    def first(self) -> int | None:
        """The first frame that a look may change; None where no frame is held."""
        return self.held[1].frame if len(self.held) > 1 else None

    @property
    def frames(self) -> range:
        """The frames that a look goes over."""
        return range(self.held[1].frame, self.held[-1].frame + 1)

    def numbers(self) -> LookNumbers:
        """Numbers to be kept beside the frames that are done."""
        first = self.held[0].frame if self.held else -1
        return LookNumbers(first, self.expected, self.calm, self.changed)

    def restored(self, numbers: LookNumbers, done: Sequence[TrackedFrame]) -> SecondLook:
        """The look with these numbers after the frames of a run that was stopped."""
        held = [one for one in done if 0 <= numbers.first <= one.frame]
        stated = numbers.expected, numbers.calm
        return SecondLook(self.tries, numbers.changed, tuple(held), *stated)


# The clouds of frames, as they are read.
Ahead: TypeAlias = Callable[[range], AbstractContextManager[Iterable[ReadCloud]]]


def looked_again(
    look: SecondLook, model: PersonModel, state: PersonState, clouds: Ahead, hooks: Hooks
) -> tuple[PersonState, SecondLook, tuple[TrackedFrame, ...]]:
    """Track a stretch again, and go on from the best way through it; `state`: after its end.

    Returns the state and the look after the stretch, and all its frames, with other probabilities
    that a limb is lost at least.
    """
    begun, (origin, *found) = perf_counter(), look.held
    start = State(origin.estimate.pose, origin.estimate.P, origin.frame)
    start = replace(start, colours=state.leader.colours)
    ways, apart = [_Way.from_state(start, model, 0)], np.full((1, 1, 1, 1), np.inf)
    for tries in (range(1, look.tries + 1)[:_FIRST], range(1, look.tries + 1)[_FIRST:]):
        if tries and not (apart < _SAME).all():
            new = [_Way.from_state(start, model, k) for k in tries]
            with clouds(look.frames) as made:
                _follow(ways[0], new, found, made, hooks)
            ways += new
            apart = _apart(model, [way.poses for way in ways])
    costs = np.array([way.costs for way in ways]).T
    chosen = best_way(costs, (apart < _AGREE).all(axis=-1))
    if chosen[-1]:
        leader = replace(ways[chosen[-1]].state, colours=state.leader.colours)
        state = replace(state, leader=leader)
    changed = look.changed
    if chosen.any():
        first = int(np.flatnonzero(chosen)[0])
        changed = (*changed, (found[first].frame, found[-1].frame))
    spent = (perf_counter() - begun) / len(found)
    result = []
    for i, (frame, way) in enumerate(zip(found, chosen, strict=True)):
        agreed = (apart[i, way] < _SAME).all(axis=0)
        estimate = _surer(ways[way].estimates[i], agreed, switched=way != chosen[max(0, i - 1)])
        points = landmarks(model.setup.body, estimate.pose)
        seconds = {**frame.seconds, SECOND_LOOK: spent}
        result.append(replace(frame, estimate=estimate, landmarks=points, seconds=seconds))
    return state, SecondLook(look.tries, changed, (result[-1],)), tuple(result)


def spent_on(frame: TrackedFrame) -> float:
    """Seconds that a second look spent on a frame; equal for all frames of one look, 0 without."""
    return frame.seconds.get(SECOND_LOOK, 0.0)


def last_settled(frames: Mapping[int, TrackedFrame], frame: int) -> int | None:
    """The last frame of a run, up to `frame`, whose stated pose alone decides how it went on, or
    None.

    The tracker went on from another pose inside a stretch that was looked at again, and from more
    than one while a pose was on trial after a loss.
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


def is_sure(model: TrackModel, state: TrackState) -> bool:
    """Whether poses are no longer on trial; of a baseline they never are sure enough."""
    if not (isinstance(model, PersonModel) and isinstance(state, PersonState)):
        return False
    return state.settled and model.follower.baseline is None


@dataclass(eq=False)
class _Way:
    """One way through a stretch, which grows frame by frame."""

    follower: Follower
    state: State
    cost: Callable[[Pose, Cloud], float]  # cost of a pose in a cloud
    estimates: list[Estimate | None] = field(default_factory=list)  # None from when it was lost
    costs: list[float] = field(default_factory=list)

    @classmethod
    def from_state(cls, start: State, model: PersonModel, number: int) -> _Way:
        """One that begins where the run was; each number has a chance of its own."""
        own = replace(model.setup, seed=model.setup.seed + number * _SEEDS_APART)
        return cls(Follower(own), start, model.finder.cost)

    @property
    def poses(self) -> list[Pose | None]:
        """Where tracked."""
        return [None if one is None else one.pose for one in self.estimates]

    def judge(self, estimate: Estimate, cloud: Cloud) -> None:
        """Append the estimate that the run stated in this frame."""
        self.costs.append(self.cost(estimate.pose, self._own(cloud)))
        self.estimates.append(estimate)

    def follow(self, cloud: Cloud) -> None:
        """Append the estimate that the filter finds in this frame."""
        own, estimate = self._own(cloud), None
        lost = bool(self.estimates) and self.estimates[-1] is None
        if not lost and len(own.points) >= self.follower.setup.parameters.least_points:
            self.state, estimate = self.follower.step(self.state, own)
        if estimate is None or not estimate.tracked:
            self.estimates.append(None)
            self.costs.append(np.inf)
        else:
            self.estimates.append(replace(estimate, correspondences=None))
            self.costs.append(self.cost(estimate.pose, own))

    def _own(self, cloud: Cloud) -> Cloud:
        """The person's part of a cloud, cut around the pose of the frame before, as in a step."""
        setup, last = self.follower.setup, self.estimates[-1] if self.estimates else None
        pose = self.state.pose if last is None else last.pose
        return own_part(cloud, setup.body, pose, setup.upright)


def _follow(
    gone: _Way,
    tries: Sequence[_Way],
    found: Sequence[TrackedFrame],
    clouds: Iterable[ReadCloud],
    hooks: Hooks,
) -> None:
    """Follow tries over the clouds of a stretch, and judge there the way that was gone."""
    judged = bool(gone.estimates)
    with ThreadPoolExecutor(_TOGETHER, thread_name_prefix="second look") as together:
        for done, (frame, (cloud, _)) in enumerate(zip(found, clouds, strict=True)):
            hooks.on_preparing(LOOKING_AGAIN, done, len(found))
            for _way in together.map(partial(_Way.follow, cloud=cloud), tries):
                pass  # what went wrong in it is raised here
            if not judged:
                gone.judge(frame.estimate, cloud)


def _apart(model: PersonModel, ways: Sequence[Sequence[Pose | None]]) -> FloatArray:
    """Angles (F, W, W, 4) between the arm segments of two ways; NaN where one is lost."""
    directions = np.full((len(ways[0]), len(ways), len(ARM_PARTS), 3), np.nan)
    for k, way in enumerate(ways):
        for i, pose in enumerate(way):
            if pose is not None:
                directions[i, k] = model.setup.body.frames(pose).rotations[ARM_PARTS, :, 2]
    return angle_between(directions[:, :, None], directions[:, None])


def best_way(costs: FloatArray, agree: BoolArray) -> IntArray:
    """Which of the ways (F,) to be on in each frame, for the least sum of costs (F, W).

    It goes over to another way only where both agree (F, W, W) in the frame before (Viterbi,
    doi:10.1109/TIT.1967.1054010). Way 0 is kept where nothing is clearly better. Costs are infinite
    where a way is lost.
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
    """An estimate with the probabilities by what the tries agreed on; after a switch, no prior."""
    assert estimate is not None  # noqa: S101 - a way that is lost costs infinitely much
    lost = estimate.limb_lost.copy()
    lost[ARM_PARTS] *= np.where(agreed, _AGREED, 1.0)
    return replace(estimate, limb_lost=lost, prior=None if switched else estimate.prior)
