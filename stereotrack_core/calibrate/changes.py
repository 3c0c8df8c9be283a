"""A calibration before and after: places, lenses, and the errors on the same boards."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.calibrate.align import aligned, from_cameras
from stereotrack_core.calibrate.bundle import BundleCamera, adjusted, rms_of
from stereotrack_core.calibrate.lens import lens_of
from stereotrack_core.calibrate.world import World
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import vector_from_rotation
from stereotrack_core.tables import Table, number


@dataclass(frozen=True)
class CameraChange:
    """One camera before and after, the two worlds laid over each other by all cameras.

    NaN where the camera, or its lens, was not there before.
    """

    camera: str
    rms_before_px: float
    rms_after_px: float
    moved_m: float
    turned_deg: float
    focal_change: float
    """Share of the focal length."""


def changes(world: World, before: Mapping[str, Camera]) -> tuple[CameraChange, ...]:
    """What a new calibration changes for each of its cameras.

    The error before is that of the old cameras with the boards placed as well as they allow.
    """
    after = {camera.name: camera for camera in world.cameras}
    old_from_new = from_cameras(after, before).new_from_old if after.keys() & before else None
    laid_over = after if old_from_new is None else aligned(after, old_from_new)
    errors = _errors_of(world, before)
    return tuple(
        _change(name, camera, before.get(name), errors.get(name, float("nan")), rms)
        for (name, camera), rms in zip(laid_over.items(), world.rms_by_camera, strict=True)
    )


def _change(
    name: str, after: Camera, before: Camera | None, rms_before: float, rms_after: float
) -> CameraChange:
    if before is None:
        unknown = float("nan")
        return CameraChange(name, unknown, rms_after, unknown, unknown, unknown)
    turn = after.camera_from_world.rotation @ before.camera_from_world.rotation.T
    return CameraChange(
        name,
        rms_before,
        rms_after,
        float(np.linalg.norm(after.position_world - before.position_world)),
        float(np.degrees(np.linalg.norm(vector_from_rotation(turn)))),
        after.focal / before.focal - 1.0,
    )


def _errors_of(world: World, before: Mapping[str, Camera]) -> dict[str, float]:
    """Error of each old camera in pixels, with boards fitted to all of them."""
    frames = sorted(world.boards)
    number_of = {frame: k for k, frame in enumerate(frames)}
    names, bundle = [], []
    for own in world.sightings:
        camera = before.get(own.camera)
        lens = None if camera is None else lens_of(camera)
        if camera is None or lens is None or (camera.width, camera.height) != own.size:
            continue
        names.append(own.camera)
        bundle.append(
            BundleCamera(
                lens,
                camera.camera_from_world,
                np.array([number_of[int(frame)] for frame in own.frames], dtype=np.int64),
                own.pixels,
                np.zeros(lens.values.size, dtype=bool),
                pose_free=False,
            )
        )
    if not bundle:
        return {}
    after = {camera.name: camera for camera in world.cameras}
    old_from_new = from_cameras(after, before).new_from_old
    boards = [old_from_new @ world.boards[frame] for frame in frames]
    placed = adjusted(bundle, boards, world.board.corners)
    return dict(zip(names, map(rms_of, placed.errors), strict=True))


def change_table(found: tuple[CameraChange, ...]) -> Table:
    """One row per camera."""
    rows = [
        (
            one.camera,
            number(one.rms_before_px, 2),
            number(one.rms_after_px, 2),
            number(1000 * one.moved_m),
            number(one.turned_deg, 2),
            f"{100 * one.focal_change:+z.2f}" if np.isfinite(one.focal_change) else "-",
        )
        for one in found
    ]
    headings = (
        "camera", ">rms before (px)", ">rms after (px)", ">moved (mm)", ">turned (°)",
        ">focal length (%)",
    )  # fmt: skip
    return Table("Before and after", headings, rows)


def place_table(before: Mapping[str, Camera], after: Mapping[str, Camera]) -> Table:
    """Where cameras stand in the world before it was turned, and in the new one."""
    rows = [
        (name, *(text for world in (before, after) for text in _place(world[name])))
        for name in after
        if name in before
    ]
    headings = (
        "camera", ">place before (m)", ">looks down (°)", ">place after (m)", ">looks down (°)",
    )  # fmt: skip
    return Table("The world before and after", headings, rows)


def _place(camera: Camera) -> tuple[str, str]:
    down = float(np.degrees(np.arcsin(np.clip(-camera.camera_from_world.rotation[2, 2], -1, 1))))
    place = np.round(camera.position_world, 2) + 0.0  # no minus before a zero
    return "  ".join(f"{value:.2f}" for value in place), f"{np.round(down, 1) + 0.0:.1f}"
