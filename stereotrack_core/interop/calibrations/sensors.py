"""Single cameras of visual odometry: EuRoC's ``sensor.yaml`` and files of camodocal (VINS)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import (
    ForeignCalibration,
    ForeignCamera,
    array_of,
    distortions_of,
    matrix_of,
    needed,
    number_of,
    refusal,
    rotation_of,
    size_of,
    table_of,
    text_of,
    with_names,
)

_EUROC_MODELS = {"radialtangential": False, "radtan": False, "equidistant": True, "none": False}


def is_euroc(document: Document) -> bool:
    """Whether a document describes a sensor as the EuRoC data sets do."""
    return "T_BS" in document.content or "sensor_type" in document.content


def read_euroc(document: Document) -> ForeignCalibration:
    """Read one camera, whose world is the body; raises InputError for what is wrong, with its key.

    ``T_BS`` maps from the sensor to the body, in metres.
    """
    content, where = document.content, document.where
    kind = text_of(content.get("sensor_type")) or "camera"
    if kind != "camera":
        raise refusal(
            where,
            f"this describes a sensor of EuRoC, but no camera: {kind}",
            "Give the sensor.yaml of each camera.",
        )
    model = text_of(content.get("camera_model")).lower()
    distortion = text_of(content.get("distortion_model", "none")).lower()
    fisheye = _EUROC_MODELS.get("".join(filter(str.isalpha, distortion)))
    if model != "pinhole" or fisheye is None:
        raise refusal(
            f"{where}, camera_model",
            f"this is a camera of EuRoC whose model {model or '?'}, {distortion} cannot be read",
            "Calibrate with a pinhole camera, radial-tangential or equidistant.",
        )
    fx, fy, cx, cy = array_of(
        needed(content, "intrinsics", where), (4,), f"{where}, intrinsics", "fx, fy, cx, cy"
    )
    rotation, translation = None, None
    if content.get("T_BS") is not None:
        place = _numbers(content["T_BS"])
        body = array_of(place, (4, 4), f"{where}, T_BS", "4 x 4 numbers")
        turned = rotation_of(body[:3, :3], f"{where}, T_BS")
        camera_from_body = RigidTransform(turned, body[:3, 3]).inverse()
        rotation, translation = camera_from_body.rotation, camera_from_body.translation
    name = document.path.stem
    camera = ForeignCamera(
        document.path.absolute().parent.name if name == "sensor" else name,
        size_of(needed(content, "resolution", where), f"{where}, resolution"),
        matrix_of([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], f"{where}, intrinsics"),
        distortions_of(
            content.get("distortion_coefficients", [0.0] * 4),
            f"{where}, distortion_coefficients",
            fisheye=fisheye,
        ),
        fisheye,
        rotation,
        translation,
    )
    return ForeignCalibration("EuRoC", where, with_names([camera], where), "m", documented=True)


def _numbers(value: Any) -> Any:
    return value.get("data") if isinstance(value, Mapping) else value


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
    fisheye = model == "KANNALA_BRANDT"
    focal = {"MEI": ("gamma1", "gamma2", "u0", "v0"), "KANNALA_BRANDT": ("mu", "mv", "u0", "v0")}
    fx, fy, cx, cy = (
        number_of(needed(lens, key, where), f"{where}, {key}")
        for key in focal.get(model, ("fx", "fy", "cx", "cy"))
    )
    names: tuple[str, ...] = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    names = names if model == "PINHOLE_FULL" else names[:4]
    source = bent
    if fisheye:
        source, names = lens, ("k2", "k3", "k4", "k5")
    values = [number_of(source.get(key, 0.0), f"{where}, {key}") for key in names]
    camera = ForeignCamera(
        text_of(content.get("camera_name")) or document.path.stem,
        size_of([needed(content, f"image_{side}", where) for side in ("width", "height")], where),
        matrix_of([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], f"{where}, projection_parameters"),
        distortions_of(values, where, fisheye=fisheye),
        fisheye,
    )
    return ForeignCalibration("camodocal", where, with_names([camera], where), documented=True)
