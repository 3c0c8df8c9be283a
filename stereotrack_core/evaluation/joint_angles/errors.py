"""How far joint angles are off those of a reference, and whether they say so themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.evaluation.joint_angles.definitions import ANGLES, AngleDefinition
from stereotrack_core.evaluation.joint_angles.geometry import wrapped
from stereotrack_core.evaluation.joint_angles.series import JointAngles


@dataclass(frozen=True)
class AngleError:
    """Errors of one angle over frames; NaN where nothing could be compared.

    Attributes
    ----------
    angle : AngleDefinition
    frames : int
        Frames in which both know the angle.
    bias, median, rms, p95 : float, radians
        Mean error with its sign; median, root mean square and 95th percentile of its size.
    sigma : float, radians
        Root mean square of what is stated.
    within : float
        Share (0 to 1) of the errors within two stated standard deviations; NaN where none is
        stated. Of a normal distribution 0.95 are.
    """

    angle: AngleDefinition
    frames: int
    bias: float
    median: float
    rms: float
    p95: float
    sigma: float
    within: float


def angle_errors(found: JointAngles, truth: JointAngles) -> tuple[AngleError, ...]:
    """Errors in the frames that both have, in the order of :data:`ANGLES`.

    What a reference states about itself adds to what the run states.
    """
    _, own, other = np.intersect1d(found.frame, truth.frame, return_indices=True)
    errors = wrapped(found.angle[own] - truth.angle[other])
    sigma = np.hypot(found.sigma[own], np.nan_to_num(truth.sigma[other]))
    result = []
    for k, definition in enumerate(ANGLES):
        known = np.isfinite(errors[:, k])
        error, stated = errors[known, k], sigma[known, k]
        nan = float("nan")
        if not len(error):
            result.append(AngleError(definition, 0, nan, nan, nan, nan, nan, nan))
            continue
        size = np.abs(error)
        says = np.isfinite(stated)
        result.append(
            AngleError(
                definition,
                frames=len(error),
                bias=float(error.mean()),
                median=float(np.median(size)),
                rms=float(np.sqrt(np.mean(size**2))),
                p95=float(np.percentile(size, 95)),
                sigma=float(np.sqrt(np.mean(stated[says] ** 2))) if says.any() else nan,
                within=float(np.mean(size[says] <= 2.0 * stated[says])) if says.any() else nan,
            )
        )
    return tuple(result)
