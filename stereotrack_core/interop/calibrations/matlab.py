"""MATLAB's ``stereoParameters`` and ``cameraParameters``, as JSON or as a MAT file of structs.

A MAT file cannot hold MATLAB's objects for others: they are made structs with ``toStruct``. MATLAB
multiplies from the left (x_2 = x_1 R + t), so that its matrices are transposed; newer versions also
give ``K`` and ``PoseCamera2``, which are not. The centre of the first pixel is (1, 1).
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
    distortions_of,
    matrix_of,
    needed,
    pinhole,
    refusal,
    rotation_of,
    size_of,
    table_of,
    unit_named,
    with_names,
)

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


def is_matlab(document: Document) -> bool:
    """Whether a document holds parameters of MATLAB."""
    return document.kind == "mat" or any(_struct(document.content, one) for one in (_PAIR, _ONE))


def read_matlab(document: Document) -> ForeignCalibration:
    """Read a pair or one camera; raises InputError for what is wrong, with its place."""
    where = document.where
    pair = _struct(document.content, _PAIR)
    if pair is None:
        one = _struct(document.content, _ONE)
        if one is None:
            raise refusal(
                where,
                "it contains no stereoParams or cameraParams that can be read",
                "In MATLAB: s = toStruct(stereoParams); save('stereo.mat', 's', '-v7').",
            )
        camera = _camera(one, document.path.stem, where, None)
        return _calibration(where, (camera,), one)
    first, second = (table_of(pair[key], f"{where}, {key}") for key in _PAIR)
    cameras = (
        _camera(first, "left", f"{where}, {_PAIR[0]}", (np.eye(3), np.zeros(3))),
        _camera(second, "right", f"{where}, {_PAIR[1]}", _second_from_first(pair, where)),
    )
    return _calibration(where, cameras, first)


def _calibration(
    where: str, cameras: tuple[ForeignCamera, ...], stated: Mapping[str, Any]
) -> ForeignCalibration:
    unit = unit_named(stated.get("WorldUnits"))
    return ForeignCalibration(
        "MATLAB",
        where,
        with_names(cameras, where),
        unit,
        stated=unit is not None,
        notes=(_COUNTS_FROM_ONE,),
        documented=True,
    )


def _second_from_first(pair: Mapping[str, Any], where: str) -> tuple[FloatArray, FloatArray]:
    pose = pair.get("PoseCamera2")
    if isinstance(pose, Mapping):
        place = f"{where}, PoseCamera2"
        if pose.get("A") is not None:
            matrix = array_of(pose["A"], (4, 4), f"{place}.A", "4 x 4 numbers")
            return rotation_of(matrix[:3, :3], f"{place}.A"), matrix[:3, 3]
        rotation = rotation_of(needed(pose, "R", place), f"{place}.R")
        return rotation, array_of(
            needed(pose, "Translation", place), (3,), f"{place}.Translation", "three numbers"
        )
    rotation = rotation_of(needed(pair, "RotationOfCamera2", where), f"{where}, RotationOfCamera2")
    translation = array_of(
        needed(pair, "TranslationOfCamera2", where),
        (3,),
        f"{where}, TranslationOfCamera2",
        "three numbers",
    )
    return rotation.T, translation


def _camera(
    table: Mapping[str, Any],
    name: str,
    place: str,
    placed: tuple[FloatArray, FloatArray] | None,
) -> ForeignCamera:
    inner = table.get("Intrinsics")
    if isinstance(inner, Mapping):
        table = {**table, **inner}
    radial = array_of(
        needed(table, "RadialDistortion", place), None, f"{place}, RadialDistortion", "numbers"
    )
    tangential = array_of(
        table.get("TangentialDistortion", [0.0, 0.0]),
        (2,),
        f"{place}, TangentialDistortion",
        "two numbers",
    )
    if radial.size not in (2, 3):
        raise refusal(f"{place}, RadialDistortion", f"it has {radial.size} numbers, not 2 or 3")
    size = table.get("ImageSize")  # empty where MATLAB was not told
    return ForeignCamera(
        name,
        None
        if not size
        else size_of(
            array_of(size, (2,), f"{place}, ImageSize", "a height and a width")[::-1],
            f"{place}, ImageSize",
        ),
        _matrix(table, place),
        distortions_of([*radial[:2], *tangential, *radial[2:]], place),
        False,
        *(placed if placed is not None else (None, None)),
    )


def _matrix(table: Mapping[str, Any], place: str) -> FloatArray:
    """Camera matrix (3, 3) with the centre of the first pixel at (0, 0)."""
    given = next((table[key] for key in ("K", "IntrinsicMatrix") if table.get(key)), None)
    if given is None:
        focal, centre = (
            array_of(needed(table, key, place), (2,), f"{place}, {key}", "two numbers")
            for key in ("FocalLength", "PrincipalPoint")
        )
        skew = array_of(table.get("Skew", 0.0), (1,), f"{place}, Skew", "a number")[0]
        matrix = pinhole((*focal, *centre), f"{place}, camera matrix", skew)
    else:
        matrix = matrix_of(given, f"{place}, camera matrix").copy()
    matrix[:2, 2] -= _FIRST_PIXEL
    return matrix
