"""Stereolabs' factory calibration of a ZED camera (``SN12345.conf``), millimetres.

Sections hold the lenses at each resolution; their coefficients are in the same sections, or for all
resolutions in ``[LEFT_DISTO]`` and ``[RIGHT_DISTO]``. ``[STEREO]`` places the right camera:
x_right = R x_left + T with T = (-Baseline, TY, TZ) and R of the rotation vector (RX, CV, RZ), as
Stereolabs' own calibration tool writes OpenCV's result.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import (
    ForeignCalibration,
    ForeignCamera,
    distortions_of,
    needed,
    number_of,
    pinhole,
    refusal,
    with_names,
)

_SIZES = {
    "2K": (2208, 1242), "FHD": (1920, 1080), "FHD1200": (1920, 1200), "HD": (1280, 720),
    "SVGA": (960, 600), "VGA": (672, 376), "4K": (3840, 2160), "QHDPLUS": (3200, 1800),
}  # fmt: skip
_COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")  # OpenCV's order


def is_zed(document: Document) -> bool:
    """Whether a document is a calibration of a ZED camera."""
    return document.kind == "ini" and "stereo" in document.content


def read_zed(document: Document) -> ForeignCalibration:
    """Read the pair at all resolutions; raises InputError for what is wrong, with its section."""
    known = {name.casefold(): (name, size) for name, size in _SIZES.items()}
    found = []
    for section in document.content:
        name, size = known.get(section.removeprefix("left_cam_"), ("", (0, 0)))
        if section.startswith("left_cam_") and name:
            found.append(_pair(document, name, size))
    if not found:
        raise refusal(document.where, "it holds no lens of a ZED camera at a known resolution")
    pairs = tuple(
        ForeignCalibration(
            "ZED", document.where, with_names(pair, document.where), "mm", documented=True
        )
        for pair in found
    )
    return replace(pairs[0], other_sizes=pairs)


def _pair(document: Document, resolution: str, size: tuple[int, int]) -> list[ForeignCamera]:
    stereo = document.content["stereo"]
    where = f"{document.where}, [STEREO]"
    turn = np.array([_value(stereo, f"{axis}_{resolution}", where) for axis in ("RX", "CV", "RZ")])
    shift = np.array([-_value(stereo, "Baseline", where), *(
        _value(stereo, key, where, 0.0) for key in ("TY", "TZ"))])  # fmt: skip
    places = {
        "left": (np.eye(3), np.zeros(3)),
        "right": (rotation_from_vector(turn), shift),
    }
    return [_camera(document, side, resolution, size, place) for side, place in places.items()]


def _camera(
    document: Document, side: str, resolution: str, size: tuple[int, int], place: Any
) -> ForeignCamera:
    section = f"{side}_cam_{resolution}"
    where = f"{document.where}, [{section.upper()}]"
    lens = needed(document.content, section.casefold(), document.where)
    four = [_value(lens, key, where) for key in ("fx", "fy", "cx", "cy")]
    shared = document.content.get(f"{side}_disto", {})
    source = lens if "k1" in lens else shared
    names = _COEFFICIENTS if any(key in source for key in ("k4", "k5", "k6")) else _COEFFICIENTS[:5]
    return ForeignCamera(
        side, size, pinhole(four, where),
        distortions_of([_value(source, key, where, 0.0) for key in names], where),
        rotation=place[0], translation=place[1],
    )  # fmt: skip


def _value(table: Mapping[str, Any], key: str, where: str, default: float | None = None) -> float:
    text = table.get(key.casefold())
    if text is None and default is not None:
        return default
    return number_of(needed(table, key.casefold(), where), f"{where}, {key}")
