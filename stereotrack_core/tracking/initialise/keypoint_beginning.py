"""What the first frames of mono views tell before the track begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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

FIRST_FRAMES = 60
"""Frames that are tracked in advance."""

_ASKED, _FEWEST = 24, 6
"""Frames, evenly spread over these, that the shape is fitted to, and without which nothing is."""


@dataclass(frozen=True, eq=False)
class FirstFrames:
    """Shape and pose of the person that the first frames tell."""

    shape: BodyShape
    """The body's, with margins as the contours and offsets as the keypoints show them."""
    pose: Pose | None
    """Of the first frame; None where it is not tracked."""


def told_by_first_frames(
    model: TrackModel, state: TrackState, clouds: Sequence[Cloud], hooks: Hooks
) -> FirstFrames | None:
    """Track the first frames, smooth them, and compare contours and keypoints with the body's.

    None where hardly any frame is tracked.
    """
    body, frames = model.setup.body, list[TrackedFrame]()
    for done, cloud in enumerate(clouds):
        hooks.on_preparing("tracking the first frames", done, len(clouds))
        hooks.before_step()
        state, estimate = step(model, state, cloud)
        places = landmarks(body, estimate.pose)
        frames.append(TrackedFrame(cloud.frame, estimate, places, cloud, {}).without_cloud())
    frames = list(smoothed(frames, model.setup, fit_movement=True).frames)
    known = [i for i, frame in enumerate(frames) if frame.tracked]
    if len(known) < _FEWEST:
        return None
    shape = body.shape
    if model.setup.parameters.fit_shape:
        chosen = np.unique(np.linspace(0, len(known) - 1, _ASKED).astype(int))
        asked = [known[i] for i in chosen]
        poses = [frames[i].estimate.pose for i in asked]
        edges = [edge_maps(clouds[i]) for i in asked]
        shape = fitted_outline(body, tuple(zip(poses, edges, strict=True)))
        if any(edges):  # keypoints alone cannot tell their offsets from other lengths of the body
            setup = replace(model.setup, body=body.with_shape(shape))
            asked_clouds = [clouds[i] for i in asked]
            shape = fitted_offsets(setup, tuple(zip(poses, asked_clouds, strict=True)))
    return FirstFrames(shape, frames[0].estimate.pose if frames[0].tracked else None)
