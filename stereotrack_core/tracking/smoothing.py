"""Rauch-Tung-Striebel smoothing of tracked frames, on the manifold too (docs/method.md 4.13)."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose, orthonormal
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.filtering.smoothing import Walk, backward_step, smooth_uneven
from stereotrack_core.tracking.estimate import Estimate, Prior, limb_sigma_deg, overconfidence
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.state import Setup, prior_inflation

_ARMS = (slice(6, 10), slice(10, 14))  # numbers of each arm in the states of both trackers
_JUMP = np.pi / 2  # change of an arm's angles between two frames that is another chart


@dataclass(frozen=True)
class ErrorState:
    """How estimates differ and how they are displaced: the error states of :mod:`body.manifold`.

    The covariance is taken as it is from pose to pose; that leaves out half of the turn between
    them, as the tracker's own correction does. The thesis's Euler angles differ number by number.
    """

    joints: tuple[int, ...]  # parts whose two numbers follow position and rotation

    @property
    def of_angles(self) -> bool:
        """Whether the state is the thesis's."""
        return self.joints == THESIS_JOINTS

    def difference(self, to: Estimate, origin: Estimate) -> FloatArray:
        """Error state (n,) that displaces `origin` to `to`; angles by the short way round."""
        if not self.of_angles:
            return difference(to.pose, origin.pose, self.joints)
        delta = to.x - origin.x
        delta[3:] = np.arctan2(np.sin(delta[3:]), np.cos(delta[3:]))
        return delta

    def displaced(self, at: Estimate, delta: FloatArray) -> Estimate:
        """The estimate with its pose and state displaced."""
        if self.of_angles:
            return replace(at, pose=self.poses(at, delta), x=at.x + delta)
        pose = orthonormal(self.poses(at, delta))
        return replace(at, pose=pose, x=state_of_pose(pose, self.joints))

    def poses(self, at: Estimate, deltas: FloatArray) -> Pose:
        """Pose, or stacked poses, of displacements (n,) or (S, n)."""
        if self.of_angles:
            return pose_of_state(at.x + deltas, self.joints)
        return displaced(at.pose, deltas, self.joints)

    def continuous(self, delta: FloatArray) -> BoolArray:
        """Numbers (n,) whose change from frame to frame can be a movement.

        Arms' angles can jump: the thesis's tracker restates them when it avoids collisions.
        """
        kept = np.ones(len(delta), dtype=np.bool_)
        for arm in _ARMS if self.of_angles else ():
            kept[arm] = np.all(np.abs(delta[arm]) < _JUMP)
        return kept


def smoothed(
    frames: Sequence[TrackedFrame], setup: Setup, *, fit_movement: bool = False
) -> list[TrackedFrame]:
    """Go backwards over successive frames of a tracker; their clouds are not needed.

    What is said of residuals and lost limbs remains the forward pass's; of untracked frames in a
    gap that was bridged it is NaN.

    `fit_movement`: estimate from all frames how much the body moves, and when, instead of taking
    the parameters' process noise. It helps where a frame's measurements are few and uncertain.
    """
    begun, state = time.perf_counter(), ErrorState(setup.joints)
    way = _fitting_movement if fit_movement else _backwards
    found = way([frame.estimate for frame in frames], state, setup)
    spent, made = (time.perf_counter() - begun) / max(len(frames), 1), []
    for frame, estimate in zip(frames, found, strict=True):
        places = frame.landmarks
        if estimate.tracked:
            spread = state.poses(estimate, sigma_deviations(estimate.P, setup.weights))
            sigma = limb_sigma_deg(setup.body.frames(spread), setup.weights.covariance)
            sigma = overconfidence(len(setup.cameras)) * sigma
            estimate = replace(estimate, limb_sigma_deg=sigma)
            places = landmarks(setup.body, estimate.pose)
        seconds = {**frame.seconds, "smooth": spent}
        made.append(replace(frame, estimate=estimate, landmarks=places, seconds=seconds))
    return made


def _backwards(estimates: list[Estimate], state: ErrorState, setup: Setup) -> list[Estimate]:
    """Smooth each stretch that hangs together, the last one first."""
    found, p = list(estimates), setup.parameters
    longest = int(p.longest_bridge * setup.fps + 1e-9)
    tracked = [i for i, estimate in enumerate(estimates) if estimate.tracked]
    for first, k in reversed(list(pairwise(tracked))):
        before, prior = estimates[first], estimates[k].prior
        if k == first + 1:
            if prior is not None:
                prior, found[k] = _stayed(before, prior, found[k], state, p.prior_inflation_above)
                found[first] = _one_back(before, prior, found[k], state)
        elif k - first - 1 <= longest:
            _bridge(found, first, k, state, setup)
    return found


def _one_back(filtered: Estimate, prior: Prior, after: Estimate, state: ErrorState) -> Estimate:
    """Smooth a frame by the smoothed frame after it."""
    ahead = state.difference(after, filtered)
    carried = prior.carried & state.continuous(ahead)
    gain, P = backward_step(filtered.P, prior.P, carried, after.P)
    return replace(state.displaced(filtered, gain @ ahead), P=P)


def _stayed(
    filtered: Estimate, prior: Prior, after: Estimate, state: ErrorState, inflated_above: float
) -> tuple[Prior, Estimate]:
    """Carry over arms that were looked for anew and found where expected: adds the prior."""
    if prior.carried.all():
        return prior, after
    behind = state.difference(filtered, after)
    squared = behind**2 / np.diagonal(prior.P)
    anew = np.zeros(len(behind), dtype=np.bool_)
    for arm in _ARMS:
        anew[arm] = not prior.carried[arm].all() and squared[arm].mean() < inflated_above**2
    if not anew.any():
        return prior, after
    prior, expected = replace(prior, carried=prior.carried | anew), np.zeros_like(prior.P)
    # what the carried part of the prior says beyond what was used of it
    for part, sign in ((prior.carried, 1.0), (prior.carried & ~anew, -1.0)):
        block = np.ix_(part, part)
        expected[block] += sign * scipy.linalg.inv(prior.P[block])
    expected = 0.5 * (expected + expected.T)
    known = Information(scipy.linalg.inv(after.P), np.zeros(len(behind)))
    dx, P = posterior(expected, behind, known)
    return prior, replace(state.displaced(after, dx), P=P)


def _bridge(found: list[Estimate], first: int, k: int, state: ErrorState, setup: Setup) -> None:
    """Fill the frames between `first` and `k`, and smooth `first`, by a random walk."""
    before, steps, Q = found[first], k - first, setup.Q
    moved = state.difference(found[k], before)
    if not np.all(state.continuous(moved)):
        return
    above = setup.parameters.prior_inflation_above
    factor = prior_inflation(moved, before.P + steps * Q, above)
    noise = Q * np.outer(factor, factor)
    everything = np.ones(len(Q), dtype=np.bool_)
    if found[k].prior is None:  # it was found without what was known before the gap
        known = Information(scipy.linalg.inv(found[k].P), np.zeros(len(Q)))
        predicted = scipy.linalg.inv(before.P + steps * noise)
        dx, P = posterior(predicted, state.difference(before, found[k]), known)
        found[k] = replace(state.displaced(found[k], dx), P=P)
    for i in reversed(range(steps)):
        waiting = replace(before, P=before.P + i * noise)
        prior = Prior(before.P + (i + 1) * noise, everything)
        back = _one_back(waiting, prior, found[first + i + 1], state)
        found[first + i] = back if i == 0 else _as_bridge(back)


_ANYWHERE = 100.0  # variance, square metres and radians, of a stretch's first frame


def _fitting_movement(estimates: list[Estimate], state: ErrorState, setup: Setup) -> list[Estimate]:
    """Smooth each stretch with steps that are as large as its frames show."""
    found, stretch = list(estimates), list[int]()
    longest = int(setup.parameters.longest_bridge * setup.fps + 1e-9)
    tracked = [i for i, estimate in enumerate(estimates) if estimate.tracked]
    for i, following in zip(tracked, [*tracked[1:], None], strict=False):
        stretch.append(i)
        if following is None or following - i - 1 > longest:
            frames = range(stretch[0], i + 1)
            found[frames.start : frames.stop] = _moving(estimates, frames, state, setup)
            stretch = []
    return found


def _moving(
    estimates: list[Estimate], frames: range, state: ErrorState, setup: Setup
) -> list[Estimate]:
    """Smooth one stretch, which begins and ends with frames that are tracked."""
    measured = [_measured(estimates, i, state) for i in frames]
    if not any(seen.A.any() for seen in measured):
        return [estimates[i] for i in frames]
    points: list[Estimate] = []
    for i in frames:
        points.append(estimates[i] if estimates[i].tracked else points[-1])
    Q, n = np.diagonal(setup.Q), len(setup.Q)
    c = np.array([state.difference(a, b) for a, b in pairwise(points)]).reshape(-1, n)
    walk = Walk(np.eye(n), c, np.tile(Q, (len(c), 1)), np.zeros(n), _ANYWHERE * np.eye(n))
    group: IntArray = np.repeat(np.arange(2 + (n - 6) // 2), [3, 3] + [2] * ((n - 6) // 2))
    smooth = smooth_uneven(walk, measured, group)
    result = []
    for i, point, delta, P in zip(frames, points, smooth.mean, smooth.P, strict=True):
        moved = replace(state.displaced(point, delta), P=P)
        result.append(moved if estimates[i].tracked else _as_bridge(moved))
    return result


def _measured(estimates: list[Estimate], i: int, state: ErrorState) -> Information:
    """What a frame's measurements alone said about its pose, seen from that.

    A frame in which the pose was found anew says nothing: it may be far off, and what has corrected
    it is in the frames after it. Arms that were looked for anew were not predicted.
    """
    estimate, n = estimates[i], len(estimates[i].P)
    if not estimate.tracked or estimate.prior is None or not i:
        return Information(np.zeros((n, n)), np.zeros(n))
    expected, predicted = np.zeros((n, n)), np.ix_(estimate.prior.carried, estimate.prior.carried)
    expected[predicted] = scipy.linalg.inv(estimate.prior.P[predicted])
    values, vectors = np.linalg.eigh(scipy.linalg.inv(estimate.P) - expected)
    A: FloatArray = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return Information(A, expected @ state.difference(estimate, estimates[i - 1]))


def _as_bridge(estimate: Estimate) -> Estimate:
    unknown = float("nan")
    return replace(
        estimate,
        reason="",
        unexplained_fraction=unknown,
        residual=unknown,
        innovation=unknown,
        correspondences=None,
        prior=None,
        limb_lost=np.full_like(estimate.limb_lost, unknown),
        limb_features=None,
    )
