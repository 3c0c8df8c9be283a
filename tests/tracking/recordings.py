"""Tiny recordings of depth images whose truth is known: rays cast on the cones of a body."""

import numpy as np

from stereotrack_core.body.model import landmarks, placed_cones
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, Stream, Subject, View
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.images import counts_of
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description
from stereotrack_core.tracking.presets import preset
from tests.oracle.occlusion import solids_of
from tests.tracking.scenes import CAMERAS
from tests.tracking.views import looking

SMALL = preset("fast").replaced(pixel_step=1, speckle_size=0, search_arms=False, data_points=400)
"""Settings for images as small as these."""

WIDTH, HEIGHT, FOCAL = 128, 104, 125.0
VIEWS = ("N", "O", "S", "W")
UNIT = 0.0005
"""Metres per count."""


def camera_towards_the_middle(name, position) -> Camera:
    """Camera at `position` that looks at a point 1 m above the middle of the room."""
    matrix = np.array(
        [[FOCAL, 0, (WIDTH - 1) / 2], [0, FOCAL, (HEIGHT - 1) / 2], [0, 0, 1.0]], dtype=float
    )
    transform = looking(position, (0.0, 0.0, 1.0)).inverse()
    return Camera(name, WIDTH, HEIGHT, matrix, np.zeros(4), False, transform)


def rendered_depth(body, pose, camera):
    """Depth along the camera's z (H, W) in metres, NaN beside the body."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack(
        [(u - camera.matrix[0, 2]) / FOCAL, (v - camera.matrix[1, 2]) / FOCAL, np.ones_like(u)],
        axis=-1,
    )
    start = camera.position_world
    direction = rays.reshape(-1, 3) @ camera.camera_from_world.rotation
    nearest = np.full(len(direction), np.inf)
    for turn, origin, r1, r2, height, s in solids_of(placed_cones(body, body.frames(pose))):
        flatten = np.array([1.0, 1.0 / s, 1.0])
        p, d = (start - origin) @ turn * flatten, direction @ turn * flatten
        slope = (r2 - r1) / height
        # |p + t d|^2 across the axis equals (r1 + slope z)^2
        a = d[:, 0] ** 2 + d[:, 1] ** 2 - (slope * d[:, 2]) ** 2
        b = p[0] * d[:, 0] + p[1] * d[:, 1] - slope * d[:, 2] * (r1 + slope * p[2])
        c = p[0] ** 2 + p[1] ** 2 - (r1 + slope * p[2]) ** 2
        inside = b**2 - a * c
        t = (-b - np.sqrt(np.maximum(inside, 0.0))) / a
        z = p[2] + t * d[:, 2]
        hit = (inside > 0) & (t > 0) & (z >= 0) & (z <= height)
        nearest = np.where(hit, np.minimum(nearest, t), nearest)
    return np.where(np.isfinite(nearest), nearest, np.nan).reshape(HEIGHT, WIDTH)


def write_depth_recording(folder, body, poses, *, fps=10.0, missing=()) -> Recording:
    """Recording with four depth views and a reference; `missing` frames show nothing."""
    cameras = [
        camera_towards_the_middle(name, position)
        for name, position in zip(VIEWS, CAMERAS, strict=True)
    ]
    points = np.array([landmarks(body, pose) for pose in poses])
    recording = Recording(
        folder,
        "cones",
        fps,
        tuple(_view(camera.name) for camera in cameras),
        {camera.name: camera for camera in cameras},
        subject=Subject("P", **vars(body.skeleton.proportions)),
        reference=LandmarkTrajectory(np.arange(len(poses)), points),
    )
    write_recording_description(recording)
    for camera in cameras:
        for kind in ("", "_depth", "_mask"):
            (folder / f"{camera.name}{kind}").mkdir()
        for k, pose in enumerate(poses):
            depth = rendered_depth(body, pose, camera).astype(np.float32)
            if k in missing:
                depth[:] = np.nan
            _write_frame(folder, camera.name, k, depth)
    return open_recording(folder)


def _view(name) -> View:
    return View(
        name,
        "depth",
        Stream(name, f"{name}/%04d.png"),
        depth=Stream(name, f"{name}_depth/%04d.png"),
        depth_unit=UNIT,
        mask=Stream("", f"{name}_mask/%04d.png"),
    )


def _write_frame(folder, name, k, depth):
    seen, file = np.isfinite(depth), f"{k:04d}.png"
    write_png(folder / name / file, np.where(seen, 200, 90).astype(np.uint8))
    write_png(folder / f"{name}_depth" / file, counts_of(depth, UNIT))
    write_png(folder / f"{name}_mask" / file, seen)
