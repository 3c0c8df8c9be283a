"""Joint angles as a table for other programs: one row per frame, degrees."""

from __future__ import annotations

import numpy as np

from stereotrack_core.evaluation.joint_angles.definitions import ANGLES
from stereotrack_core.evaluation.joint_angles.motion import Motion
from stereotrack_core.evaluation.joint_angles.series import JointAngles

_QUANTITIES = (
    "deg", "sigma_deg", "smooth_deg", "velocity_deg_s", "velocity_sigma_deg_s",
    "acceleration_deg_s2", "acceleration_sigma_deg_s2",
)  # fmt: skip
_DIGITS = 4


def frame_columns() -> tuple[str, ...]:
    """Headings: ``frame``, ``seconds``, then seven for every angle."""
    names = [f"{angle.name}_{quantity}" for angle in ANGLES for quantity in _QUANTITIES]
    return ("frame", "seconds", *names)


def frame_rows(angles: JointAngles, motion: Motion) -> list[list[str | float | int]]:
    """Rows under :func:`frame_columns`; what is not known is empty.

    Seconds are those since frame 0 of the recording.
    """
    stacked = np.degrees(
        np.stack(
            [
                angles.angle, angles.sigma, motion.angle, motion.velocity, motion.velocity_sigma,
                motion.acceleration, motion.acceleration_sigma,
            ],
            axis=-1,
        )
    ).reshape(len(angles.frame), len(ANGLES) * len(_QUANTITIES))  # fmt: skip
    rows: list[list[str | float | int]] = []
    for frame, values in zip(angles.frame.tolist(), stacked.round(_DIGITS).tolist(), strict=True):
        cells = ["" if np.isnan(value) else value for value in values]
        rows.append([frame, round(frame / motion.fps, 6), *cells])
    return rows
