"""The step of presets ``accurate`` and ``fast``: measured points look for the model, iterated.

Baselines share with it all but the way from a frame's measurements to the pose.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.angles import state_names, state_of_pose
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.pose import Pose, orthonormal, t_pose
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.correction import innovation_of
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.estimate import Estimate, Memory, Prior
from stereotrack_core.tracking.estimator import (
    Estimator,
    Measurements,
    Posterior,
    Prediction,
    sensors_for,
)
from stereotrack_core.tracking.failure.disagreement import carried_on
from stereotrack_core.tracking.failure.features import Evidence, judged
from stereotrack_core.tracking.residuals.detections import predicted_by_detections
from stereotrack_core.tracking.residuals.surface import SurfaceResidual
from stereotrack_core.tracking.state import Belief, Setup, State, elapsed, time_array, time_in
from stereotrack_core.tracking.step_recorder import StepRecorder

_COARSE = 2
"""All iterations but the last use every second datum; the variances make up for it."""

_WIDE_ITERATIONS = 2

_WIDE_ARM = np.radians(40.0)
"""Standard deviation of the arms' joints around a proposal."""


class PoseFilter:
    """Follow a body from cloud to cloud, from a pose that is roughly right.

    Parameters
    ----------
    listens : bool
        Whether detections that come between two frames correct the prediction.

    Attributes
    ----------
    state : State
    sensors : tuple of Sensor
        What measures beside the cloud's points.
    origin : State
        From which the last step went out; what it was started with before the first.
    """

    def __init__(
        self,
        setup: Setup,
        estimator: Estimator,
        correspondences: DataToModel,
        *,
        listens: bool = False,
    ) -> None:
        self.setup = setup
        self.state = self.origin = setup.first_state(t_pose(np.zeros(3)))
        self.estimator = estimator
        self.correspondences = correspondences
        self.sensors = sensors_for(setup.parameters)
        self._listens = listens
        self.start(self.state.pose)

    def step(self, cloud: Cloud, trace: StepRecorder | None = None) -> Estimate:
        """Predict, correct the prediction by what the frame measures, judge the result."""
        begun, p, before = perf_counter(), self.setup.parameters, self.state
        self.origin = before
        predicted = self.predicted(cloud)
        if trace is not None:
            trace.predicted(before, predicted)
        if cloud.view_names and len(cloud.points) < p.least_points:
            return self.lost(before, cloud, f"the cloud has only {len(cloud.points)} points")
        measured = self.measured(cloud, trace)
        found = self.estimator.estimate(measured, predicted)
        if measured.unexplained_fraction(found.pose) > p.max_unexplained_fraction:
            return self.lost(before, cloud, "the cloud does not match the body")
        pose, fps = orthonormal(found.pose), self.setup.fps
        last = before.disagreement, predicted.gone / fps
        said = carried_on(*last, cloud.keypoints, self.setup.body, pose)
        self.state = State(pose, found.P, cloud.frame, disagreement=said)
        return self._judged(cloud, predicted, found, perf_counter() - begun)

    def predicted(self, cloud: Cloud) -> Prediction:
        """Predict that the body stays; detections on the way to the frame correct it."""
        setup, state = self.setup, self.state
        since = cloud.frame - 1.0 if state.time is None else state.time
        gone = elapsed(since, cloud.frame)
        due = [d for d in cloud.detections if since < d.time < cloud.frame]
        if not (self._listens and due):
            found = setup.predicted(state, since, cloud.frame)
            return Prediction(found.pose, found.P, gone)
        found = predicted_by_detections(setup, state, since, cloud.frame, due)
        unheard = state.P + gone * setup.Q
        return Prediction(found.pose, found.P, gone, unheard - found.P)

    def measured(self, cloud: Cloud, trace: StepRecorder | None = None) -> Measurements:
        """Take from a cloud what poses are measured by."""
        data = self.correspondences.choose(cloud)
        seen = tuple(sensor(cloud) for sensor in self.sensors)
        return Measurements(self.setup, cloud, data, self.correspondences, seen, trace)

    def start(
        self,
        pose: Pose,
        time: float | None = None,
        *,
        P: FloatArray | None = None,
    ) -> None:
        """Begin from a pose that is roughly right.

        Parameters
        ----------
        time : float, optional
            Frame that it belongs to; where not given, the one before the next cloud's.
        P : (n, n) float64, optional
            Covariance of a pose that an earlier frame gave, used if it is one of this filter's
            error state; else that of a first pose.
        """
        state = self.setup.first_state(pose, time)
        if P is not None and P.shape == state.P.shape:
            state = State(pose, P.copy(), time)
        self.resume(state)

    def resume(self, state: State) -> None:
        """Continue from a state."""
        self.state = self.origin = state
        self.estimator.begin(state.pose)

    def lost(self, before: State, cloud: Cloud, reason: str) -> Estimate:
        """State a frame in which nothing could be measured; the body is expected to stay."""
        P = before.P + elapsed(before.time, cloud.frame) * self.setup.Q
        self.resume(State(before.pose, P, cloud.frame, before.is_first))
        x = state_of_pose(before.pose, self.setup.joints)
        return Estimate(False, reason, before.pose, x, P)

    def memory(self) -> Memory:
        """All that the next step depends on; see :class:`Tracker`."""
        return {
            "position": self.state.pose.position,
            "rotations": self.state.pose.rotations,
            "P": self.state.P,
            "time": time_array(self.state.time),
            "anew": np.array(self.state.is_first),
            "disagreement": self.state.disagreement,
            **self.estimator.memory(),
            **self.correspondences.memory(),
        }

    def recall(self, memory: Memory) -> None:
        """Restore a saved state."""
        pose, time = Pose(memory["position"], memory["rotations"]), time_in(memory["time"])
        state = State(pose, memory["P"], time, bool(memory["anew"]))
        said = memory.get("disagreement", state.disagreement)  # not in runs of older versions
        self.resume(dataclasses.replace(state, disagreement=said))
        self.estimator.recall(memory)
        self.correspondences.recall(memory)

    def _judged(
        self, cloud: Cloud, predicted: Prediction, found: Posterior, seconds: float
    ) -> Estimate:
        """State the pose with the signs by which it can be judged."""
        setup, state, surface = self.setup, self.state, found.surface
        P0 = found.P0 if predicted.learned is None else found.P0 + predicted.learned
        prior = None if self.origin.is_first else Prior(P0, found.carried)
        dX = sigma_deviations(state.P, setup.weights)
        weight = surface.weight
        squared = float(weight @ surface.distance**2) / max(float(weight.sum()), 1e-12)
        squared = squared if len(weight) else float("nan")
        estimate = Estimate(
            tracked=True,
            reason="",
            pose=state.pose,
            x=state_of_pose(state.pose, setup.joints),
            P=state.P.copy(),
            residual=float(np.sqrt(squared)),
            innovation=found.innovation,
            correspondences=surface.pairs(),
            seconds={"track": seconds},
            prior=prior,
        )
        spread = displaced(state.pose, dX, setup.joints)
        movement = difference(state.pose, self.origin.pose, setup.joints)
        return judged(estimate, cloud, setup, Evidence(spread, movement, state.disagreement))


class LeaderTracker(ABC):
    """What trackers that follow with one filter, and know when it is lost, have in common.

    Parameters
    ----------
    leader : PoseFilter
        Follows the pose that is stated.
    """

    def __init__(self, leader: PoseFilter) -> None:
        self.setup = leader.setup
        self.leader = leader
        self.state_names = state_names(self.setup.joints)
        self._present = False

    @property
    def pose(self) -> Pose:
        """Where the person is."""
        return self.leader.state.pose

    @property
    def P(self) -> FloatArray:  # noqa: N802
        """Covariance (n, n) of the pose's error state."""
        return self.leader.state.P

    @abstractmethod
    def start(self, pose: Pose, time: float | None = None, *, P: FloatArray | None = None) -> None:
        """Begin from a pose that is roughly right; see :meth:`PoseFilter.start`."""

    def resume(self, state: State) -> None:
        """Continue from the state of another filter of the same body."""
        self.leader.resume(state)

    def try_from(
        self,
        state: State,
        cloud: Cloud,
        trace: StepRecorder | None,
        accepts: Callable[[Pose], bool] = lambda _pose: True,
    ) -> Estimate | None:
        """Estimate a frame from another state; without success the leader stays as it was.

        `accepts` says whether the pose that was found is wanted. No backward pass goes beyond the
        frame.
        """
        before, origin = self.leader.memory(), self.leader.origin
        self.leader.resume(dataclasses.replace(state, is_first=True))
        found = self.leader.step(cloud, trace)
        if found.tracked and accepts(found.pose):
            return found
        self.leader.recall(before)
        self.leader.origin = origin
        return None

    def reinitialise(self) -> None:
        """Know nothing: the next frame that shows somebody is searched."""
        self.start(self.pose)
        self._present = False


@dataclass(frozen=True, eq=False)
class _Corrected(Belief):
    """A corrected pose, and the pairs of points that it was corrected by."""

    surface: SurfaceResidual


class IteratedEstimator(Estimator):
    """Iterated posterior linearisation of the distances to the surface, and a search for the arms.

    Keeps nothing from frame to frame, so that many filters may share one.
    """

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.search = ArmSearch(setup.body, setup.parameters)
        arms = [6 + 2 * setup.joints.index(part) for part in (*UPPER_ARMS, *FOREARMS)]
        self._arms: IntArray = np.concatenate([[first, first + 1] for first in arms])

    def estimate(self, measured: Measurements, predicted: Prediction) -> Posterior:
        """Follow the data from the prediction, again where it was too narrow; look for the arms."""
        first, found = self.follow(measured, predicted, predicted)
        innovation = innovation_of(first, self.setup, predicted)
        prior = self._inflated(predicted, found)
        if prior is not predicted:
            _, found = self.follow(measured, prior, found)
        carried = np.ones(len(prior.P), dtype=np.bool_)
        searched = self.setup.parameters.search_arms and not measured.cloud.clicks
        if searched and (len(measured.data) or measured.cloud.depths):
            followed, found = found, self._with_best_arms(measured, prior, found)
            carried[self._arms] = found is followed
        return Posterior(found.pose, found.P, found.surface, innovation, prior.P, carried)

    def follow(
        self, measured: Measurements, prior: Belief, start: Belief
    ) -> tuple[SurfaceResidual, _Corrected]:
        """Iterate correspondences and corrections of a prior; returns the first pairs as well."""
        at, surfaces, last = start, [], self.setup.parameters.iterations - 1
        for i in range(last + 1):
            wide, every = i < _WIDE_ITERATIONS, 1 if i == last else _COARSE
            surfaces.append(measured.surface(at.pose, wide=wide, every=every))
            at = measured.corrected(prior, at, surfaces[-1])
        return surfaces[0], _Corrected(at.pose, at.P, surfaces[-1])

    def refine(self, measured: Measurements, proposed: Pose, P0: FloatArray) -> _Corrected:
        """Correct a proposed pose from a prior that is wide for the arms."""
        P = P0.copy()
        P[self._arms] = P[:, self._arms] = 0.0
        P[self._arms, self._arms] = _WIDE_ARM**2
        at = prior = Belief(proposed, P)
        for i in range(self.setup.parameters.search_iterations):
            wide = i + 1 < _WIDE_ITERATIONS
            surface = measured.surface(at.pose, wide=wide, every=_COARSE)
            at = measured.corrected(prior, at, surface)
        return _Corrected(at.pose, at.P, surface)

    def _inflated(self, predicted: Belief, found: Belief) -> Belief:
        """Inflate the prior where the data ask for more movement than it allows for.

        Position, rotation and every joint are judged alone by the distance that they were moved
        over its expected value. A narrow prior holds still limbs still, and yet nothing that
        moves fast is held back.
        """
        joints, P0 = self.setup.joints, predicted.P
        moved = difference(found.pose, predicted.pose, joints) ** 2 / np.diagonal(P0)
        groups = [moved[:3].mean(), moved[3:6].mean(), *moved[6:].reshape(-1, 2).mean(axis=1)]
        ratio = np.sqrt(np.repeat(groups, [3, 3] + [2] * len(joints)))
        factor = np.where(ratio > self.setup.parameters.prior_inflation_above, ratio, 1.0)
        if not np.any(factor > 1.0):
            return predicted
        return Belief(predicted.pose, P0 * np.outer(factor, factor))

    def _with_best_arms(
        self, measured: Measurements, prior: Belief, followed: _Corrected
    ) -> _Corrected:
        """Put the arms elsewhere if both together explain the frame clearly better there."""
        search, trace, rng = self.search, measured.trace, measured.random(1)
        expected, here, best = prior.pose, followed.pose, followed
        evidence = search.evidence(measured.cloud, here, rng)
        least = search.cost(evidence, expected, here) - evidence.gain
        if trace is not None:
            trace.searching(search, evidence, expected)
        for proposed in search.best_pairs(evidence, expected, here, rng, trace):
            found = self.refine(measured, proposed, prior.P)
            cost = search.cost(evidence, expected, found.pose)
            if trace is not None:
                trace.refined(proposed, found.pose)
            if cost < least:
                least, best = cost, found
        if trace is not None:
            trace.searched(followed.pose, best.pose)
        return best
