"""The step of a person in clouds: follow, find after a loss, say when nobody is there."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import state_names
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose, t_pose
from stereotrack_core.body.posing import TRUNK
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.initialise.finder import (
    TURN_GAIN,
    Candidate,
    PoseFinder,
    by_cost,
    differ,
    distinct,
)
from stereotrack_core.tracking.initialise.people import (
    depth_inside,
    own_part,
    share_at_sides,
    trunk_support,
)
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.measurements import colours_after
from stereotrack_core.tracking.residuals.clicks import contradicted, pose_by_clicks
from stereotrack_core.tracking.state import Setup, State, elapsed
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.view_watch import ViewWatch

_RIVALS = 3  # poses besides the best that are kept on trial
SETTLED = 12  # frames after which a pose that no rival has replaced is settled on
_LOOK_AGAIN = (2, 4, 7, 11)  # frames after the first in which better poses are looked for
_MEMORY = 0.8  # share of the sum of earlier costs that still counts
_HOPELESS, _BETTER = 40.0, 6.0  # costs of a pose on trial: worse to give up, better to take
_ENOUGH_DOUBT, _MOST_TRUST = 60.0, 200.0  # sums of costs: to turn a settled pose, most against it
# Cost by which the other way round may be more natural only because ranges are biased: strong
# compression of somebody in a T pose has 4 to 11, a wrong heading 15 to 40.
_BIAS = 8.0
_LEAST_SUPPORT, _WHOLE = 0.5, 0.9  # shares of the trunk's patches: least, and as a whole
# Shares of the points at the sides of the volume from which a body is cut by them that is not seen
# as a whole, and any body.
_CUT, _HALF_CUT = 0.035, 0.15
_DOUBT = 0.2  # factor on these shares while a pose is on trial
# Successive frames that show enough of a body which was partly out of sight before it is stated, as
# tracks of many objects are begun (doi:10.1109/ICIP.2016.7533003).
_CONFIRMED_BY = 3
_TRUNK_ROWS = [LANDMARKS.index(name) for name in TRUNK]
# Metres of a landmark of the trunk from a side of the volume within which a body that comes back is
# cut: what is left of it is seen as a whole one farther inside.
_BESIDE = 0.1
_ENOUGH_TRUNK = 3  # clicked landmarks of a trunk that show where somebody is who was not there
_CLICK_FRAMES = 11  # frames from a clicked trunk on in which little of a body is enough
_FASTEST = 3.0  # metres per second beyond which hips have not moved: another pose has been taken


@dataclass(frozen=True, eq=False)
class PersonState:
    """Everything that the next step of a person depends on."""

    leader: State  # state of the filter that follows the stated pose
    present: bool = True  # whether somebody is followed; else each frame is searched
    age: int = 0  # frames since the pose was found
    unchanged: int = SETTLED  # frames since no rival has replaced the pose
    cost: float = 0.0  # sum of the costs of a pose on trial
    doubt: float = 0.0  # evidence that a settled pose faces the other way
    rivals: tuple[Candidate, ...] = ()
    unconfirmed: int = 0  # frames that a pose which came back into view has yet to be confirmed by
    click_frames: int = 0  # frames in which little of a body is enough, as a trunk was clicked on
    watch: ViewWatch = field(default_factory=ViewWatch)

    @property
    def pose(self) -> Pose:
        """Pose of the person."""
        return self.leader.pose

    @property
    def P(self) -> FloatArray:  # noqa: N802
        """Covariance (n, n) of the pose's error state."""
        return self.leader.P

    @property
    def settled(self) -> bool:
        """Whether the pose is stated, no longer on trial, and no click has just said otherwise."""
        return self.unchanged >= SETTLED and not (self.unconfirmed or self.click_frames)


@dataclass(frozen=True, eq=False)
class FollowedModel:
    """A person who is followed with a filter, and looked for after having been out of sight."""

    follower: Follower

    @property
    def setup(self) -> Setup:
        """Body and parameters."""
        return self.follower.setup

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the numbers of the state."""
        return state_names(self.setup.joints)

    def first(
        self, pose: Pose, time: float | None = None, *, P: FloatArray | None = None
    ) -> PersonState:
        """State at a pose that is roughly right; see :meth:`Follower.first`."""
        return PersonState(self.follower.first(pose, time, P=P))

    def absent(self, last: Pose | None = None) -> PersonState:
        """State before the first frame that shows somebody, last seen in a pose."""
        return replace(self.first(t_pose(np.zeros(3)) if last is None else last), present=False)


@dataclass(frozen=True, eq=False)
class PersonModel(FollowedModel):
    """A person who is followed in clouds.

    A pose that is found may be mistaken, above all front for back. So other poses that explain the
    first cloud nearly as well are followed beside the best one for some frames, until the sum of
    their costs tells which is right.

    Once a body was partly out of sight, a pose that is found is stated from the third frame on: at
    the edge of the volume, what is left of a body is easily explained by a whole one elsewhere.
    """

    @cached_property
    def finder(self) -> PoseFinder:
        """Finds poses of the person in single clouds."""
        return PoseFinder(self.setup)

    def step(
        self, state: PersonState, cloud: Cloud, recorder: StepRecorder | None = None
    ) -> tuple[PersonState, Estimate]:
        """Follow to the next cloud; look for the person first where nobody was followed."""
        if cloud.clicks:
            state = self._at_clicks(state, cloud)
        before, every, p = state.leader, cloud, self.setup.parameters
        if p.leave_out_views:
            cloud = state.watch.trusted(cloud)
        if len(cloud.points) >= p.least_points:
            if not state.present:
                state = self._initialised(state, cloud, recorder)
            cloud = own_part(cloud, self.setup.body, state.pose, self.setup.upright)
        leader, estimate = self.follower.step(state.leader, cloud, recorder)
        state = replace(state, leader=leader)
        if estimate.tracked:
            compared = self._on_trial if state.unchanged < SETTLED else self._turned_if_wrong
            state, estimate = compared(state, estimate, cloud, recorder)
        partial = state.unconfirmed > 0
        state = replace(state, click_frames=max(0, state.click_frames - 1))
        if estimate.tracked and not state.click_frames:
            reason = self._why_partial(state, cloud)
            if reason:
                (leader, estimate), partial = self.follower.lost(before, cloud, reason), True
                state = replace(state, leader=leader)
        if not estimate.tracked:
            lost = self._restarted(state, self.first(state.pose))
            unconfirmed = _CONFIRMED_BY if partial else 0
            return replace(lost, present=False, unconfirmed=unconfirmed), estimate
        estimate = replace(estimate, doubts=state.watch.doubts)
        state = self._learned(state, before, every, cloud, estimate)
        if state.unconfirmed:
            reason = "the body comes back into view; the next frames tell whether its pose is right"
            estimate = Estimate(False, reason, estimate.pose, estimate.x, estimate.P)
        return state, estimate

    def _restarted(self, state: PersonState, new: PersonState) -> PersonState:
        """A new state that keeps the learned colours."""
        return replace(new, leader=replace(new.leader, colours=state.leader.colours))

    def _learned(
        self, state: PersonState, before: State, every: Cloud, own: Cloud, estimate: Estimate
    ) -> PersonState:
        """State after a tracked frame of `every` view, and the trusted views' `own` part."""
        known, unexplained = state.leader.colours, estimate.unexplained_fraction
        colours = colours_after(self.setup, known, own, state.pose, unexplained)
        unconfirmed = state.unconfirmed
        if unconfirmed:
            seconds = elapsed(before.time, own.frame) / self.setup.fps
            moved = float(np.linalg.norm(state.pose.position - before.pose.position))
            unconfirmed = (_CONFIRMED_BY if moved > _FASTEST * seconds else unconfirmed) - 1
        return replace(
            state,
            leader=replace(state.leader, colours=colours),
            watch=state.watch.updated(every, self.setup.body, state.pose),
            unconfirmed=unconfirmed,
        )

    def _at_clicks(self, state: PersonState, cloud: Cloud) -> PersonState:
        """Begin where clicks put the body, if that is elsewhere than it was followed to."""
        trunk = {click.kind for click in cloud.clicks} & set(TRUNK)
        if len(trunk) >= _ENOUGH_TRUNK:
            state = replace(state, click_frames=_CLICK_FRAMES)
        elif not state.present:
            return state
        found = pose_by_clicks(self.setup, state.pose, cloud.clicks)
        if state.present and not contradicted(self.setup.body, state.pose, found):
            return state
        told = _CLICK_FRAMES if len(trunk) >= _ENOUGH_TRUNK else 0
        return replace(self._restarted(state, self.first(found, cloud.frame)), click_frames=told)

    def _initialised(
        self, state: PersonState, cloud: Cloud, recorder: StepRecorder | None
    ) -> PersonState:
        """Start from the pose that explains somebody in the cloud best; keep its rivals."""
        found = self.finder.poses_in(cloud, state.pose)
        if not found:
            return state
        best, *others = found
        if recorder is not None:
            recorder.reinitialised()
        return replace(
            self._restarted(state, self.first(best.pose, cloud.frame)),
            cost=best.cost,
            unchanged=0,
            rivals=tuple(others[:_RIVALS]),
            unconfirmed=state.unconfirmed,
        )

    def _on_trial(
        self, state: PersonState, estimate: Estimate, cloud: Cloud, recorder: StepRecorder | None
    ) -> tuple[PersonState, Estimate]:
        """Follow the rivals as well, and now and then look for better ones.

        Whoever appears at the edge of the volume is found while there is little of the body, so
        that the first pose may be wrong in a way that following does not mend.
        """
        age, leader = state.age + 1, state.leader
        cost = _MEMORY * state.cost + self.finder.cost(leader.pose, cloud)
        candidates, unchanged = self._followed_rivals(state, cloud), state.unchanged + 1
        if age in _LOOK_AGAIN:
            memory = sum(_MEMORY**k for k in range(age + 1))
            more = self.finder.poses_of(cloud, leader.pose)
            candidates += [replace(one, cost=one.cost * memory) for one in more]
        best = min(candidates, key=by_cost, default=None)
        if best is not None and best.cost < cost - _BETTER:
            other, exchanged = self.follower.tried(best.before, leader, cloud, recorder)
            if exchanged.tracked:
                previous = replace(leader, colours=None)
                candidates[candidates.index(best)] = Candidate(previous, previous, cost)
                leader, estimate, cost, unchanged = other, exchanged, best.cost, 0
        hopeful = [each for each in candidates if each.cost < cost + _HOPELESS]
        others = [each for each in hopeful if differ(each.pose, leader.pose)]
        rivals = tuple(distinct(others)[:_RIVALS])
        trial = replace(state, age=age, cost=cost, unchanged=unchanged, rivals=rivals)
        return replace(trial, leader=leader), estimate

    def _followed_rivals(self, state: PersonState, cloud: Cloud) -> list[Candidate]:
        """The rivals that can be followed to the cloud, with their costs by now."""
        kept, follower = [], self.finder.follower
        for rival in state.rivals:
            before, (after, estimate) = rival.state, follower.step(rival.state, cloud)
            if not estimate.tracked:
                continue
            if self.finder.gain_of_turning(after.pose, cloud) > TURN_GAIN:
                before = after = follower.first(turned_round(after.pose), cloud.frame)
            cost = _MEMORY * rival.cost + self.finder.cost(after.pose, cloud)
            kept.append(Candidate(after, before, cost))
        return kept

    def _turned_if_wrong(
        self, state: PersonState, estimate: Estimate, cloud: Cloud, recorder: StepRecorder | None
    ) -> tuple[PersonState, Estimate]:
        """Turn round by lasting evidence, as Page's test (doi:10.1093/biomet/41.1-2.100)."""
        gain = self.finder.gain_of_turning(state.pose, cloud)
        evidence = min(gain - TURN_GAIN, 0.0) + max(gain - _BIAS, 0.0)
        state = replace(state, doubt=max(-_MOST_TRUST, state.doubt + evidence))
        if state.doubt > _ENOUGH_DOUBT:
            turned = self.setup.first_state(turned_round(state.pose), cloud.frame)
            leader, found = self.follower.tried(turned, state.leader, cloud, recorder)
            if found.tracked:
                return PersonState(leader), found
        return state, estimate

    def _why_partial(self, state: PersonState, cloud: Cloud) -> str:
        """Say why too little of the body is there to tell its pose; empty where there is enough."""
        setup = self.setup
        support = trunk_support(setup.body, state.pose, cloud.points, setup.cameras)
        if support < _LEAST_SUPPORT:
            return "the cloud contains too little of the body"
        if setup.volume is None:
            return ""
        cut = share_at_sides(cloud.points, setup.volume, setup.upright)
        doubt = _DOUBT if state.unchanged < SETTLED else 1.0
        trunk = landmarks(setup.body, state.pose)[_TRUNK_ROWS]
        beside = depth_inside(trunk, setup.volume, setup.upright).min() < _BESIDE
        if (
            cut > doubt * _HALF_CUT
            or (support < _WHOLE and cut > doubt * _CUT)
            or (state.unconfirmed and beside)
        ):
            return "the body is partly outside the working volume"
        return ""
