"""Calibrations that come with cameras and their drivers: ROS, Qualisys, ZED.

ROS ``camera_info``: files of camera_calibration, and messages as ``topic echo`` prints them. One
camera a file, metres. The files of a stereo camera place it: the rectified cameras share axes,
x_rectified = R x_camera, and the projection P of the right one holds -fx times the base line.

Qualisys Track Manager's ``.qca.txt``: XML, millimetres, z up. Intrinsics and the sensor are in
64ths of a pixel; the principal point counts from the sensor's corner. The rotation's rows are the
camera's axes in the world, x right, y up, z backwards; x, y, z is the place of the camera (compare
calib_qca_fun of Pose2Sim).

Stereolabs' factory calibration of a ZED camera (``SN12345.conf``), millimetres. Sections hold the
lenses at each resolution; their coefficients are in the same sections, or for all resolutions in
``[LEFT_DISTO]`` and ``[RIGHT_DISTO]``. ``[STEREO]`` places the right camera: x_right = R x_left + T
with T = (-Baseline, TY, TZ) and R of the rotation vector (RX, CV, RZ), as Stereolabs' own
calibration tool writes OpenCV's result.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.interop.calibrations import foreign
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, ForeignCamera

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


def read_camera_info(document: Document) -> ForeignCalibration | None:
    """Read one camera of ROS, None of another file; InputError for what is wrong, with its key."""
    content, where = document.content, document.where
    if not all(any(key in content for key in _KEYS[name]) for name in ("matrix", "projection")):
        return None
    model = foreign.text_of(content.get("distortion_model", "")).lower()
    if model not in _MODELS:
        what = f"unknown distortion model {model!r}"
        remedy = "Use plumb_bob, rational_polynomial or equidistant."
        raise foreign.refusal(f"{where}, distortion_model", what, remedy)
    header = content.get("header")
    frame = header.get("frame_id") if isinstance(header, Mapping) else None
    name = (
        foreign.text_of(content.get("camera_name")) or foreign.text_of(frame) or document.path.stem
    )
    rotation, translation = _place(content, where)
    values = {
        "size": [_ros_value(content, key, where) for key in ("width", "height")],
        **{key: _ros_value(content, key, where) for key in ("matrix", "distortions")},
        "fisheye": _MODELS[model],
        "rotation": rotation,
        "translation": translation,
    }
    camera = foreign.camera_of(name, values, where)
    return ForeignCalibration("ROS camera_info", where, (camera,), "m", documented=True)


def _place(content: Mapping[str, Any], where: str) -> tuple[FloatArray, FloatArray]:
    """camera_from_world, where the world is the rectified left camera."""
    turned = np.eye(3)
    given = content.get("rectification_matrix", content.get("R", content.get("r")))
    if given is not None:
        turned = foreign.rotation_of(foreign.data_of(given), f"{where}, rectification matrix").T
    stated, place = _ros_value(content, "projection", where), f"{where}, projection matrix"
    projection = foreign.array_of(stated, (3, 4), place, "3 x 4 numbers")
    focal_x, focal_y = projection[0, 0], projection[1, 1]
    aside = np.zeros(3)
    if focal_x and focal_y:  # zero in messages of cameras that are not calibrated
        aside = np.array([projection[0, 3] / focal_x, projection[1, 3] / focal_y, 0.0])
    return turned, turned @ aside


def _ros_value(content: Mapping[str, Any], name: str, where: str) -> Any:
    for key in _KEYS[name]:
        if content.get(key) is not None:
            return foreign.data_of(content[key])
    raise foreign.refusal(f"{where}, {_KEYS[name][0]}", "the key is missing")


_PER_PIXEL = 64.0
_DISTORTIONS = (
    *("radialDistortion1", "radialDistortion2"),
    *("tangentalDistortion1", "tangentalDistortion2", "radialDistortion3"),
)
_OPENCV_AXES = np.diag([1.0, -1.0, -1.0])


def read_qualisys(document: Document) -> ForeignCalibration | None:
    """Read all cameras, None of another file; InputError for what is wrong, with the camera."""
    if document.kind != "xml" or document.content.find(".//cameras/camera/intrinsic") is None:
        return None
    cameras = []
    for i, element in enumerate(document.content.iterfind(".//cameras/camera")):
        name = element.get("serial", "").strip() or f"cam_{i}"
        cameras.append(_qualisys_camera(element, name, f"{document.where}, camera {name}"))
    return ForeignCalibration("Qualisys", document.where, tuple(cameras), "mm", documented=True)


def _qualisys_camera(element: Element, name: str, place: str) -> ForeignCamera:
    shown = element.find("fov_video")
    shown = element.find("fov_video_max") if shown is None else shown
    lens, placed = element.find("intrinsic"), element.find("transform")
    if shown is None or lens is None or placed is None:
        raise foreign.refusal(
            place, "it lacks fov_video, intrinsic or transform", "Calibrate it in QTM."
        )
    left, top, right, bottom = (
        _number(shown, key, place) for key in ("left", "top", "right", "bottom")
    )
    fx, fy, cx, cy, skew = (
        _number(lens, key, place) / _PER_PIXEL
        for key in ("focalLengthU", "focalLengthV", "centerPointU", "centerPointV", "skew")
    )
    rotation = foreign.rotation_of(
        [[_number(placed, f"r{row}{column}", place) for column in (1, 2, 3)] for row in (1, 2, 3)],
        f"{place}, transform",
    )
    turned = _OPENCV_AXES @ rotation
    centre = foreign.numbers_of([placed.get(key) for key in "xyz"], 3, f"{place}, transform")
    values = {
        "size": [right - left + 1, bottom - top + 1],
        "matrix": foreign.pinhole((fx, fy, cx - left, cy - top), skew),
        "distortions": [_number(lens, key, place) for key in _DISTORTIONS],
        "rotation": turned,
        "translation": -turned @ centre,
    }
    return foreign.camera_of(name, values, place)


def _number(element: Element, key: str, place: str) -> float:
    value = element.get(key)
    if value is None:
        if key in ("skew", "radialDistortion3"):
            return 0.0
        raise foreign.refusal(f"{place}, {element.tag}", f"it does not state {key}")
    return foreign.number_of(value, f"{place}, {element.tag} {key}")


_SIZES = {
    "2K": (2208, 1242), "FHD": (1920, 1080), "FHD1200": (1920, 1200), "HD": (1280, 720),
    "SVGA": (960, 600), "VGA": (672, 376), "4K": (3840, 2160), "QHDPLUS": (3200, 1800),
}  # fmt: skip
_COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")  # OpenCV's order


def read_zed(document: Document) -> ForeignCalibration | None:
    """Read a pair at all resolutions, None of another file; InputError with the wrong section."""
    if document.kind != "ini" or "stereo" not in document.content:
        return None
    known = {name.casefold(): (name, size) for name, size in _SIZES.items()}
    found = []
    for section in document.content:
        name, size = known.get(section.removeprefix("left_cam_"), ("", (0, 0)))
        if section.startswith("left_cam_") and name:
            found.append(_pair(document, name, size))
    if not found:
        raise foreign.refusal(
            document.where, "it holds no lens of a ZED camera at a known resolution"
        )
    pairs = tuple(
        ForeignCalibration("ZED", document.where, pair, "mm", documented=True) for pair in found
    )
    return replace(pairs[0], other_sizes=pairs)


def _pair(document: Document, resolution: str, size: tuple[int, int]) -> tuple[ForeignCamera, ...]:
    stereo, where = document.content["stereo"], f"{document.where}, [STEREO]"
    turn = [_zed_value(stereo, f"{axis}_{resolution}", where) for axis in ("RX", "CV", "RZ")]
    aside = [_zed_value(stereo, key, where, 0.0) for key in ("TY", "TZ")]
    shift = [-_zed_value(stereo, "Baseline", where), *aside]
    cameras = []
    for side, turned, moved in (("left", np.eye(3), np.zeros(3)), ("right", turn, shift)):
        section = f"{side}_cam_{resolution}"
        where = f"{document.where}, [{section.upper()}]"
        lens = foreign.needed(document.content, section.casefold(), document.where)
        source = lens if "k1" in lens else document.content.get(f"{side}_disto", {})
        more = any(key in source for key in ("k4", "k5", "k6"))
        names = _COEFFICIENTS if more else _COEFFICIENTS[:5]
        values = {
            "size": size,
            "matrix": foreign.pinhole(
                [_zed_value(lens, key, where) for key in ("fx", "fy", "cx", "cy")]
            ),
            "distortions": [_zed_value(source, key, where, 0.0) for key in names],
            "rotation": turned,
            "translation": moved,
        }
        cameras.append(foreign.camera_of(side, values, where))
    return tuple(cameras)


def _zed_value(
    table: Mapping[str, Any], key: str, where: str, default: float | None = None
) -> float:
    text = table.get(key.casefold())
    if text is None and default is not None:
        return default
    return foreign.number_of(foreign.needed(table, key.casefold(), where), f"{where}, {key}")
