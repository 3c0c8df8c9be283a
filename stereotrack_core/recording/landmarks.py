"""The nine landmarks and trajectories of them."""

from __future__ import annotations

from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray, IntArray

LANDMARKS: tuple[str, ...] = (
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_hand",
    "right_hand",
    "head",
    "left_hip",
    "right_hip",
)
"""Left and right are the person's own. Every array of landmarks has this order."""

SKELETON: tuple[tuple[str, str], ...] = (
    ("left_hip", "right_hip"),
    ("left_hip", "left_shoulder"),
    ("right_hip", "right_shoulder"),
    ("left_shoulder", "right_shoulder"),
    ("left_shoulder", "left_elbow"),
    ("left_elbow", "left_hand"),
    ("right_shoulder", "right_elbow"),
    ("right_elbow", "right_hand"),
)
"""Lines to draw between landmarks (the head is drawn from the shoulder midpoint)."""


@dataclass(frozen=True, eq=False)
class LandmarkTrajectory:
    """Landmarks over frames: a reference, or what a run found.

    Attributes
    ----------
    frame : (F,) int64
        Frame numbers of the recording, ascending; need not be contiguous.
    points : (F, 9, 3) float64, world, metres
        In the order of :data:`LANDMARKS`; NaN where not known.
    """

    frame: IntArray
    points: FloatArray
