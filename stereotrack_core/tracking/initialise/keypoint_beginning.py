"""What the first frames of mono views tell before the track begins."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereotrack_core.body.model import landmarks
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.keypoint_offsets import fitted_offsets
from stereotrack_core.tracking.model import TrackModel, TrackState, step
from stereotrack_core.tracking.residuals.silhouette import edge_maps
from stereotrack_core.tracking.run_spec import Hooks
from stereotrack_core.tracking.shape_fit import fitted_outline
from stereotrack_core.tracking.smoothing import smoothed

FIRST_FRAMES = 60  # frames that are tracked in advance
_ASKED = 24  # frames, evenly spread over these, that the shape is fitted to
_FEWEST = 6  # tracked frames without which nothing is fitted


def told_by_first_frames(
    model: TrackModel, state: TrackState, clouds: Sequence[Cloud], hooks: Hooks
) -> tuple[BodyShape, Pose | None]:
    """Track the first frames, smooth them, and compare contours and keypoints with the body's.

    Gives the shape, with margins as the contours and offsets as the keypoints show them, and the
    pose of the first frame. The shape is the body's own, and there is no pose, where hardly any
    frame is tracked.
    """
    body, frames = model.setup.body, list[TrackedFrame]()
    for done, cloud in enumerate(clouds):
        hooks.on_preparing("tracking the first frames", done, len(clouds))
        hooks.before_step()
        state, estimate = step(model, state, cloud)
        places = landmarks(body, estimate.pose)
        frames.append(TrackedFrame(cloud.frame, estimate, places, cloud, {}).without_cloud())
    frames = smoothed(frames, model.setup, fit_movement=True)
    known = [i for i, frame in enumerate(frames) if frame.tracked]
    shape = body.shape
    if len(known) < _FEWEST:
        return shape, None
    if model.setup.parameters.fit_shape:
        chosen = np.unique(np.linspace(0, len(known) - 1, _ASKED).astype(int))
        asked = [(frames[known[i]].estimate.pose, clouds[known[i]]) for i in chosen]
        edges = [(pose, edge_maps(cloud)) for pose, cloud in asked]
        shape = fitted_outline(body, edges)
        if any(own for _, own in edges):  # else offsets look like other lengths of the body
            shape = fitted_offsets(replace(model.setup, body=body.with_shape(shape)), asked)
    return shape, frames[0].estimate.pose if frames[0].tracked else None
