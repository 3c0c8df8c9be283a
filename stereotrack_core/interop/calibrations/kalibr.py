"""Kalibr's chain of cameras (``camchain.yaml``); metres, every camera relative to the one before.

``T_cn_cnm1`` maps from the camera before to this one. A chain that was calibrated with an IMU has
``T_cam_imu``, from the IMU to the camera, instead or as well: then the IMU is the world.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import (
    ForeignCalibration,
    ForeignCamera,
    array_of,
    distortions_of,
    needed,
    refusal,
    rotation_of,
    size_of,
    table_of,
    text_of,
    with_names,
)

_CAMERA = re.compile(r"cam(\d{1,4})$")
_MODELS = {"radtan": False, "equidistant": True, "none": False}
"""Distortion models of Kalibr; whether they are OpenCV's fisheye model."""


def is_kalibr(document: Document) -> bool:
    """Whether a document is a chain of Kalibr."""
    tables = [one for key, one in document.content.items() if _CAMERA.match(key)]
    return any(isinstance(one, Mapping) and "intrinsics" in one for one in tables)


def read_kalibr(document: Document) -> ForeignCalibration:
    """Read a chain; raises InputError for what is wrong, or a camera model OpenCV does not have."""
    keys = sorted(filter(_CAMERA.match, document.content), key=lambda key: int(key[3:]))
    cameras: list[ForeignCamera] = []
    before: FloatArray | None = np.eye(4)
    for i, key in enumerate(keys):
        place = f"{document.where}, {key}"
        table = table_of(document.content[key], place)
        step = table.get("T_cn_cnm1")
        if i > 0 and step is None:
            before = None  # and so the cameras after it have no place either
        elif i > 0 and before is not None:
            before = _transform(step, f"{place}, T_cn_cnm1") @ before
        cameras.append(_camera(table, key, place, before if len(keys) > 1 else None))
    if any(one.rotation is None for one in cameras) and len(keys) > 1:
        raise refusal(
            document.where,
            "a camera of the chain has no T_cn_cnm1",
            "Calibrate all cameras together in Kalibr.",
        )
    return ForeignCalibration(
        "Kalibr", document.where, with_names(cameras, document.where), "m", documented=True
    )


def _transform(value: Any, where: str) -> FloatArray:
    """Homogeneous matrix (4, 4) with a rotation."""
    matrix = array_of(value, (4, 4), where, "a transformation of 4 x 4 numbers")
    matrix[:3, :3] = rotation_of(matrix[:3, :3], where)
    return matrix


def _camera(
    table: Mapping[str, Any], key: str, place: str, placed: FloatArray | None
) -> ForeignCamera:
    model = text_of(table.get("camera_model")).lower()
    distortion = text_of(table.get("distortion_model", "none")).lower()
    if model != "pinhole" or distortion not in _MODELS:
        raise refusal(
            f"{place}, camera_model",
            f"the model {model or '?'}-{distortion or '?'} cannot be read",
            "Calibrate with pinhole-radtan or pinhole-equi.",
        )
    fx, fy, cx, cy = array_of(
        needed(table, "intrinsics", place), (4,), f"{place}, intrinsics", "fx, fy, cx, cy"
    )
    if min(fx, fy) < 1:
        raise refusal(f"{place}, intrinsics", f"the focal lengths {fx:g}, {fy:g} are not in pixels")
    fisheye = _MODELS[distortion]
    given = table.get("distortion_coeffs", [0.0] * 4)
    return ForeignCamera(
        key,
        size_of(needed(table, "resolution", place), f"{place}, resolution"),
        np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
        distortions_of(given, f"{place}, distortion_coeffs", fisheye=fisheye),
        fisheye,
        None if placed is None else placed[:3, :3],
        None if placed is None else placed[:3, 3],
    )
