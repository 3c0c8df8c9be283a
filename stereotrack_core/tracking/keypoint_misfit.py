"""How far the poses of a run are from the keypoints of a detector, in pixels."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, keypoints_in_views
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.stored import body_of_run, pose_of_run


def keypoint_distances(seen: SightedKeypoints | None, body: BodyModel, pose: Pose) -> FloatArray:
    """Distances (m,) in pixels of all keypoints of an instant from the points that they name.

    Sides that a detector has exchanged are exchanged back, as they are in tracking.
    """
    fit = KeypointObservation(seen, 1.0).fitted(body, pose)
    if fit is None:
        return np.empty(0)
    distance = np.linalg.norm(fit.seen.pixel - fit.predicted, axis=2)
    result: FloatArray = distance[np.isfinite(distance)]
    return result


def keypoint_error(run: Run, recording: Recording, keypoints: Keypoints) -> float:
    """Median distance in pixels of the keypoints from a run's poses; NaN where there are none."""
    views = [name for name in run.meta.get("views", ()) if _is_there(recording, name)]
    seen, body = keypoints_in_views(recording, views, keypoints), body_of_run(run)
    found = [
        keypoint_distances(seen.at(frame), body, pose)
        for i, frame in enumerate(run.frame.tolist())
        if (pose := pose_of_run(run, i)) is not None
    ]
    every = np.concatenate(found) if found else np.empty(0)
    return float(np.median(every)) if len(every) else float("nan")


def _is_there(recording: Recording, name: str) -> bool:
    return any(view.name == name for view in recording.views)
