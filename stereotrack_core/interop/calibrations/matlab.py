"""MATLAB's ``stereoParameters`` and ``cameraParameters``, as JSON or as a MAT file of structs.

A MAT file cannot hold MATLAB's objects for others: they are made structs with ``toStruct``. MATLAB
multiplies from the left (x_2 = x_1 R + t), so that its matrices are transposed; newer versions also
give ``K`` and ``PoseCamera2``, which are not. The centre of the first pixel is (1, 1).
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stereotrack_core.interop.calibrations import foreign
from stereotrack_core.interop.calibrations.documents import Document
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, ForeignCamera

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
    """Rotation and translation of the second camera."""
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
