"""Which view shows limbs best: not hidden by the body, and large."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.sampling import segment_blocked
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import body_of_run, pose_of_run

_ALONG = np.linspace(0.15, 0.95, 5)


def best_view(
    recording: Recording, run: Run, frames: Sequence[int], limbs: Sequence[str] = ()
) -> str:
    """Name of the view in which some limbs are seen best; the first one where nothing tells.

    A limb counts with the length at which it appears where it is inside the picture and no other
    part of the body stands before it.

    Parameters
    ----------
    recording : Recording
    run : Run
    frames : sequence of int
    limbs : sequence of str
        Names in ``LIMBS``; both arms where not given.
    """
    wanted = [LIMBS.index(limb) for limb in (limbs or LIMBS[2:])]
    body = body_of_run(run)
    places = [int(i) for i in np.flatnonzero(np.isin(run.frame, np.asarray(frames)))]
    poses = [pose for i in places if (pose := pose_of_run(run, i)) is not None]
    best, most = recording.views[0].name, -1.0
    for view in recording.views:
        camera = recording.reference_camera(view)
        seen = sum(seen_lengths(camera, body, pose)[wanted].sum() for pose in poses)
        if seen > most + 1e-9:
            best, most = view.name, float(seen)
    return best


def seen_lengths(camera: Camera, body: BodyModel, pose: Pose) -> FloatArray:
    """Lengths (6,) in pixels at which a camera sees the limbs' axes, without what is hidden."""
    shares, lengths = seen_shares(camera, body, pose)
    return shares * lengths


def seen_shares(camera: Camera, body: BodyModel, pose: Pose) -> tuple[FloatArray, FloatArray]:
    """Share of each limb's axis (6,), 0 to 1, that nothing hides from a camera, and its length.

    Places outside of the picture count as hidden. Lengths (6,) are in pixels; 0 where the limb is
    not wholly in front of the camera.
    """
    frames = body.frames(pose)
    placed = placed_cones(body, frames)
    shares, lengths = np.zeros(len(LIMBS)), np.zeros(len(LIMBS))
    for limb in range(len(LIMBS)):
        axis = body.skeleton.lengths[limb] * frames.rotations[limb, :, 2]
        places = frames.origins[limb] + _ALONG[:, None] * axis
        pixels = camera.project(places)
        if not np.isfinite(pixels).all():
            continue
        inside = (pixels >= 0).all(axis=1) & (pixels < (camera.width, camera.height)).all(axis=1)
        others = placed[LIMB_OF_PART[body.cones.part] != limb]
        hidden = segment_blocked(places, camera.position_world, others)
        shares[limb] = float((inside & ~hidden).mean())
        lengths[limb] = float(np.linalg.norm(pixels[-1] - pixels[0]))
    return shares, lengths
