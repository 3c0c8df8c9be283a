"""Calibrations of cameras and their drivers, ROS, Qualisys, ZED, and of MATLAB.

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

MATLAB's ``stereoParameters`` and ``cameraParameters``, as JSON or as a MAT file of structs, which
are made with ``toStruct``: it cannot hold MATLAB's objects for others. MATLAB multiplies from the
left (x_2 = x_1 R + t), so that its matrices are transposed; newer versions also give ``K`` and
``PoseCamera2``, which are not. The centre of the first pixel is (1, 1).
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from stereotrack_core.interop.calibrations import foreign
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, ForeignCamera

_KEYS = {
    "matrix": ("camera_matrix", "K", "k"),
    "distortions": ("distortion_coefficients", "D", "d"),
    "projection": ("projection_matrix", "P", "p"),
    "width": ("image_width", "width"),
    "height": ("image_height", "height"),
}
_MODELS = dict.fromkeys(("", "plumb_bob", "rational_polynomial"), False)
_MODELS |= dict.fromkeys(("equidistant", "fisheye"), True)  # whether it is of a fisheye


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
    names = map(foreign.text_of, (content.get("camera_name"), frame))
    name = next(filter(None, names), document.path.stem)
    turned = np.eye(3)  # camera_from_world, where the world is the rectified left camera
    given = content.get("rectification_matrix", content.get("R", content.get("r")))
    if given is not None:
        turned = foreign.rotation_of(foreign.data_of(given), f"{where}, rectification matrix").T
    stated, place = _ros_value(content, "projection", where), f"{where}, projection matrix"
    projection = foreign.array_of(stated, (3, 4), place, "3 x 4 numbers")
    aside, focal = np.zeros(3), projection.diagonal()[:2]
    if focal.all():  # zero in messages of cameras that are not calibrated
        aside[:2] = projection[:2, 3] / focal
    values = {
        "size": [_ros_value(content, key, where) for key in ("width", "height")],
        **{key: _ros_value(content, key, where) for key in ("matrix", "distortions")},
        "fisheye": _MODELS[model],
        "rotation": turned,
        "translation": turned @ aside,
    }
    camera = foreign.camera_of(name, values, where)
    return ForeignCalibration("ROS camera_info", where, (camera,), "m", documented=True)


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
    edges = ("left", "top", "right", "bottom")
    left, top, right, bottom = (_number(shown, key, place) for key in edges)
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
    where = document.where
    pairs = tuple(ForeignCalibration("ZED", where, one, "mm", documented=True) for one in found)
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


_PAIR, _ONE = ("CameraParameters1", "CameraParameters2"), ("RadialDistortion",)
_DEEPEST = 3
_FIRST_PIXEL = 1.0
_COUNTS_FROM_ONE = "MATLAB counts pixels from 1: the principal points are moved by one pixel"


def _struct(content: Any, keys: tuple[str, ...], depth: int = 0) -> Mapping[str, Any] | None:
    """The first struct with all of the keys, however the variable is called that holds it."""
    if not isinstance(content, Mapping) or depth > _DEEPEST:
        return None
    if all(key in content for key in keys):
        return content
    found = (_struct(value, keys, depth + 1) for value in content.values())
    return next((one for one in found if one is not None), None)


def read_matlab(document: Document) -> ForeignCalibration | None:
    """Read a pair or one camera, None of another file; InputError for what is wrong, and where."""
    where = document.where
    pair, one = (_struct(document.content, keys) for keys in (_PAIR, _ONE))
    if pair is None:
        if one is None and document.kind != "mat":
            return None
        if one is None:
            what = "it contains no stereoParams or cameraParams that can be read"
            remedy = "In MATLAB: s = toStruct(stereoParams); save('stereo.mat', 's', '-v7')."
            raise foreign.refusal(where, what, remedy)
        camera = _camera(one, document.path.stem, where, (None, None))
        return _calibration(where, (camera,), one)
    first, second = (foreign.table_of(pair[key], f"{where}, {key}") for key in _PAIR)
    cameras = (
        _camera(first, "left", f"{where}, {_PAIR[0]}", (np.eye(3), np.zeros(3))),
        _camera(second, "right", f"{where}, {_PAIR[1]}", _second_from_first(pair, where)),
    )
    return _calibration(where, cameras, first)


def _calibration(
    where: str, cameras: tuple[ForeignCamera, ...], stated: Mapping[str, Any]
) -> ForeignCalibration:
    unit, notes = foreign.unit_named(stated.get("WorldUnits")), (_COUNTS_FROM_ONE,)
    return ForeignCalibration(
        "MATLAB", where, cameras, unit, stated=unit is not None, notes=notes, documented=True
    )


def _second_from_first(pair: Mapping[str, Any], where: str) -> tuple[Any, Any]:
    pose = pair.get("PoseCamera2")
    if not isinstance(pose, Mapping):
        turned = foreign.rotation_of(
            foreign.needed(pair, "RotationOfCamera2", where), f"{where}, RotationOfCamera2"
        )
        return turned.T, foreign.needed(pair, "TranslationOfCamera2", where)
    place = f"{where}, PoseCamera2"
    if pose.get("A") is not None:
        matrix = foreign.array_of(pose["A"], (4, 4), f"{place}.A", "4 x 4 numbers")
        return matrix[:3, :3], matrix[:3, 3]
    return foreign.needed(pose, "R", place), foreign.needed(pose, "Translation", place)


def _camera(
    table: Mapping[str, Any], name: str, place: str, placed: tuple[Any, Any]
) -> ForeignCamera:
    inner = table.get("Intrinsics")
    if isinstance(inner, Mapping):
        table = {**table, **inner}
    radial = foreign.needed(table, "RadialDistortion", place)
    radial = foreign.array_of(radial, None, f"{place}, RadialDistortion", "numbers")
    tangential = table.get("TangentialDistortion", [0.0, 0.0])
    tangential = foreign.numbers_of(tangential, 2, f"{place}, TangentialDistortion")
    if radial.size not in (2, 3):
        what = f"it has {radial.size} numbers, not 2 or 3"
        raise foreign.refusal(f"{place}, RadialDistortion", what)
    size = table.get("ImageSize") or None  # empty where MATLAB was not told; height and width
    values = {
        "size": None if size is None else foreign.numbers_of(size, 2, f"{place}, ImageSize")[::-1],
        "matrix": _matrix(table, place),
        "distortions": [*radial[:2], *tangential, *radial[2:]],
        "rotation": placed[0],
        "translation": placed[1],
    }
    camera = foreign.camera_of(name, values, place)
    matrix = camera.matrix.copy()
    matrix[:2, 2] -= _FIRST_PIXEL
    return replace(camera, matrix=matrix)


def _matrix(table: Mapping[str, Any], place: str) -> Any:
    """Camera matrix as it is given, or of focal length, principal point and skew."""
    given = next((table[key] for key in ("K", "IntrinsicMatrix") if table.get(key)), None)
    if given is not None:
        return given
    focal, centre = (
        foreign.numbers_of(foreign.needed(table, key, place), 2, f"{place}, {key}")
        for key in ("FocalLength", "PrincipalPoint")
    )
    skew = foreign.number_of(table.get("Skew", 0.0), f"{place}, Skew")
    return foreign.pinhole((*focal, *centre), skew)
