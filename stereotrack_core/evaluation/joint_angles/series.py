"""Joint angles over the frames of a run or of a reference, each with its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.skeleton import HEAD, PARTS
from stereotrack_core.evaluation.joint_angles.definitions import ANGLES, NAMES
from stereotrack_core.evaluation.joint_angles.geometry import angles_of_landmarks
from stereotrack_core.evaluation.joint_angles.uncertainty import sigma_of_reference, sigma_of_run
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.frame import Run


@dataclass(frozen=True, eq=False)
class JointAngles:
    """Angles over frames; F frames, A angles in the order of :data:`ANGLES`.

    Attributes
    ----------
    frame : (F,) int64
        Ascending.
    angle : (F, A) float64, radians
        Unwrapped; NaN where not known or not defined.
    sigma : (F, A) float64, radians
        Standard deviation; NaN where nothing states it.
    """

    frame: IntArray
    angle: FloatArray
    sigma: FloatArray

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

    The head's are not known where the run does not track it.
    """
    found = angles_of_trajectory(run.trajectory(), sigma_of_run(run))
    if f"{PARTS[HEAD]}_alpha" in run.state_names:
        return found
    tracked = np.array([angle.joint != "head" for angle in ANGLES])
    angle, sigma = (np.where(tracked, values, np.nan) for values in (found.angle, found.sigma))
    return JointAngles(found.frame, angle, sigma)


def angles_of_reference(reference: Reference) -> JointAngles:
    """Angles of a reference, uncertain as its landmarks are; see :func:`sigma_of_reference`."""
    return angles_of_trajectory(reference.trajectory(), sigma_of_reference(reference))


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


def column(angles: FloatArray, name: str) -> FloatArray:
    """One angle (F,) of an array (F, A)."""
    result: FloatArray = angles[:, NAMES.index(name)]
    return result
