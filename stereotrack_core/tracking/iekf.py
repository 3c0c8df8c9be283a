"""The step of presets ``accurate`` and ``fast``: measured points look for the model, iterated."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.angles import state_of_pose
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.pose import Pose, orthonormal
from stereotrack_core.body.skeleton import ARM_PARTS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.correction import innovation_of
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.failure.features import carried_on, judged
from stereotrack_core.tracking.measurements import Measurements, chosen_data, observations
from stereotrack_core.tracking.part_colours import PartColours
from stereotrack_core.tracking.residuals.detections import predicted_by_detections
from stereotrack_core.tracking.residuals.surface import SurfaceResidual
from stereotrack_core.tracking.state import (
    Belief,
    Particles,
    Setup,
    State,
    elapsed,
    prior_inflation,
)
from stereotrack_core.tracking.step_recorder import StepRecorder

_COARSE = 2  # all iterations but the last use every second datum; the variances make up for it
_WIDE_ITERATIONS = 2
_WIDE_ARM = np.radians(40.0)  # standard deviation of the arms' joints around a proposal


@dataclass(frozen=True, eq=False)
class Corrected(Belief):
    """A corrected pose, and the pairs of points that it was corrected by."""

    surface: SurfaceResidual
    particles: Particles | None = None  # that a baseline leaves for the next frame


# Finds a pose by a frame's measurements, its prediction and the state before, in the place of the
# iterated correction: without arm search and prior inflation.
Baseline: TypeAlias = Callable[[Measurements, Belief, State], tuple[Belief, Particles | None]]


@dataclass(frozen=True, eq=False)
class Follower:
    """Follows a body from cloud to cloud, from a pose that is roughly right.

    Each frame's correction is the iterated posterior linearisation of the distances, and an arm
    search.
    """

    setup: Setup
    uses_colours: bool = False  # whether parts' colours are learned, if they have weight
    uses_async_detections: bool = False  # whether those between frames count
    judges: bool = True  # whether estimates state limb failures, as searches need not
    baseline: Baseline | None = None

    @cached_property
    def search(self) -> ArmSearch:
        """Search for the arms of the body."""
        return ArmSearch(self.setup.body, self.setup.parameters)

    @cached_property
    def _arms(self) -> IntArray:
        """Columns of the arms' joints."""
        first = self.setup.columns.first[ARM_PARTS]
        return np.stack([first, first + 1], axis=1).ravel()

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
        begun, setup = perf_counter(), self.setup
        p, gone = setup.parameters, elapsed(before.time, cloud.frame)
        predicted = self.predicted(before, cloud)
        if recorder is not None:
            recorder.predicted(before, predicted)
        if cloud.view_names and len(cloud.points) < p.least_points:
            return self.lost(before, cloud, f"the cloud has only {len(cloud.points)} points")
        measured = self.measured(before, cloud, recorder)
        found, innovation, prior = self.corrected(measured, predicted, before)
        if measured.unexplained_fraction(found.pose) > p.max_unexplained_fraction:
            return self.lost(before, cloud, "the cloud does not match the body")
        pose = orthonormal(found.pose)
        said = carried_on(before.disagreement, gone / setup.fps, cloud.keypoints, setup.body, pose)
        after = State(pose, found.P, cloud.frame, False, said, before.colours, found.particles)
        # A smoother goes back over the whole prediction: what detections on the way took off the
        # covariance is part of it.
        learned = before.P + gone * setup.Q - predicted.P
        weight, squared = found.surface.weight, float("nan")
        if len(weight):
            squared = float(weight @ found.surface.distance**2) / max(float(weight.sum()), 1e-12)
        estimate = Estimate(
            tracked=True,
            reason="",
            pose=pose,
            x=state_of_pose(pose, setup.joints),
            P=found.P.copy(),
            residual=float(np.sqrt(squared)),
            innovation=innovation,
            correspondences=found.surface.pairs(),
            prior=None if before.is_first else replace(prior, P=prior.P + learned),
            seconds={"track": perf_counter() - begun},
        )
        if not self.judges:
            return after, estimate
        spread = displaced(pose, sigma_deviations(after.P, setup.weights), setup.joints)
        movement = difference(pose, before.pose, setup.joints)
        return after, judged(estimate, cloud, setup, spread, movement, said)

    def predicted(self, state: State, cloud: Cloud) -> Belief:
        """Predict that the body stays; detections on the way to the frame correct it."""
        since = cloud.frame - 1.0 if state.time is None else state.time
        due = [d for d in cloud.detections if since < d.time < cloud.frame]
        used = due if self.uses_async_detections else ()
        return predicted_by_detections(self.setup, state, since, cloud.frame, used)

    def measured(
        self, state: State, cloud: Cloud, recorder: StepRecorder | None = None
    ) -> Measurements:
        """Take from a cloud what poses are measured by."""
        data = chosen_data(self.setup, cloud, state.colours)
        seen = observations(self.setup.parameters, cloud)
        return Measurements(self.setup, cloud, data, state.colours, seen, recorder)

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

    def corrected(
        self, measured: Measurements, predicted: Belief, before: State
    ) -> tuple[Corrected, float, Prior]:
        """Follow the data from the prediction, again where it was too narrow; look for the arms.

        Returns the innovation of the first correction and the prior that was used as well.
        """
        carried = np.ones(len(predicted.P), dtype=np.bool_)
        if self.baseline is not None:
            first = measured.surface(predicted.pose, wide=True)
            belief, particles = self.baseline(measured, predicted, before)
            surface = measured.surface(belief.pose, wide=False)
            found = Corrected(belief.pose, belief.P, surface, particles)
            return found, innovation_of(first, self.setup, predicted), Prior(predicted.P, carried)
        first, found = self.follow(measured, predicted, predicted)
        innovation = innovation_of(first, self.setup, predicted)
        p, prior = self.setup.parameters, predicted
        moved = difference(found.pose, predicted.pose, self.setup.joints)
        factor = prior_inflation(moved, predicted.P, p.prior_inflation_above)
        if np.any(factor > 1.0):
            prior = Belief(predicted.pose, predicted.P * np.outer(factor, factor))
            _, found = self.follow(measured, prior, found)
        searched = p.search_arms and not measured.cloud.clicks
        if searched and (len(measured.data) or measured.cloud.depths):
            followed, found = found, self._with_best_arms(measured, prior, found)
            carried[self._arms] = found is followed
        return found, innovation, Prior(prior.P, carried)

    def follow(
        self, measured: Measurements, prior: Belief, start: Belief
    ) -> tuple[SurfaceResidual, Corrected]:
        """Iterate correspondences and corrections of a prior; returns the first pairs as well."""
        at, surfaces, last = start, [], self.setup.parameters.iterations - 1
        for i in range(last + 1):
            wide, every = i < _WIDE_ITERATIONS, 1 if i == last else _COARSE
            surfaces.append(measured.surface(at.pose, wide=wide, every=every))
            at = measured.corrected(prior, at, surfaces[-1])
        return surfaces[0], Corrected(at.pose, at.P, surfaces[-1])

    def refine(self, measured: Measurements, proposed: Pose, P0: FloatArray) -> Corrected:
        """Correct a proposed pose from a prior that is wide for the arms."""
        P = P0.copy()
        P[self._arms] = P[:, self._arms] = 0.0
        P[self._arms, self._arms] = _WIDE_ARM**2
        at = prior = Belief(proposed, P)
        for i in range(self.setup.parameters.search_iterations):
            wide = i + 1 < _WIDE_ITERATIONS
            surface = measured.surface(at.pose, wide=wide, every=_COARSE)
            at = measured.corrected(prior, at, surface)
        return Corrected(at.pose, at.P, surface)

    def _with_best_arms(
        self, measured: Measurements, prior: Belief, followed: Corrected
    ) -> Corrected:
        """Put the arms elsewhere if both together explain the frame clearly better there."""
        search, trace, rng = self.search, measured.trace, measured.random(1)
        expected, here, best = prior.pose, followed.pose, followed
        tried = list[tuple[Pose, Pose]]()
        evidence = search.evidence(measured.cloud, here, rng)
        least = search.cost(evidence, expected, here) - evidence.gain
        if trace is not None:
            unwatched = replace(measured, trace=None)
            refine = lambda pose: self.refine(unwatched, pose, prior.P).pose  # noqa: E731
            trace.searching(search, evidence, expected, refine)
        tell = None if trace is None else trace.proposed
        for proposed in search.best_pairs(evidence, expected, here, rng, tell):
            found = self.refine(measured, proposed, prior.P)
            tried.append((proposed, found.pose))
            cost = search.cost(evidence, expected, found.pose)
            if cost < least:
                least, best = cost, found
        if trace is not None:
            trace.searched(here, tried, best.pose)
        return best
