"""Qualisys Track Manager's ``.qca.txt``: XML, millimetres, z up.

Intrinsics and the sensor are in 64ths of a pixel; the principal point counts from the sensor's
corner. The rotation's rows are the camera's axes in the world, x right, y up, z backwards; x, y, z
is the place of the camera (compare calib_qca_fun of Pose2Sim).
"""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import (
    ForeignCalibration,
    ForeignCamera,
    array_of,
    distortions_of,
    number_of,
    pinhole,
    refusal,
    rotation_of,
    size_of,
    with_names,
)

_PER_PIXEL = 64.0
_DISTORTIONS = (
    *("radialDistortion1", "radialDistortion2"),
    *("tangentalDistortion1", "tangentalDistortion2", "radialDistortion3"),
)
_OPENCV_AXES = np.diag([1.0, -1.0, -1.0])


def is_qualisys(document: Document) -> bool:
    """Whether an XML document is a calibration of Qualisys."""
    return (
        document.kind == "xml" and document.content.find(".//cameras/camera/intrinsic") is not None
    )


def read_qualisys(document: Document) -> ForeignCalibration:
    """Read all cameras; raises InputError for what is wrong, with the camera."""
    cameras = []
    for i, element in enumerate(document.content.iterfind(".//cameras/camera")):
        name = element.get("serial", "").strip() or f"cam_{i}"
        cameras.append(_camera(element, name, f"{document.where}, camera {name}"))
    return ForeignCalibration(
        "Qualisys", document.where, with_names(cameras, document.where), "mm", documented=True
    )


def _camera(element: Element, name: str, place: str) -> ForeignCamera:
    shown = element.find("fov_video")
    shown = element.find("fov_video_max") if shown is None else shown
    lens, placed = element.find("intrinsic"), element.find("transform")
    if shown is None or lens is None or placed is None:
        raise refusal(place, "it lacks fov_video, intrinsic or transform", "Calibrate it in QTM.")
    left, top, right, bottom = (
        _number(shown, key, place) for key in ("left", "top", "right", "bottom")
    )
    fx, fy, cx, cy, skew = (
        _number(lens, key, place) / _PER_PIXEL
        for key in ("focalLengthU", "focalLengthV", "centerPointU", "centerPointV", "skew")
    )
    rotation = rotation_of(
        [[_number(placed, f"r{row}{column}", place) for column in (1, 2, 3)] for row in (1, 2, 3)],
        f"{place}, transform",
    )
    turned = _OPENCV_AXES @ rotation
    centre = array_of([placed.get(key) for key in "xyz"], (3,), f"{place}, transform", "x, y, z")
    return ForeignCamera(
        name,
        size_of([right - left + 1, bottom - top + 1], f"{place}, fov_video"),
        pinhole((fx, fy, cx - left, cy - top), f"{place}, intrinsic", skew),
        distortions_of([_number(lens, key, place) for key in _DISTORTIONS], f"{place}, intrinsic"),
        rotation=turned,
        translation=-turned @ centre,
    )


def _number(element: Element, key: str, place: str) -> float:
    value = element.get(key)
    if value is None:
        if key in ("skew", "radialDistortion3"):
            return 0.0
        raise refusal(f"{place}, {element.tag}", f"it does not state {key}")
    return number_of(value, f"{place}, {element.tag} {key}")
