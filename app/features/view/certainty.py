"""Where hands and elbows may be, by the tracker's own covariance."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import TrackedFrame

from ...session.runs import RunEntry
from ...widgets.scene.content import Ellipsoid
from ...widgets.style.limb_colours import LANDMARK_LIMBS

SHOWN = ("left_elbow", "right_elbow", "left_hand", "right_hand")
_STEP = 1e-4


def ellipsoids_of(entry: RunEntry, tracked: TrackedFrame) -> tuple[Ellipsoid, ...]:
    """Covariances of the landmarks in :data:`SHOWN`, to first order.

    Nothing where the frame has no pose or its covariance is not known.
    """
    pose, covariance = tracked.pose, tracked.P
    if pose is None or not np.isfinite(covariance).all():
        return ()
    steps = _STEP * np.eye(len(covariance))
    ahead = landmarks(entry.body, _moved(entry, tracked, pose, steps))
    behind = landmarks(entry.body, _moved(entry, tracked, pose, -steps))
    slopes = (ahead - behind) / (2.0 * _STEP)
    places = landmarks(entry.body, pose)
    result = []
    for name in SHOWN:
        at = LANDMARKS.index(name)
        J = slopes[:, at].T
        result.append(Ellipsoid(LANDMARK_LIMBS[name], places[at], J @ covariance @ J.T))
    return tuple(result)


def _moved(entry: RunEntry, tracked: TrackedFrame, pose: Pose, delta: FloatArray) -> Pose:
    """Poses after errors (k, n), which the thesis's state adds to its angles."""
    if delta.shape[-1] == 6 + 2 * len(THESIS_JOINTS):
        return pose_of_state(tracked.x + delta, THESIS_JOINTS)
    return displaced(pose, delta, entry.body.joints)
