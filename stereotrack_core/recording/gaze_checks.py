"""Do the cameras look at one place, with the world's z up in their images?"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.finding import Finding

CALIBRATION = "calibration.toml"

LEAST_VIEWS = 3
"""With fewer nobody can tell which one is wrong."""

STEEP = 0.85
"""Cosine to the vertical above which a camera has no upright."""

LEAST_UPRIGHT = 0.5
"""Cosine between up in the image and the world's z, seen in the image."""

MARGIN = 0.5
"""Of the image size, by which the common centre may miss the image."""


def view_cameras(recording: Recording) -> dict[str, Camera]:
    """Reference camera by view name, for views whose camera is known."""
    return {
        view.name: recording.cameras[view.image.camera]
        for view in recording.views
        if view.image.camera in recording.cameras
    }


def check_gaze(recording: Recording) -> Generator[Finding, None, bool]:
    """Findings about rotations; the generator's value says whether the whole rig is wrong."""
    cameras = view_cameras(recording)
    turns = {view.name: view.display_rotation for view in recording.views}
    if len(cameras) < LEAST_VIEWS:
        return False
    misfits = _misfits(cameras, turns)
    if len(misfits) > len(cameras) // 2 or _at_one_place(cameras):
        for way, change in WAYS.items():
            changed = {name: change(camera) for name, camera in cameras.items()}
            if not _at_one_place(changed) and not _misfits(changed, turns):
                yield Finding(
                    "error",
                    f"{CALIBRATION}, rotation and translation",
                    f"the cameras only look at a common place, upright, if they are {way}",
                    "They must map the world to the camera: x_camera = R x_world + t.",
                )
                return True
    for name, what in misfits.items():
        camera = cameras[name]
        fits = [w for w, c in WAYS.items() if not _misfits({**cameras, name: c(camera)}, turns)]
        yield Finding(
            "warning",
            f"{CALIBRATION}, camera {camera.name}, rotation",
            f"view {name} {what}",
            f"It would fit if it were {fits[0]}: x_camera = R x_world + t."
            if fits
            else "Check its rotation and translation (x_camera = R x_world + t) and its"
            " display_rotation.",
        )
    return False


def _transposed(camera: Camera) -> Camera:
    old = camera.camera_from_world
    return replace(camera, camera_from_world=RigidTransform(old.rotation.T, old.translation))


def _inverted(camera: Camera) -> Camera:
    return replace(camera, camera_from_world=camera.camera_from_world.inverse())


WAYS: dict[str, Callable[[Camera], Camera]] = {
    "transposed (rotations only)": _transposed,
    "inverted": _inverted,
}
"""Mistakes of conversion that are seen often."""


def _at_one_place(cameras: Mapping[str, Camera]) -> bool:
    places = np.array([camera.position_world for camera in cameras.values()])
    size = float(np.linalg.norm(places, axis=1).max())
    return bool(np.ptp(places, axis=0).max() < 0.02 * max(size, 1e-9))


def _misfits(cameras: Mapping[str, Camera], turns: Mapping[str, int]) -> dict[str, str]:
    """What is wrong with views that do not fit the others, by view name."""
    found = {}
    for name, camera in cameras.items():
        others = {other: c for other, c in cameras.items() if other != name}
        if not _shows(camera, common_centre(cameras)) and not _shows(camera, common_centre(others)):
            found[name] = "does not look towards the place that the other views look at"
        elif not _is_upright(camera, turns[name]):
            found[name] = "is not upright: the world's z does not point up in its image"
    return found


def common_centre(cameras: Mapping[str, Camera]) -> FloatArray:
    """Place (3,) that the optical axes of most pairs of cameras come near; NaN where none."""
    meetings = []
    for a, b in combinations(cameras.values(), 2):
        origins = np.array([a.position_world, b.position_world])
        axes = np.array([a.camera_from_world.rotation[2], b.camera_from_world.rotation[2]])
        if abs(axes[0] @ axes[1]) > np.cos(np.radians(10)):
            # Cameras opposite each other look at what is half way between them.
            meetings.append(origins.mean(axis=0))
        else:
            meetings.append(nearest_to_rays(origins, axes))
    return np.asarray(np.median(meetings, axis=0), dtype=np.float64)


def _shows(camera: Camera, point: FloatArray) -> bool:
    ideal = replace(camera, distortions=np.zeros(4), fisheye=False)
    place = ideal.project(point) / (camera.width, camera.height)
    return bool(np.all((place > -MARGIN) & (place < 1 + MARGIN)))


def _is_upright(camera: Camera, turn: int) -> bool:
    """Whether z points up in the image turned clockwise by `turn` degrees, or is seen end on."""
    x, y, z = camera.camera_from_world.rotation[:, 2]
    if abs(z) > STEEP:
        return True
    angle = np.radians(turn)
    down = x * np.sin(angle) + y * np.cos(angle)
    return bool(-down > LEAST_UPRIGHT * np.hypot(x, y))
