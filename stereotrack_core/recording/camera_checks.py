"""What looks wrong about the cameras: intrinsics, places, stereo pairs, units."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.finding import Finding

CALIBRATION = "calibration.toml"
BASELINE_M = (0.01, 2.0)
FARTHEST_CAMERA_M = 100.0
WIDEST_STEREO_TURN = np.radians(20.0)
FIELD_OF_VIEW_DEG = (5.0, 170.0)


def check_cameras(recording: Recording) -> Iterator[Finding]:
    """All findings about the cameras that the views use."""
    used = {s.camera for view in recording.views for s in view.streams().values() if s.camera}
    for name in sorted(used & set(recording.cameras)):
        yield from _check_intrinsics(recording.cameras[name])
    too_far = yield from _check_distances(recording)
    for view in recording.views:
        if view.left is not None:
            yield from _check_pair(recording, view)
    if not too_far:
        yield from _check_gaze(recording)


def _check_intrinsics(camera: Camera) -> Iterator[Finding]:
    where = f"{CALIBRATION}, camera {camera.name}, matrix"
    width, height = camera.width, camera.height
    cx, cy = camera.matrix[0, 2], camera.matrix[1, 2]
    if not (0 <= cx <= width - 1 and 0 <= cy <= height - 1):
        turned = 0 <= cx <= height - 1 and 0 <= cy <= width - 1
        yield Finding(
            "error",
            where,
            f"the principal point ({cx:.1f}, {cy:.1f}) lies outside the image of"
            f" {width} x {height} pixels",
            "It fits the image turned by 90 degrees: calibrate with the images as they are stored."
            if turned
            else "Use the calibration that belongs to this image size.",
        )
    elif abs(cx - width / 2) > width / 4 or abs(cy - height / 2) > height / 4:
        yield Finding(
            "warning",
            where,
            f"the principal point ({cx:.1f}, {cy:.1f}) is far from the middle of the image of"
            f" {width} x {height} pixels",
            "Right for cropped images only; else calibrate again.",
        )
    fx, fy = camera.matrix[0, 0], camera.matrix[1, 1]
    if not 0.8 < fx / fy < 1.25:
        yield Finding(
            "warning",
            where,
            f"the focal lengths {fx:.0f} and {fy:.0f} px differ by more than a fifth",
            "Right for pixels that are not square only; else calibrate again.",
        )
    angle = np.degrees(2 * np.arctan2(width / 2, fx))
    if not camera.fisheye and not FIELD_OF_VIEW_DEG[0] < angle < FIELD_OF_VIEW_DEG[1]:
        yield Finding(
            "warning",
            where,
            f"a focal length of {fx:.0f} px makes a field of view of {angle:.1f} degrees",
            "The focal length is in pixels, not in millimetres.",
        )


def _view_cameras(recording: Recording) -> dict[str, Camera]:
    """Reference camera by view name, for views whose camera is known."""
    return {
        view.name: recording.cameras[view.image.camera]
        for view in recording.views
        if view.image.camera in recording.cameras
    }


def _check_distances(recording: Recording) -> Generator[Finding, None, bool]:
    """Findings about the size of the rig; the generator's value says whether it is too large."""
    places = [camera.position_world for camera in _view_cameras(recording).values()]
    where = f"{CALIBRATION}, [metadata] units"
    if not places:
        return False
    farthest = max(float(np.linalg.norm(place)) for place in places)
    if farthest > FARTHEST_CAMERA_M:
        yield Finding(
            "error",
            where,
            f"a camera stands {farthest:,.0f} m from the origin of the world, as if a person were"
            f" {1.7 * farthest / 3000:,.1f} km tall"
            if farthest > 1000
            else f"a camera stands {farthest:,.0f} m from the origin of the world",
            'If the translations are in millimetres, state units = "mm".',
        )
        return True
    spans = [float(np.linalg.norm(a - b)) for a, b in combinations(places, 2)]
    if spans and max(spans) < 0.05:
        yield Finding(
            "error",
            where,
            f"all views stand within {1000 * max(spans):.1f} mm, as if a person were"
            f" {1700 * max(spans) / 4:.1f} mm tall",
            'If the translations are in metres, state units = "m".',
        )
        return True
    return False


def _check_pair(recording: Recording, view: View) -> Iterator[Finding]:
    assert view.left is not None  # noqa: S101 - the caller chose stereo views
    left, right = (recording.cameras.get(s.camera) for s in (view.left, view.image))
    if left is None or right is None:
        return
    where = f"recording.toml, view {view.name}"
    right_from_left = right.camera_from_world @ left.world_from_camera
    offset = right_from_left.translation
    baseline = float(np.linalg.norm(offset))
    if not BASELINE_M[0] < baseline < BASELINE_M[1]:
        yield Finding(
            "error" if baseline < 1e-6 or baseline > 20 else "warning",
            where,
            f"the two cameras of the stereo pair are {_length(baseline)} apart",
            "State the right units in calibration.toml, and two cameras that belong together.",
        )
    if baseline < 1e-6:
        return
    if offset[0] > 0.5 * baseline:
        yield Finding(
            "error",
            where,
            f"left and right are swapped: camera {left.name} stands to the right of {right.name}",
            "Exchange left and right of this view in recording.toml.",
        )
    elif abs(offset[0]) < 0.8 * baseline:
        yield Finding(
            "warning",
            where,
            "the two cameras do not stand side by side as the images show it",
            "Check which cameras belong to this view, and their rotations.",
        )
    turn = np.arccos(np.clip((np.trace(right_from_left.rotation) - 1) / 2, -1, 1))
    if turn > WIDEST_STEREO_TURN:
        yield Finding(
            "warning",
            where,
            f"the two cameras of the stereo pair look {np.degrees(turn):.0f} degrees apart",
            "Check which cameras belong to this view, and their rotations.",
        )


def _length(metres: float) -> str:
    return f"{1000 * metres:.1f} mm" if metres < 1 else f"{metres:.2f} m"


def _check_gaze(recording: Recording) -> Iterator[Finding]:
    """Cameras look at one place, and the world's z points up in their images."""
    cameras = _view_cameras(recording)
    if len(cameras) < 3:
        return
    blind = _views_that_miss(cameras)
    if blind:
        for way, change in (("transposed", _transposed), ("inverted", _inverted)):
            changed = {name: change(camera) for name, camera in cameras.items()}
            if not _views_that_miss(changed):
                yield Finding(
                    "error",
                    f"{CALIBRATION}, rotation and translation",
                    f"the cameras look at one place only if they are {way}",
                    "They have to turn the world into the camera: x_camera = R x_world + t.",
                )
                return
    for name in blind:
        camera = cameras[name]
        ways = {"transposed": _transposed(camera), "inverted": _inverted(camera)}
        fits = [w for w, c in ways.items() if name not in _views_that_miss({**cameras, name: c})]
        yield Finding(
            "warning",
            f"{CALIBRATION}, camera {camera.name}, rotation",
            f"view {name} looks away from what the other views look at",
            f"It would fit if its rotation were {fits[0]}: x_camera = R x_world + t."
            if fits
            else "Check its rotation and translation: x_camera = R x_world + t.",
        )


def _transposed(camera: Camera) -> Camera:
    old = camera.camera_from_world
    return replace(camera, camera_from_world=RigidTransform(old.rotation.T, old.translation))


def _inverted(camera: Camera) -> Camera:
    return replace(camera, camera_from_world=camera.camera_from_world.inverse())


def common_centre(cameras: dict[str, Camera]) -> FloatArray:
    """Place (3,) that the optical axes of most pairs of cameras come near; NaN where none."""
    meetings = []
    for a, b in combinations(cameras.values(), 2):
        origins = np.array([a.position_world, b.position_world])
        axes = np.array([a.camera_from_world.rotation[2], b.camera_from_world.rotation[2]])
        if abs(axes[0] @ axes[1]) > np.cos(np.radians(10)):
            # Cameras opposite each other look at what is half way between them.
            meetings.append(origins.mean(axis=0))
            continue
        meetings.append(nearest_to_rays(origins, axes))
    return np.asarray(np.median(meetings, axis=0), dtype=np.float64)


def _views_that_miss(cameras: dict[str, Camera]) -> list[str]:
    """Views in whose image the common centre is not, with a margin of half the image."""
    centre = common_centre(cameras)
    missing = []
    for name, camera in cameras.items():
        ideal = replace(camera, distortions=np.zeros(4), fisheye=False)
        x, y = ideal.project(centre) / (camera.width, camera.height)
        if not (-0.5 < x < 1.5 and -0.5 < y < 1.5):
            missing.append(name)
    return missing
