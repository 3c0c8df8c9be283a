"""What a pair of cameras side by side is worth as a stereo camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera


@dataclass(frozen=True)
class Pair:
    """A stereo camera: base line in metres, angle between the axes in degrees, errors across rows.

    `row_error_px`: root mean square difference of the rows on which both rectified images would
    show a corner; `corners` is their number.
    """

    left: str
    right: str
    baseline_m: float
    convergence_deg: float
    row_error_px: float
    corners: int


def pair_of(left: Camera, right: Camera, of_left: Sightings, of_right: Sightings) -> Pair:
    """Measure a stereo camera by the corners that both of its cameras saw.

    Raises InputError where left and right are exchanged.
    """
    offset = right.camera_from_world.apply(left.position_world)
    baseline = float(np.linalg.norm(offset))
    if offset[0] > 0.5 * baseline:
        raise InputError(
            f"left and right are exchanged: {left.name} stands to the right of {right.name}",
            where="--left and --right",
            remedy="Exchange the two, as seen from behind the camera.",
        )
    x = (right.position_world - left.position_world) / max(baseline, 1e-12)
    axes = np.array([one.camera_from_world.rotation[2] for one in (left, right)])
    y = np.cross(axes.sum(axis=0), x)
    y /= np.linalg.norm(y)
    rectified_from_world = np.stack([x, y, np.cross(x, y)])
    common = np.intersect1d(of_left.frames, of_right.frames)
    rows = []
    for camera, seen in ((left, of_left), (right, of_right)):
        pixels = seen.pixels[np.isin(seen.frames, common)]
        directions = camera.rays_world(pixels) @ rectified_from_world.T
        rows.append(directions[..., 1] / directions[..., 2])
    off = 0.5 * (left.focal + right.focal) * (rows[1] - rows[0])
    off = off[np.isfinite(off)]
    error = float(np.sqrt(np.mean(np.square(off)))) if off.size else float("nan")
    angle = float(np.degrees(np.arccos(np.clip(axes[0] @ axes[1], -1.0, 1.0))))
    return Pair(left.name, right.name, baseline, angle, error, int(off.size))
