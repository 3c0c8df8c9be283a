"""ROS ``camera_info``: files of camera_calibration, and messages as ``topic echo`` prints them.

One camera a file, metres. The files of a stereo camera place it: the rectified cameras share axes,
x_rectified = R x_camera, and the projection P of the right one holds -fx times the base line.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import (
    ForeignCalibration,
    ForeignCamera,
    array_of,
    data_of,
    distortions_of,
    matrix_of,
    refusal,
    rotation_of,
    size_of,
    text_of,
    with_names,
)

_KEYS = {
    "matrix": ("camera_matrix", "K", "k"),
    "distortions": ("distortion_coefficients", "D", "d"),
    "rectification": ("rectification_matrix", "R", "r"),
    "projection": ("projection_matrix", "P", "p"),
    "width": ("image_width", "width"),
    "height": ("image_height", "height"),
}
_MODELS = {
    "": False,
    "plumb_bob": False,
    "rational_polynomial": False,
    "equidistant": True,
    "fisheye": True,
}


def is_camera_info(document: Document) -> bool:
    """Whether a document is one camera of ROS."""
    content = document.content
    return all(any(key in content for key in _KEYS[name]) for name in ("matrix", "projection"))


def read_camera_info(document: Document) -> ForeignCalibration:
    """Read one camera; raises InputError for what is wrong, with its key."""
    content, where = document.content, document.where
    model = text_of(content.get("distortion_model", "")).lower()
    if model not in _MODELS:
        raise refusal(
            f"{where}, distortion_model",
            f"unknown distortion model {model!r}",
            "Use plumb_bob, rational_polynomial or equidistant.",
        )
    size = size_of([_value(content, "width", where), _value(content, "height", where)], where)
    header = content.get("header")
    frame = header.get("frame_id") if isinstance(header, Mapping) else None
    name = text_of(content.get("camera_name")) or text_of(frame) or document.path.stem
    rotation, translation = _place(content, where)
    camera = ForeignCamera(
        name,
        size,
        matrix_of(_value(content, "matrix", where), f"{where}, camera matrix"),
        distortions_of(
            _value(content, "distortions", where),
            f"{where}, distortion coefficients",
            fisheye=_MODELS[model],
        ),
        _MODELS[model],
        rotation,
        translation,
    )
    return ForeignCalibration(
        "ROS camera_info", where, with_names([camera], where), "m", documented=True
    )


def _place(content: Mapping[str, Any], where: str) -> tuple[FloatArray, FloatArray]:
    """camera_from_world, where the world is the rectified left camera."""
    rectification = content.get("rectification_matrix", content.get("R", content.get("r")))
    rectified_from_camera = (
        np.eye(3)
        if rectification is None
        else rotation_of(data_of(rectification), f"{where}, rectification matrix")
    )
    projection = array_of(
        _value(content, "projection", where), (3, 4), f"{where}, projection matrix", "3 x 4 numbers"
    )
    focal_x, focal_y = projection[0, 0], projection[1, 1]
    aside = np.zeros(3)
    if focal_x and focal_y:  # zero in messages of cameras that are not calibrated
        aside = np.array([projection[0, 3] / focal_x, projection[1, 3] / focal_y, 0.0])
    turned = rectified_from_camera.T
    return turned, turned @ aside


def _value(content: Mapping[str, Any], name: str, where: str) -> Any:
    for key in _KEYS[name]:
        if content.get(key) is not None:
            return data_of(content[key])
    raise refusal(f"{where}, {_KEYS[name][0]}", "the key is missing")
