"""Find the body without help, follow it, say when it is not there, and find it again."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, body_model, landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.posing import TRUNK
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.points import Volume
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.estimate import Estimate, Memory
from stereotrack_core.tracking.estimator import Estimator
from stereotrack_core.tracking.iekf import IteratedEstimator, LeaderTracker, PoseFilter
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
from stereotrack_core.tracking.keypoint_tracker import KeypointTracker
from stereotrack_core.tracking.parameters import Settings, TrackingParameters
from stereotrack_core.tracking.residuals.clicks import contradicted, pose_by_clicks
from stereotrack_core.tracking.state import Setup, elapsed
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.ukf import ThesisTracker
from stereotrack_core.tracking.view_watch import ViewWatch

_RIVALS = 3
"""Poses besides the best that are kept on trial."""

_RIVAL = "rival"
"""Begins the names of a rival's numbers in the memory."""

SETTLED = 12
"""Frames after which a pose that no rival has replaced is settled on."""

_LOOK_AGAIN = (2, 4, 7, 11)
"""Frames after the first in which better poses are looked for."""

_MEMORY = 0.8
"""Share of the sum of earlier costs that still counts."""

_HOPELESS, _BETTER = 40.0, 6.0
"""Costs by which a pose on trial must be worse to be given up, and better to be taken."""

_ENOUGH_DOUBT, _MOST_TRUST = 60.0, 200.0
"""Sum of such costs over frames from which a settled pose is turned round, and the most that
earlier frames can weigh against it."""

_BIAS = 8.0
"""Cost by which the other way round may be more natural, frame after frame, only because ranges
are biased: strong compression of somebody in a T pose has 4 to 11, a wrong heading 15 to 40."""

_LEAST_SUPPORT, _WHOLE = 0.5, 0.9
"""Shares of the trunk's patches without which too little of the body is there, and with which it
is there as a whole."""

_CUT, _HALF_CUT = 0.035, 0.15
"""Shares of the points at the sides of the volume from which a body is cut by them that is not
seen as a whole, and any body."""

_DOUBT = 0.2
"""Factor on these shares while a pose is on trial."""

_CONFIRMED_BY = 3
"""Successive frames that show enough of a body which was partly out of sight before it is stated,
as tracks of many objects are begun (doi:10.1109/ICIP.2016.7533003)."""

_TRUNK_ROWS = [LANDMARKS.index(name) for name in TRUNK]

_BESIDE = 0.1
"""Metres of a landmark of the trunk from a side of the volume within which a body that comes back
is cut: what is left of it is seen as a whole one that stands farther inside."""

_ENOUGH_TRUNK = 3
"""Clicked landmarks of a trunk that show where somebody is who was not there."""

_TOLD = 11
"""Frames from one in which a trunk is clicked on in which little of a body is enough to follow."""

_FASTEST = 3.0
"""Metres per second beyond which hips have not moved: another pose has been taken."""


class PersonTracker(LeaderTracker):
    """Follow a person with a filter, and look for the pose wherever it was not there before.

    What is found may be mistaken, above all front for back. So other poses that explain the
    first cloud nearly as well are followed beside the best one for some frames, until the sum of
    their costs tells which is right.

    Once a body was partly out of sight, a pose that is found is stated from the third frame on: at
    the edge of the volume, what is left of a body is easily explained by a whole one elsewhere.
    """

    def __init__(self, leader: PoseFilter) -> None:
        super().__init__(leader)
        self.finder = PoseFinder(leader.setup)
        self.start(leader.state.pose)

    def start(
        self,
        pose: Pose,
        time: float | None = None,
        *,
        P: FloatArray | None = None,
    ) -> None:
        """Begin from a pose that is roughly right; see :meth:`PoseFilter.start`."""
        self.leader.start(pose, time, P=P)
        self._reset()

    def _reset(self) -> None:
        """Follow the leader alone, without doubt of its pose."""
        self._present = True
        self._age, self._unchanged = 0, SETTLED
        self._cost = self._doubt = 0.0
        self._rivals: list[Candidate] = []
        self._unconfirmed = self._told = 0
        self.watch = ViewWatch()

    def step(self, cloud: Cloud, trace: StepRecorder | None = None) -> Estimate:
        """Follow to the next cloud; look for the person first where nobody was followed."""
        if cloud.clicks:
            self._heed(cloud)
        before, every = self.leader.state, cloud
        if self.setup.parameters.leave_out_views:
            cloud = self.watch.trusted(cloud)
        if len(cloud.points) >= self.setup.parameters.least_points:
            if not self._present:
                self._initialise(cloud, trace)
            cloud = own_part(cloud, self.setup.body, self.pose, self.setup.upright)
        estimate = self.leader.step(cloud, trace)
        if estimate.tracked:
            compared = self._on_trial if self._unchanged < SETTLED else self._settled
            estimate = compared(cloud, estimate, trace)
        partial, self._told = self._unconfirmed > 0, max(0, self._told - 1)
        if estimate.tracked and not self._told and (reason := self._why_partial(cloud)):
            estimate, partial = self.leader.lost(before, cloud, reason), True
        if not estimate.tracked:
            self.reinitialise()
            self._unconfirmed = _CONFIRMED_BY if partial else 0
            return estimate
        estimate = replace(estimate, doubts=self.watch.doubts)
        self.watch = self.watch.updated(every, self.setup.body, self.pose)
        self.leader.correspondences.learn(self.pose, estimate.unexplained_fraction)
        if self._unconfirmed:
            seconds = elapsed(before.time, cloud.frame) / self.setup.fps
            moved = float(np.linalg.norm(self.pose.position - before.pose.position))
            since = _CONFIRMED_BY if moved > _FASTEST * seconds else self._unconfirmed
            self._unconfirmed = since - 1
        return _unstated(estimate) if self._unconfirmed else estimate

    @property
    def settled(self) -> bool:
        """Whether the pose is stated, no longer on trial, and no click has just said otherwise."""
        return self._unchanged >= SETTLED and not (self._unconfirmed or self._told)

    def memory(self) -> Memory:
        """All that the next step depends on, the rivals on trial too."""
        counts = (self._unconfirmed, self._age, self._unchanged, self._told)
        trial = [self._present, *counts, self._cost, self._doubt]
        kept = {**self.leader.memory(), **self.watch.memory(), "trial": np.array(trial, float)}
        for k, rival in enumerate(self._rivals):
            own = {**rival.filter.memory(), "cost": np.array(rival.cost)}
            kept |= {f"{_RIVAL}{k}.{name}": array for name, array in own.items()}
        return kept

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        self.leader.recall(memory)
        self.watch = ViewWatch.of_memory(memory)
        present, *counts, self._cost, self._doubt = memory["trial"].tolist()
        self._present = bool(present)
        self._unconfirmed, self._age, self._unchanged, *told = map(int, counts)
        self._told = told[0] if told else 0  # runs of older versions know nothing of clicks
        self._rivals = []
        for k in range(sum(name.endswith(".cost") for name in memory)):
            first = f"{_RIVAL}{k}."
            own = {n.removeprefix(first): a for n, a in memory.items() if n.startswith(first)}
            follower = self.finder.follower(self.pose)
            follower.recall(own)
            self._rivals.append(Candidate(follower, float(own["cost"])))

    def _heed(self, cloud: Cloud) -> None:
        """Begin where clicks put the body, if that is elsewhere than it was followed to."""
        trunk = {click.kind for click in cloud.clicks} & set(TRUNK)
        if len(trunk) >= _ENOUGH_TRUNK:
            self._told = _TOLD
        elif not self._present:
            return
        found = pose_by_clicks(self.setup, self.pose, cloud.clicks)
        if not self._present or contradicted(self.setup.body, self.pose, found):
            self.start(found, cloud.frame)
            self._told = _TOLD if len(trunk) >= _ENOUGH_TRUNK else 0

    def _initialise(self, cloud: Cloud, trace: StepRecorder | None) -> None:
        """Start from the pose that explains somebody in the cloud best; keep its rivals."""
        found = self.finder.poses_in(cloud, self.pose)
        if found:
            best, *others = found
            unconfirmed = self._unconfirmed
            self.start(best.pose, cloud.frame)
            self._unconfirmed = unconfirmed
            if trace is not None:
                trace.reinitialised()
            self._cost, self._unchanged = best.cost, 0
            self._rivals = others[:_RIVALS]

    def _on_trial(self, cloud: Cloud, estimate: Estimate, trace: StepRecorder | None) -> Estimate:
        """Follow the rivals as well, and now and then look for better ones.

        Whoever appears at the edge of the volume is found while there is little of the body, so
        that what was found first may be wrong in a way that following does not mend.
        """
        self._age += 1
        self._cost = _MEMORY * self._cost + self.finder.cost(self.pose, cloud)
        candidates = self._followed_rivals(cloud)
        if self._age in _LOOK_AGAIN:
            memory = sum(_MEMORY**k for k in range(self._age + 1))
            for candidate in self.finder.poses_of(cloud, self.pose):
                candidate.cost *= memory
                candidates.append(candidate)
        best = min(candidates, key=by_cost, default=None)
        self._unchanged += 1
        if best is not None and best.cost < self._cost - _BETTER:
            previous, cost = self.leader.state, self._cost
            exchanged = self.try_from(best.filter.origin, cloud, trace)
            if exchanged is not None:
                estimate, self._cost, self._unchanged = exchanged, best.cost, 0
                best.filter.resume(previous)
                best.cost = cost
        hopeful = [each for each in candidates if each.cost < self._cost + _HOPELESS]
        others = [each for each in hopeful if differ(each.pose, self.pose)]
        self._rivals = distinct(others)[:_RIVALS]
        return estimate

    def _followed_rivals(self, cloud: Cloud) -> list[Candidate]:
        """The rivals that can be followed to the cloud, with what speaks against them by now."""
        kept = []
        for rival in self._rivals:
            if rival.filter.step(cloud).tracked:
                if self.finder.gain_of_turning(rival.pose, cloud) > TURN_GAIN:
                    rival.filter.start(turned_round(rival.pose), cloud.frame)
                rival.cost = _MEMORY * rival.cost + self.finder.cost(rival.pose, cloud)
                kept.append(rival)
        return kept

    def _settled(self, cloud: Cloud, estimate: Estimate, trace: StepRecorder | None) -> Estimate:
        """Turn round where frame after frame has said that the body faces the other way.

        The evidence is added up as in Page's test (doi:10.1093/biomet/41.1-2.100), but what has
        spoken for the pose before is remembered up to a limit.
        """
        gain = self.finder.gain_of_turning(self.pose, cloud)
        evidence = min(gain - TURN_GAIN, 0.0) + max(gain - _BIAS, 0.0)
        self._doubt = max(-_MOST_TRUST, self._doubt + evidence)
        if self._doubt > _ENOUGH_DOUBT:
            turned = self.setup.first_state(turned_round(self.pose), cloud.frame)
            found = self.try_from(turned, cloud, trace)
            if found is not None:
                self._reset()
                return found
        return estimate

    def _why_partial(self, cloud: Cloud) -> str:
        """Say why too little of the body is there to tell its pose; empty where there is enough."""
        setup = self.setup
        support = trunk_support(setup.body, self.pose, cloud.points, setup.cameras)
        if support < _LEAST_SUPPORT:
            return "the cloud contains too little of the body"
        if setup.volume is None:
            return ""
        cut = share_at_sides(cloud.points, setup.volume, setup.upright)
        doubt = _DOUBT if self._unchanged < SETTLED else 1.0
        trunk = landmarks(setup.body, self.pose)[_TRUNK_ROWS]
        beside = depth_inside(trunk, setup.volume, setup.upright).min() < _BESIDE
        if (
            cut > doubt * _HALF_CUT
            or (support < _WHOLE and cut > doubt * _CUT)
            or (self._unconfirmed and beside)
        ):
            return "the body is partly outside the working volume"
        return ""


def _unstated(estimate: Estimate) -> Estimate:
    """The estimate of a frame whose pose the next ones have to confirm."""
    reason = "the body comes back into view; the next frames tell whether its pose is right"
    return Estimate(False, reason, estimate.pose, estimate.x, estimate.P)


Tracker: TypeAlias = ThesisTracker | PersonTracker | KeypointTracker
"""Follows a body from cloud to cloud. What it keeps in its :data:`Memory` is all that its next step
depends on; the covariance that it is started with is used where it is of its own state."""


def cameras_of(recording: Recording, views: Sequence[str]) -> FloatArray:
    """Optical centres (V, 3) of views, world, metres."""
    cameras = [recording.reference_camera(recording.view(name)) for name in views]
    return np.array([camera.position_world for camera in cameras])


_BASELINES = "stereotrack_core.experiments.baselines"

_ESTIMATORS: Mapping[str, str] = MappingProxyType(
    {
        "iterated": f"{IteratedEstimator.__module__}:IteratedEstimator",
        "extended_kalman": f"{_BASELINES}.estimators:ExtendedKalman",
        "annealed_particles": f"{_BASELINES}.particles:AnnealedParticles",
        "limb_icp": f"{_BASELINES}.estimators:LimbIcp",
        "scalar_distance": f"{_BASELINES}.estimators:ScalarDistance",
    }
)
"""Where estimators are, by the parameter's value; loaded by name, because those of experiments are
made of parts of the tracker."""


def tracker_for(
    body: BodyModel,
    settings: Settings,
    cameras: FloatArray,
    fps: float,
    seed: int,
    *,
    clouds: bool = True,
) -> Tracker:
    """Make the tracker that the settings ask for; `cameras` (V, 3) are optical centres, world.

    Without `clouds`, keypoints alone are followed, by the filter of the iterated estimator.
    """
    p = settings.tracking
    depth = settings.depth
    setup = Setup(body, p, cameras, fps, seed, Volume.of(depth), depth.upright)
    if not clouds:
        if settings.needs_depth:
            raise InputError(
                "this preset's tracker needs depth, and no view provides it",
                where="--preset",
                remedy="Use the preset accurate or fast.",
            )
        return KeypointTracker(PoseFilter(setup, IteratedEstimator(setup), DataToModel(setup)))
    if p.matching == "model_to_data":
        return ThesisTracker(setup)
    estimator: Estimator = pkgutil.resolve_name(_ESTIMATORS[p.estimator])(setup)
    correspondences = DataToModel(setup, coloured=True)
    return PersonTracker(PoseFilter(setup, estimator, correspondences, listens=True))


def initialiser_for(
    body: BodyModel, settings: Settings, cameras: FloatArray, recording: Recording, seed: int
) -> PersonTracker:
    """A tracker that only looks for first poses: without colours and detections between frames.

    The thesis begins from a known pose; its body, without legs, is not made for search, so for
    it another body of the same lengths is looked for.
    """
    p = settings.tracking
    if p.matching == "model_to_data":
        p, body = TrackingParameters(), body_model(proportions_of(recording.subject))
    depth = settings.depth
    return initialiser(
        Setup(body, p, cameras, recording.fps, seed, Volume.of(depth), depth.upright)
    )


def initialiser(setup: Setup) -> PersonTracker:
    """A tracker of the iterated estimator alone."""
    return PersonTracker(PoseFilter(setup, IteratedEstimator(setup), DataToModel(setup)))
