"""A calibration as another tool wrote it, in its own convention, and checks of its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError, shortened
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.toml_table import LARGEST

METRES_PER_UNIT: Mapping[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
"""Units of length that files are written in."""

_UNITS = {
    **{unit: unit for unit in METRES_PER_UNIT},
    **dict.fromkeys(("metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("millimetre", "millimetres", "millimeter", "millimeters"), "mm"),
    **dict.fromkeys(("centimetre", "centimetres", "centimeter", "centimeters"), "cm"),
    **dict.fromkeys(("inch", "inches"), "in"),
}


_COUNTS = (4, 5, 8, 12, 14)  # numbers of coefficients that OpenCV's distortion model may have

_MOST_CAMERAS = 200
_AGAIN = "Write the file again with the tool that made it."


@dataclass(frozen=True, eq=False)
class ForeignCamera:
    """One camera of a file, lengths in its unit; what is not stated is None or empty."""

    name: str
    size: tuple[int, int] | None  # width, height in pixels
    matrix: FloatArray  # (3, 3)
    distortions: FloatArray  # (k,), OpenCV's order
    fisheye: bool = False
    rotation: FloatArray | None = None  # (3, 3)
    translation: FloatArray | None = None  # (3,)


@dataclass(frozen=True, eq=False)
class ForeignCalibration:
    """The cameras of files that belong together: x_camera = R x_world + t, as documented."""

    format: str  # name of the format, for people
    where: str  # the file
    cameras: tuple[ForeignCamera, ...]
    unit: str | None = None
    """Of length, as the file states or its format prescribes it; None where neither does."""
    stated: bool = False  # whether the unit stands in the file itself
    square: float | None = None  # a square of the calibration board, in the file's unit
    notes: tuple[str, ...] = ()
    documented: bool = False  # whether the format documents how rotation and translation map
    other_sizes: tuple[ForeignCalibration, ...] = ()
    """The same cameras at every image size, if the file holds several."""

    @property
    def placed(self) -> bool:
        """Whether the file says where its cameras are."""
        return all(one.rotation is not None for one in self.cameras)

    def of_size(self, size: tuple[int, int] | None) -> ForeignCalibration:
        """The cameras of an image size; InputError if the file holds several, and not this."""
        if not self.other_sizes:
            return self
        sizes = {one.cameras[0].size: one for one in self.other_sizes}
        if size in sizes:
            return sizes[size]
        listed = ", ".join(f"{one[0]}x{one[1]}" for one in sizes if one)
        remedy = "Give the recording with --recording, or one of them with --size WIDTHxHEIGHT."
        raise InputError(f"the file holds cameras for images of {listed}", self.where, remedy)


def refusal(where: str, what: str, remedy: str = _AGAIN) -> InputError:
    """What is wrong with a value at a place in a file."""
    return InputError(what, where, remedy)


def array_of(value: Any, shape: tuple[int, ...] | None, where: str, expected: str) -> FloatArray:
    """Finite numbers of a shape, or all that are there in a row; InputError where they are none."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise refusal(where, f"this is not {expected}") from None
    if array.size > 10_000 or (shape is not None and array.size != int(np.prod(shape))):
        raise refusal(where, f"this is not {expected}")
    if not np.isfinite(array).all() or (np.abs(array) > LARGEST).any():
        raise refusal(where, "it contains a value that is not finite, or too large")
    return array.reshape(shape) if shape is not None else array.ravel()


def size_of(value: Any, where: str) -> tuple[int, int]:
    """Width and height; raises InputError where they are no image size."""
    width, height = array_of(value, (2,), where, "a width and a height in pixels")
    if not (1 <= width <= 100_000 and 1 <= height <= 100_000) or width % 1 or height % 1:
        raise refusal(where, f"{width:g} x {height:g} is not an image size in pixels")
    return int(width), int(height)


def matrix_of(value: Any, where: str) -> FloatArray:
    """Camera matrix (3, 3); one that is transposed, as MATLAB and others write it, is turned.

    Which of the two it is can be seen: the last row of a camera matrix is 0, 0, 1.
    """
    matrix = array_of(value, (3, 3), where, "a camera matrix of 3 x 3 numbers")
    if not np.allclose(matrix[2], (0, 0, 1)) and np.allclose(matrix[:, 2], (0, 0, 1)):
        matrix = matrix.T.copy()
    if not np.allclose(matrix[2], (0, 0, 1)) or abs(matrix[1, 0]) > 1e-9:
        raise refusal(where, "this is not a camera matrix: its last row is not 0, 0, 1")
    if matrix[0, 0] < 1 or matrix[1, 1] < 1:
        what = f"the focal lengths {matrix[0, 0]:g} and {matrix[1, 1]:g} are not in pixels"
        raise refusal(where, what, "Focal lengths must be positive and in pixels.")
    matrix[2], matrix[1, 0] = (0.0, 0.0, 1.0), 0.0
    return matrix


def pinhole(four: Sequence[float] | FloatArray, skew: float = 0.0) -> list[list[float]]:
    """Rows of the camera matrix of fx, fy, cx and cy."""
    fx, fy, cx, cy = four
    return [[fx, skew, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]


def data_of(value: Any) -> Any:
    """The numbers of a matrix that is written with rows, columns and data."""
    return value.get("data") if isinstance(value, Mapping) else value


def distortions_of(value: Any, where: str, *, fisheye: bool = False) -> FloatArray:
    """Distortion coefficients in OpenCV's order; fewer than its models have are filled with 0."""
    given = array_of(value, None, where, "distortion coefficients")
    allowed = (4,) if fisheye else _COUNTS
    longer = [count for count in allowed if count >= given.size]
    if fisheye and given.size == 5 and given[4] == 0:
        given, longer = given[:4], [4]  # written by tools that know one length only
    if not longer:
        what = f"there are {given.size} distortion coefficients"
        raise refusal(where, what, f"OpenCV's model has {' or '.join(map(str, allowed))}.")
    return np.concatenate([given, np.zeros(longer[0] - given.size)])


def rotation_of(value: Any, where: str) -> FloatArray:
    """Rotation (3, 3) of a matrix or a rotation vector in radians.

    A matrix whose rows are not quite orthonormal, as files with few digits have them, becomes the
    nearest one that is. Raises InputError where it is no rotation.
    """
    given = array_of(value, None, where, "a rotation matrix or vector")
    if given.size == 3:
        return rotation_from_vector(given)
    if given.size != 9:
        raise refusal(where, "this is not a rotation matrix or vector")
    matrix = given.reshape(3, 3)
    off = float(np.abs(matrix @ matrix.T - np.eye(3)).max())
    if off > 0.05 or np.linalg.det(matrix) <= 0:
        raise refusal(where, "this is not a rotation: its rows are not orthonormal, or it mirrors")
    if off < 1e-9:
        return matrix
    u, _, v = np.linalg.svd(matrix)
    return np.asarray(u @ v)


def camera_of(name: str, values: Mapping[str, Any], where: str) -> ForeignCamera:
    """A camera of ``matrix``, ``distortions``, perhaps size and place; InputError with the key."""
    size, rotation, translation = (values.get(k) for k in ("size", "rotation", "translation"))
    placed = rotation is not None and translation is not None
    fisheye = values.get("fisheye") is True
    coefficients = needed(values, "distortions", where)
    return ForeignCamera(
        name,
        None if size is None else size_of(size, f"{where}, size"),
        matrix_of(needed(values, "matrix", where), f"{where}, matrix"),
        distortions_of(coefficients, f"{where}, distortions", fisheye=fisheye),
        fisheye,
        rotation_of(rotation, f"{where}, rotation") if placed else None,
        numbers_of(translation, 3, f"{where}, translation") if placed else None,
    )


def numbers_of(value: Any, count: int, where: str) -> FloatArray:
    """So many finite numbers (count,); raises InputError where they are none."""
    return array_of(value, (count,), where, f"{count} numbers")


def number_of(value: Any, where: str) -> float:
    """One finite number; raises InputError where it is none."""
    return float(array_of(value, (1,), where, "a number")[0])


def table_of(value: Any, where: str) -> Mapping[str, Any]:
    """A table with names; raises InputError where it is something else."""
    if not isinstance(value, Mapping):
        raise refusal(where, f"{shortened(repr(value), 60)} is not a table")
    return value


def unit_named(value: Any) -> str | None:
    """The unit that a word names; None where it names none."""
    return _UNITS.get(value.strip().lower()) if isinstance(value, str) else None


def text_of(value: Any) -> str:
    """A name: a text, or a number as people write cameras; empty for anything else."""
    if isinstance(value, str):
        return value.strip()
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else ""


def needed(table: Mapping[str, Any], key: str, where: str) -> Any:
    """The value of a key; raises InputError where it is missing."""
    value = table.get(key)
    if value is None:
        raise refusal(f"{where}, {key}", "the key is missing")
    return value


def check_cameras(cameras: Sequence[ForeignCamera], where: str) -> None:
    """Raise InputError where there are none, too many, or two of one name."""
    if not cameras:
        raise refusal(where, "it contains no camera", "Check that it is a calibration file.")
    if len(cameras) > _MOST_CAMERAS:
        raise refusal(where, f"it contains {len(cameras)} cameras", f"Use up to {_MOST_CAMERAS}.")
    names = [one.name for one in cameras if one.name]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise refusal(where, f"there are two cameras named {twice!r}", "Rename one of them.")
