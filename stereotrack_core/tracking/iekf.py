"""The step of presets ``accurate`` and ``fast``: measured points look for the model, iterated."""

from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.angles import state_of_pose
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.pose import Pose, orthonormal
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.correction import Sensor, innovation_of
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.estimator import (
    Estimator,
    Measurements,
    Posterior,
    Prediction,
    sensors_for,
)
from stereotrack_core.tracking.failure.features import Evidence, carried_on, judged
from stereotrack_core.tracking.part_colours import PartColours
from stereotrack_core.tracking.residuals.detections import predicted_by_detections
from stereotrack_core.tracking.residuals.surface import SurfaceResidual
from stereotrack_core.tracking.state import Belief, Setup, State, elapsed
from stereotrack_core.tracking.step_recorder import StepRecorder

_COARSE = 2  # all iterations but the last use every second datum; the variances make up for it
_WIDE_ITERATIONS = 2
_WIDE_ARM = np.radians(40.0)  # standard deviation of the arms' joints around a proposal


@dataclass(frozen=True, eq=False)
class Follower:
    """Follows a body from cloud to cloud, from a pose that is roughly right."""

    setup: Setup
    estimator: Estimator
    uses_colours: bool = False  # whether parts' colours are learned, if they have weight
    uses_async_detections: bool = False  # whether those between frames count
    judges: bool = True  # whether estimates state limb failures, as searches need not

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """Sources of measurements beside the cloud's points."""
        return sensors_for(self.setup.parameters)

    def first(self, pose: Pose, time: float | None = None, *, P: FloatArray | None = None) -> State:
        """State at a pose that is roughly right, of frame `time` or the one before the next
        cloud's.

        `P` (n, n) is used if it is of this filter's error state; else the covariance is a first
        pose's.
        """
        state, p = self.setup.first_state(pose, time), self.setup.parameters
        if P is not None and P.shape == state.P.shape:
            state = State(pose, P.copy(), time)
        coloured = self.uses_colours and p.colour_weight > 0.0
        return replace(state, colours=PartColours.unknown(self.setup.body) if coloured else None)

    def step(
        self, before: State, cloud: Cloud, recorder: StepRecorder | None = None
    ) -> tuple[State, Estimate]:
        """Predict, correct the prediction by what the frame measures, judge the result."""
        begun, p = perf_counter(), self.setup.parameters
        predicted = self.predicted(before, cloud)
        if recorder is not None:
            recorder.predicted(before, predicted)
        if cloud.view_names and len(cloud.points) < p.least_points:
            return self.lost(before, cloud, f"the cloud has only {len(cloud.points)} points")
        measured = self.measured(before, cloud, recorder)
        found = self.estimator.estimate(measured, predicted)
        if measured.unexplained_fraction(found.pose) > p.max_unexplained_fraction:
            return self.lost(before, cloud, "the cloud does not match the body")
        pose, fps = orthonormal(found.pose), self.setup.fps
        last = before.disagreement, predicted.gone / fps
        said = carried_on(*last, cloud.keypoints, self.setup.body, pose)
        kept = before.colours, found.particles
        after = State(pose, found.P, cloud.frame, False, said, *kept)
        seconds = {"track": perf_counter() - begun}
        estimate = replace(self._estimate(before, predicted, found, after), seconds=seconds)
        if not self.judges:
            return after, estimate
        dX = sigma_deviations(after.P, self.setup.weights)
        spread = displaced(pose, dX, self.setup.joints)
        movement = difference(pose, before.pose, self.setup.joints)
        return after, judged(estimate, cloud, self.setup, Evidence(spread, movement, said))

    def predicted(self, state: State, cloud: Cloud) -> Prediction:
        """Predict that the body stays; detections on the way to the frame correct it."""
        setup = self.setup
        since = cloud.frame - 1.0 if state.time is None else state.time
        gone = elapsed(since, cloud.frame)
        due = [d for d in cloud.detections if since < d.time < cloud.frame]
        if not (self.uses_async_detections and due):
            found = setup.predicted(state, since, cloud.frame)
            return Prediction(found.pose, found.P, gone, particles=state.particles)
        found = predicted_by_detections(setup, state, since, cloud.frame, due)
        unheard = state.P + gone * setup.Q
        return Prediction(found.pose, found.P, gone, unheard - found.P, state.particles)

    def measured(
        self, state: State, cloud: Cloud, recorder: StepRecorder | None = None
    ) -> Measurements:
        """Take from a cloud what poses are measured by."""
        pairing = DataToModel(self.setup, state.colours)
        seen = tuple(sensor(cloud) for sensor in self.sensors)
        return Measurements(self.setup, cloud, pairing.choose(cloud), pairing, seen, recorder)

    def lost(self, before: State, cloud: Cloud, reason: str) -> tuple[State, Estimate]:
        """State a frame in which nothing could be measured; the body is expected to stay."""
        P = before.P + elapsed(before.time, cloud.frame) * self.setup.Q
        x = state_of_pose(before.pose, self.setup.joints)
        after = State(before.pose, P, cloud.frame, before.is_first, colours=before.colours)
        return after, Estimate(False, reason, before.pose, x, P)

    def tried(
        self, other: State, current: State, cloud: Cloud, recorder: StepRecorder | None
    ) -> tuple[State, Estimate]:
        """Estimate a frame from another state; no backward pass goes beyond it."""
        start = replace(other, is_first=True, colours=current.colours, particles=None)
        return self.step(start, cloud, recorder)

    def _estimate(
        self, before: State, predicted: Prediction, found: Posterior, state: State
    ) -> Estimate:
        """State what was found, in the `state` after the step."""
        learned, surface = predicted.learned, found.surface
        P0 = found.P0 if learned is None else found.P0 + learned
        prior = None if before.is_first else Prior(P0, found.carried)
        weight = surface.weight
        squared = float(weight @ surface.distance**2) / max(float(weight.sum()), 1e-12)
        squared = squared if len(weight) else float("nan")
        return Estimate(
            tracked=True,
            reason="",
            pose=state.pose,
            x=state_of_pose(state.pose, self.setup.joints),
            P=state.P.copy(),
            residual=float(np.sqrt(squared)),
            innovation=found.innovation,
            correspondences=surface.pairs(),
            prior=prior,
        )


@dataclass(frozen=True, eq=False)
class _Corrected(Belief):
    """A corrected pose, and the pairs of points that it was corrected by."""

    surface: SurfaceResidual


class IteratedEstimator(Estimator):
    """Iterated posterior linearisation of the distances, and an arm search; keeps nothing."""

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

        Position, rotation and every joint are judged alone by the distance moved over its expected
        value: still limbs are held still, and nothing that moves fast is held back.
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
