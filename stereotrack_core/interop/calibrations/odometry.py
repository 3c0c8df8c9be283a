"""Cameras of visual odometry: Kalibr's ``camchain.yaml``, EuRoC's ``sensor.yaml``, camodocal.

Lengths are metres. Kalibr gives every camera relative to the one before: ``T_cn_cnm1`` maps from
that one to this one. EuRoC's ``T_BS`` maps from the sensor to the body, which is the world.
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
    data_of,
    distortions_of,
    needed,
    number_of,
    pinhole,
    refusal,
    rotation_of,
    size_of,
    table_of,
    text_of,
    with_names,
)

_CAMERA = re.compile(r"cam(\d{1,4})$")
_FISHEYE = {"radialtangential": False, "radtan": False, "equidistant": True, "none": False}
"""Distortion models of Kalibr and EuRoC; whether they are OpenCV's fisheye model."""


def is_kalibr(document: Document) -> bool:
    """Whether a document is a chain of Kalibr."""
    tables = [one for key, one in document.content.items() if _CAMERA.match(key)]
    return any(isinstance(one, Mapping) and "intrinsics" in one for one in tables)


def read_kalibr(document: Document) -> ForeignCalibration:
    """Read a chain; raises InputError for what is wrong, or a camera model OpenCV does not have."""
    where = document.where
    keys = sorted(filter(_CAMERA.match, document.content), key=lambda key: int(key[3:]))
    cameras: list[ForeignCamera] = []
    placed = np.eye(4)
    for i, key in enumerate(keys):
        place = f"{where}, {key}"
        table = table_of(document.content[key], place)
        if i > 0:
            if table.get("T_cn_cnm1") is None:
                what = "a camera of the chain has no T_cn_cnm1"
                raise refusal(where, what, "Calibrate all cameras together in Kalibr.")
            placed = _transform(table["T_cn_cnm1"], f"{place}, T_cn_cnm1") @ placed
        lens = _lens(table, place, "distortion_coeffs", "Calibrate with pinhole-radtan or -equi.")
        cameras.append(_camera(key, lens, placed if len(keys) > 1 else None))
    return ForeignCalibration("Kalibr", where, with_names(cameras, where), "m", documented=True)


def is_euroc(document: Document) -> bool:
    """Whether a document describes a sensor as the EuRoC data sets do."""
    return "T_BS" in document.content or "sensor_type" in document.content


def read_euroc(document: Document) -> ForeignCalibration:
    """Read one camera, whose world is the body; raises InputError for what is wrong."""
    content, where = document.content, document.where
    kind = text_of(content.get("sensor_type")) or "camera"
    if kind != "camera":
        what = f"this describes a sensor of EuRoC, but no camera: {kind}"
        raise refusal(where, what, "Give the sensor.yaml of each camera.")
    lens = _lens(
        content, where, "distortion_coefficients",
        "Calibrate with a pinhole camera, radial-tangential or equidistant.",
    )  # fmt: skip
    placed = content.get("T_BS")
    if placed is not None:
        placed = np.linalg.inv(_transform(data_of(placed), f"{where}, T_BS"))
    stem, folder = document.path.stem, document.path.absolute().parent.name
    camera = _camera(folder if stem == "sensor" else stem, lens, placed)
    return ForeignCalibration("EuRoC", where, with_names([camera], where), "m", documented=True)


def _transform(value: Any, where: str) -> FloatArray:
    """Homogeneous matrix (4, 4) with a rotation."""
    matrix = array_of(value, (4, 4), where, "a transformation of 4 x 4 numbers")
    matrix[:3, :3] = rotation_of(matrix[:3, :3], where)
    return matrix


def _lens(table: Mapping[str, Any], where: str, coefficients: str, remedy: str) -> ForeignCamera:
    """A pinhole camera without a name and a place; InputError for another model."""
    model = text_of(table.get("camera_model")).lower()
    distortion = text_of(table.get("distortion_model", "none")).lower()
    fisheye = _FISHEYE.get("".join(filter(str.isalpha, distortion)))
    if model != "pinhole" or fisheye is None:
        what = f"the model {model or '?'}-{distortion or '?'} cannot be read"
        raise refusal(f"{where}, camera_model", what, remedy)
    place = f"{where}, intrinsics"
    four = array_of(needed(table, "intrinsics", where), (4,), place, "fx, fy, cx, cy")
    given = table.get(coefficients, [0.0] * 4)
    return ForeignCamera(
        "",
        size_of(needed(table, "resolution", where), f"{where}, resolution"),
        pinhole(four, place),
        distortions_of(given, f"{where}, {coefficients}", fisheye=fisheye),
        fisheye,
    )


def _camera(name: str, lens: ForeignCamera, placed: FloatArray | None) -> ForeignCamera:
    if placed is None:
        return ForeignCamera(name, lens.size, lens.matrix, lens.distortions, lens.fisheye)
    return ForeignCamera(
        name, lens.size, lens.matrix, lens.distortions, lens.fisheye, placed[:3, :3], placed[:3, 3]
    )


def is_camodocal(document: Document) -> bool:
    """Whether a document is a camera of camodocal, as VINS uses them."""
    return "model_type" in document.content


def read_camodocal(document: Document) -> ForeignCalibration:
    """Read one lens; raises InputError for what is wrong, or a model that OpenCV does not have.

    ``KANNALA_BRANDT`` counts its coefficients from k2 and is OpenCV's fisheye model.
    """
    content, where = document.content, document.where
    model = text_of(content["model_type"]).upper()
    mirror = number_of(table_of(content.get("mirror_parameters", {}), where).get("xi", 0.0), where)
    if model not in ("PINHOLE", "PINHOLE_FULL", "KANNALA_BRANDT", "MEI") or mirror:
        raise refusal(
            f"{where}, model_type",
            f"this is a lens of camodocal, whose model {model} has no counterpart in OpenCV"
            + (f" (xi = {mirror:g})" if mirror else ""),
            "Calibrate with PINHOLE, or KANNALA_BRANDT for a wide lens.",
        )
    lens = table_of(needed(content, "projection_parameters", where), where)
    bent = table_of(content.get("distortion_parameters", {}), where)
    focal = {"MEI": ("gamma1", "gamma2", "u0", "v0"), "KANNALA_BRANDT": ("mu", "mv", "u0", "v0")}
    keys = focal.get(model, ("fx", "fy", "cx", "cy"))
    four = [number_of(needed(lens, key, where), f"{where}, {key}") for key in keys]
    names: tuple[str, ...] = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    names = names if model == "PINHOLE_FULL" else names[:4]
    fisheye = model == "KANNALA_BRANDT"
    if fisheye:
        bent, names = lens, ("k2", "k3", "k4", "k5")
    values = [number_of(bent.get(key, 0.0), f"{where}, {key}") for key in names]
    camera = ForeignCamera(
        text_of(content.get("camera_name")) or document.path.stem,
        size_of([needed(content, f"image_{side}", where) for side in ("width", "height")], where),
        pinhole(four, f"{where}, projection_parameters"),
        distortions_of(values, where, fisheye=fisheye),
        fisheye,
    )
    return ForeignCalibration("camodocal", where, with_names([camera], where), documented=True)
