"""Joint angles over the frames of a run or of a reference, each with its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.reference import MAX_SIGMA, Reference
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.skeleton import CLAVICLES, HEAD, LIMB_OF_PART, PARTS
from stereotrack_core.evaluation.joint_angles.definitions import (
    ANGLES,
    NAMES,
    angles_of_landmarks,
    raw_angles,
    wrapped,
)
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.estimate import overconfidence
from stereotrack_core.tracking.frame import Run, joints_named
from stereotrack_core.tracking.stored import body_of_run, upright_run


@dataclass(frozen=True, eq=False)
class JointAngles:
    """Angles over frames; F frames, A angles in the order of :data:`ANGLES`."""

    frame: IntArray
    """(F,). Ascending."""
    angle: FloatArray
    """(F, A), radians. Unwrapped; NaN where not known or not defined."""
    sigma: FloatArray
    """(F, A), radians. Standard deviation; NaN where nothing states it."""

    def between(self, first: int, end: int) -> JointAngles:
        """The frames of a half-open stretch."""
        inside = (self.frame >= first) & (self.frame < end)
        return JointAngles(self.frame[inside], self.angle[inside], self.sigma[inside])


def angles_of_trajectory(
    trajectory: LandmarkTrajectory, sigma: FloatArray | None = None
) -> JointAngles:
    """Angles of landmarks, of which `sigma` (F, A) says how good they are, if anything does."""
    angle = unwrapped(trajectory.frame, angles_of_landmarks(trajectory.points))
    stated = np.full_like(angle, np.nan) if sigma is None else sigma
    return JointAngles(trajectory.frame, angle, np.where(np.isnan(angle), np.nan, stated))


def angles_of_run(run: Run) -> JointAngles:
    """Angles of a run, uncertain as its covariances say; see :func:`sigma_of_run`.

    Against the vertical of the run's world, whichever of its axes that is. The head's are not known
    where the run does not track it.
    """
    run = upright_run(run)
    found = angles_of_trajectory(run.trajectory(), sigma_of_run(run))
    if f"{PARTS[HEAD]}_alpha" in run.state_names:
        return found
    tracked = np.array([angle.joint != "head" for angle in ANGLES])
    angle, sigma = (np.where(tracked, values, np.nan) for values in (found.angle, found.sigma))
    return JointAngles(found.frame, angle, sigma)


def angles_of_reference(reference: Reference, max_sigma: float = MAX_SIGMA) -> JointAngles:
    """Angles of the landmarks that are known within a standard deviation, in metres.

    Uncertain as the landmarks are; see :func:`sigma_of_reference`.
    """
    known = reference.within(max_sigma)
    return angles_of_trajectory(known.trajectory(np.inf), sigma_of_reference(known))


def unwrapped(frame: IntArray, angle: FloatArray) -> FloatArray:
    """Take away jumps by whole turns.

    Over successive frames an angle goes the short way round. Where it is not known for some
    frames, it begins anew in the range of one turn that its definition states; only turns of the
    torso are counted on, to the value nearest to the last one. More than half a turn between two
    frames cannot be told from less than half a turn the other way.

    Parameters
    ----------
    frame : (F,) int64
    angle : (F, A) float64, radians
        In any range.
    """
    result = angle.copy()
    for column, definition in enumerate(ANGLES):
        if definition.lowest is not None:
            result[:, column] = _unwrapped(
                frame, angle[:, column], definition.lowest, continues=definition.continues
            )
    return result


def _unwrapped(frame: IntArray, angle: FloatArray, lowest: float, *, continues: bool) -> FloatArray:
    result: FloatArray = np.full_like(angle, np.nan)
    last = np.nan
    for stretch in stretches(frame, np.isfinite(angle)):
        values = np.unwrap(angle[stretch])
        begin = last - np.pi if continues and np.isfinite(last) else lowest
        result[stretch] = values - 2.0 * np.pi * np.floor((values[0] - begin) / (2.0 * np.pi))
        last = result[stretch][-1]
    return result


def stretches(frame: IntArray, known: BoolArray) -> list[slice]:
    """Places of successive frames (F,) that are all known (F,), as slices."""
    places = np.flatnonzero(known)
    if not len(places):
        return []
    follows = (np.diff(places) == 1) & (np.diff(frame[places]) == 1)
    ends = [0, *(np.flatnonzero(~follows) + 1), len(places)]
    return [slice(int(places[a]), int(places[b - 1]) + 1) for a, b in pairwise(ends)]


_OF_INTEREST = (*THESIS_JOINTS, HEAD, *CLAVICLES)


_USUAL_VIEWS = 4
"""Views of a run that does not name them."""


def sigma_of_run(run: Run) -> FloatArray:
    """Standard deviations (F, A) in radians of the joint angles of a run.

    From its covariances times the squares of :func:`overconfidence`, as the limbs' own standard
    deviations are stated. NaN in frames that are not tracked, and throughout where the states are
    not those of a body.
    """
    result: FloatArray = np.full((len(run.frame), len(NAMES)), np.nan)
    joints = joints_named(run.state_names)
    if joints is None:
        return result
    body = body_of_run(run)
    columns, kept = _columns(joints)
    of_limbs = overconfidence(len(run.meta["views"]) if "views" in run.meta else _USUAL_VIEWS)
    factors = np.concatenate([np.full(6, of_limbs[0]), np.repeat(of_limbs[LIMB_OF_PART[kept]], 2)])
    for i in np.flatnonzero(run.tracked):
        P = run.P[i][np.ix_(columns, columns)] * np.outer(factors, factors)
        if np.isfinite(P).all() and np.isfinite(run.x[i]).all():
            result[i] = _sigma(body, run.x[i], joints, P, columns, kept)
    return result


def sigma_of_reference(reference: Reference) -> FloatArray | None:
    """Standard deviations (F, A) in radians by the covariances of a reference's landmarks.

    The errors of different landmarks are taken for independent. Those of a body that was fitted
    as a whole are alike, so that angles are rather better than is said. None where the reference
    does not say how good it is.
    """
    if reference.covariance is None:
        return None
    points = reference.of_the_nine(reference.points)
    total: FloatArray = np.zeros((len(points), len(NAMES)))
    at = raw_angles(points)
    for place, name in enumerate(LANDMARKS):
        if name not in reference.landmark_names:
            continue
        known = reference.covariance[:, reference.landmark_names.index(name)]
        for column in np.moveaxis(_roots(known), -1, 0):
            for sign in (1.0, -1.0):
                moved = points.copy()
                moved[:, place] += sign * column
                total += 0.5 * wrapped(raw_angles(moved) - at) ** 2
    result: FloatArray = np.sqrt(total)
    return result


def _sigma(
    body: BodyModel,
    x: FloatArray,
    joints: tuple[int, ...],
    P: FloatArray,
    columns: list[int],
    kept: list[int],
) -> FloatArray:
    """Standard deviations (A,) of one pose."""
    steps = _roots(P[None])[0].T
    steps = np.concatenate([steps, -steps])
    pose = pose_of_state(x, joints)
    if joints == THESIS_JOINTS:  # its errors are added to the numbers of the state
        delta = np.zeros((len(steps), len(x)))
        delta[:, columns] = steps
        moved = pose_of_state(x + delta, joints)
    else:
        moved = displaced(pose, steps, tuple(kept))
    change = wrapped(raw_angles(landmarks(body, moved)) - raw_angles(landmarks(body, pose)))
    result: FloatArray = np.sqrt(0.5 * np.sum(change**2, axis=0))
    return result


def _columns(joints: tuple[int, ...]) -> tuple[list[int], list[int]]:
    """Numbers of the state that angles depend on, and the parts whose joints are among them."""
    kept = [part for part in joints if part in _OF_INTEREST]
    columns = list(range(6))
    for part in kept:
        first = 6 + 2 * joints.index(part)
        columns += [first, first + 1]
    return columns, kept


def _roots(covariances: FloatArray) -> FloatArray:
    """Matrices L (..., n, n) with L L' = P; NaN for covariances that are not known."""
    known: BoolArray = np.asarray(np.isfinite(covariances).all(axis=(-2, -1)))
    values, vectors = np.linalg.eigh(np.where(known[..., None, None], covariances, 0.0))
    result: FloatArray = vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :]
    result[~known] = np.nan
    return result
