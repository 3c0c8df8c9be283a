"""Slips that are made with calibrations again and again, and how each is undone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stereotrack_core.errors import Correction, CorrectionKind, Finding
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.camera_checks import IMAGE_SIZES


@dataclass(frozen=True)
class Slip:
    """A slip in a camera's calibration."""

    what: str
    """A clause."""
    remedy: str
    undone: Callable[[Camera], Camera]
    """Gives the camera as it was meant."""
    kind: CorrectionKind | None = None
    """The correction that undoes it in the files, if the program can make it."""
    amount: float = 1.0

    def correction(self, cameras: tuple[str, ...]) -> Correction | None:
        """The correction of cameras with these names."""
        return Correction(self.kind, cameras, self.amount) if self.kind else None


def exchanged_views(a: str, b: str) -> Finding:
    """The finding that the images of two views are exchanged."""
    return Finding(
        "error",
        f"views {a}, {b}",
        "they are exchanged",
        f"Exchange the files, or the cameras, of the views {a} and {b}.",
        Correction("exchange_views", (a, b)),
    )


def resized(camera: Camera, factor: float) -> Camera:
    """The camera with the matrix for images that are larger by a factor."""
    matrix = camera.matrix.copy()
    matrix[:2] *= factor
    return replace(camera, matrix=matrix)


def centre_exchanged(camera: Camera) -> Camera:
    """The camera with c_x and c_y exchanged."""
    matrix = camera.matrix.copy()
    matrix[:2, 2] = matrix[1::-1, 2]
    return replace(camera, matrix=matrix)


def transposed(camera: Camera) -> Camera:
    """The camera with its rotation transposed."""
    old = camera.camera_from_world
    return replace(camera, camera_from_world=RigidTransform(old.rotation.T, old.translation))


def inverted(camera: Camera) -> Camera:
    """The camera with rotation and translation inverted."""
    return replace(camera, camera_from_world=camera.camera_from_world.inverse())


def undistorted(camera: Camera) -> Camera:
    """The camera without distortions."""
    return replace(camera, distortions=np.zeros(4), fisheye=False)


def from_millimetres(camera: Camera) -> Camera:
    """The camera with a translation that was given in millimetres."""
    old = camera.camera_from_world
    metres = RigidTransform(old.rotation, old.translation / 1000.0)
    return replace(camera, camera_from_world=metres)


_TO_CAMERA = "Transforms must map the world to the camera: x_camera = R x_world + t."

SLIPS = (
    Slip("its rotation is transposed", _TO_CAMERA, transposed, "transpose"),
    Slip("its rotation and translation are inverted", _TO_CAMERA, inverted),
    Slip(
        "its translation is in millimetres",
        "Give it in metres.",
        from_millimetres,
        "scale_translation",
        0.001,
    ),
    Slip("c_x and c_y are exchanged", "Exchange them in its matrix.", centre_exchanged),
    *(
        Slip(
            "its matrix belongs to another image size",
            f"Multiply its first two rows by {factor:.3g}.",
            partial(resized, factor=factor),
        )
        for factor in IMAGE_SIZES
    ),
)
"""Those of one view that the others contradict."""
