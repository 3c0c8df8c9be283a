"""The body's surface, fitted to the measured points of frames whose clicks tell the pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.annotation.fit.movement import pose_sigmas
from stereotrack_core.annotation.fit.stretch import FrameData, Stretch
from stereotrack_core.arrays import IntArray
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_shape

_FRAMES, _FEWEST = 12, 3
"""Frames that the shape is fitted to, and those without which the average one is better."""

_ROUNDS = 6

_NEAR = (0.05, 10.0, 15.0)
"""How far a pose fitted to clicks may be off: metres; degrees of the torso, of a joint."""


def clicked_shape(
    stretch: Stretch,
    data: Sequence[FrameData],
    poses: Sequence[Pose],
    known: IntArray,
    proportions: Proportions,
    shape: BodyParameters,
) -> BodyParameters:
    """Surface and outline of the person; the given one where too few frames show them.

    Parameters
    ----------
    stretch : Stretch
        One that knows depth.
    data : sequence of FrameData
    poses : sequence of Pose
        As fitted to clicks.
    known : (k,) int64
        Frames whose clicks tell the pose and that have depth.
    proportions : Proportions
    shape : BodyParameters
        The average one.
    """
    if len(known) < _FEWEST:
        return shape
    chosen = known[np.linspace(0, len(known) - 1, min(_FRAMES, len(known))).round().astype(int)]
    sigma = pose_sigmas(stretch.freedom, *_NEAR)
    seen = []
    for k in chosen:
        depth = data[k].depth
        assert depth is not None  # noqa: S101 - the caller asked for frames with depth
        found = stretch.fit([data[k]], [poses[k]], poses[k], sigma, rounds=_ROUNDS)
        seen.append(SeenPose(depth.points, found.states[0].pose, depth.edges()))
    parameters, joints = TrackingParameters(), stretch.freedom.joints
    return fitted_shape(proportions, shape, seen, parameters, joints)
