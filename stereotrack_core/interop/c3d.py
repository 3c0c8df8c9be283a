"""C3D, the binary landmark file of motion laboratories.

Positions are in millimetres, z up (``POINT:X_SCREEN`` +X, ``POINT:Y_SCREEN`` +Z). An unknown
landmark is NaN with residual -1, which other readers take as missing. The format stores
single precision and counts frames with 16 bits; frame numbers are the recording's.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import (
    checked_fps,
    contiguous,
    landmark_columns,
    metres_per,
)
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_BLOCK = 512
_MAGIC = 0x50
_INTEL = 84
_BYTES = {-1: 1, 1: 1, 2: 2, 4: 4}


@dataclass(frozen=True, eq=False)
class _C3DContent:
    """What a file holds of points (F, N, 3), in `units` and NaN where marked as missing.

    The first frame is counted from 0, as ezc3d does, though the file counts from 1; `vertical` is
    ``POINT:Y_SCREEN``, empty where not stated.
    """

    first_frame: int
    rate: float
    units: str
    vertical: str
    labels: tuple[str, ...]
    points: FloatArray


@dataclass(frozen=True)
class _Parameter:
    """One parameter's type (-1 text, 1 byte, 2 integer, 4 float), sizes and bytes."""

    kind: int
    sizes: tuple[int, ...]
    data: bytes

    def texts(self) -> tuple[str, ...]:
        width = self.sizes[0] if self.sizes else 1
        parts = [self.data[k : k + width] for k in range(0, len(self.data), max(width, 1))]
        return tuple(part.decode("utf-8", "replace").strip() for part in parts)


def _parse_c3d(data: bytes) -> _C3DContent:
    """Parse the bytes of a file of the Intel kind, which all common programs write."""
    if len(data) < _BLOCK or data[1] != _MAGIC:
        raise ValueError("this is not a C3D file")
    try:
        parameters = _parameters(data, _BLOCK * (data[0] - 1))
        return _content(data, parameters)
    except (struct.error, IndexError, KeyError, OverflowError) as error:
        raise ValueError("the file is damaged") from error


def _content(data: bytes, parameters: dict[str, _Parameter]) -> _C3DContent:
    count, analog, first, last = struct.unpack_from("<4H", data, 2)
    scale, start = struct.unpack_from("<fH", data, 12)
    (rate,) = struct.unpack_from("<f", data, 20)
    frames = last - first + 1
    if frames < 0 or not 0 < rate < np.inf or not np.isfinite(scale):
        raise ValueError("the file is damaged")
    number = np.dtype("<f4" if scale < 0 else "<i2")
    size = (4 * count + analog) * frames
    begin = _BLOCK * (start - 1)
    if begin < _BLOCK or begin + size * number.itemsize > len(data):
        raise ValueError("the file ends before its last frame")
    values = np.frombuffer(data, number, size, begin).reshape(frames, 4 * count + analog)
    with np.errstate(invalid="ignore"):  # damaged floats may be signalling NaN
        rows = values[:, : 4 * count].reshape(frames, count, 4).astype(np.float64)
    points = rows[..., :3] if scale < 0 else rows[..., :3] * scale
    points[rows[..., 3] < 0] = np.nan
    units, labels, vertical = (
        parameters[name].texts() if name in parameters else ()
        for name in ("UNITS", "LABELS", "Y_SCREEN")
    )
    if len(labels) < count:
        raise ValueError("the file contains points without a label")
    unit, up = "".join(units[:1]), "".join(vertical[:1])
    return _C3DContent(first - 1, rate, unit, up, labels[:count], points)


def _parameters(data: bytes, start: int) -> dict[str, _Parameter]:
    """Parameters of the group POINT by name."""
    if start < 0 or data[start + 3] != _INTEL:
        raise ValueError("the file is damaged or uses an unsupported processor type")
    end = min(len(data), start + _BLOCK * data[start + 2])
    groups: dict[int, str] = {}
    found: list[tuple[int, str, _Parameter]] = []
    at = start + 4
    while at < end:
        name_length, group = struct.unpack_from("<bb", data, at)
        if name_length == 0:
            break
        at += 2
        name = data[at : at + abs(name_length)].decode("ascii", "replace").upper()
        at += abs(name_length)
        (step,) = struct.unpack_from("<H", data, at)
        if group < 0:
            groups[-group] = name
        else:
            parameter = _parameter(data, at + 2)
            if 0 < step < len(parameter.data):  # else a small file could hold any number of bytes
                raise ValueError("the file is damaged")
            found.append((group, name, parameter))
        if step == 0:
            break
        at += step
    return {name: parameter for group, name, parameter in found if groups.get(group) == "POINT"}


def _parameter(data: bytes, at: int) -> _Parameter:
    kind, dimensions = struct.unpack_from("<bB", data, at)
    sizes = tuple(data[at + 2 : at + 2 + dimensions])
    begin = at + 2 + dimensions
    length = _BYTES[kind] * math.prod(sizes)
    if begin + length > len(data):
        raise ValueError("the file is damaged")
    return _Parameter(kind, sizes, data[begin : begin + length])


_LAST_FRAME = 0xFFFF - 1


def write_c3d(
    path: Path, trajectory: LandmarkTrajectory, fps: float, residual: FloatArray | None = None
) -> None:
    """Write landmarks, and the tracker's residual (F,), metres, as the residual of every point.

    The format keeps whole millimetres of it. Frames between those of the trajectory are missing.

    InputError for a frame number that the format cannot count.
    """
    frame = trajectory.frame
    if len(frame) and (frame[0] < 0 or frame[-1] > _LAST_FRAME):
        raise InputError(
            f"C3D frame numbers are limited to {_LAST_FRAME}",
            where=str(path),
            remedy="Export part of the run, or use another format.",
        )
    first, points = contiguous(trajectory, str(path))
    per_frame = np.zeros(len(points))
    if residual is not None:
        per_frame[trajectory.frame - first] = np.nan_to_num(1000.0 * residual)
    file = _new_file(checked_fps(fps), first)
    file["data"]["points"] = np.ones((4, len(LANDMARKS), len(points)))
    file["data"]["points"][:3] = 1000.0 * points.transpose(2, 1, 0)
    missing = np.isnan(points).any(axis=-1).T
    file["data"]["meta_points"]["residuals"] = np.where(missing, -1.0, per_frame)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *missing.shape), dtype=np.bool_)

    def is_whole(written: Path) -> bool:  # ezc3d says nothing where the drive is full
        found, _ = read_c3d(written)
        same = len(found.points) == len(points) and int(found.frame[0]) == first
        return same and np.allclose(found.points, points, equal_nan=True)

    with replacing(path, is_whole) as temporary:
        file.write(str(temporary))


def _new_file(fps: float, first: int) -> Any:
    import ezc3d

    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"] = [fps]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = list(LANDMARKS)
    file.add_parameter("POINT", "X_SCREEN", "+X")
    file.add_parameter("POINT", "Y_SCREEN", "+Z")
    file["header"]["points"]["first_frame"] = first
    return file


def read_c3d(path: Path) -> tuple[LandmarkTrajectory, float]:
    """Landmarks and frame rate of a C3D file whose points have this program's names.

    The axes are taken as this program writes them (z up); landmarks that the file lacks are
    NaN, points with other names are left out.

    InputError for a damaged file, other axes, an unknown unit, or a file without any of the
    nine landmarks.
    """
    try:
        content = _parse_c3d(read_bytes(path, TABLE_BYTES))
    except ValueError as error:
        raise InputError(
            str(error), where=str(path), remedy="Use another copy of the file, or export it again."
        ) from error
    metres = metres_per(content.units, f"{path}, POINT:UNITS")
    if content.vertical not in ("", "+Z"):
        raise InputError(
            f"the vertical axis is {content.vertical}",
            where=f"{path}, POINT:Y_SCREEN",
            remedy="Rotate the data so that z points up, and set Y_SCREEN to +Z.",
        )
    columns = landmark_columns(content.labels, f"{path}, POINT:LABELS", "points")
    count = len(content.points)
    points = np.full((count, len(LANDMARKS), 3), np.nan)
    for name, column in columns.items():
        points[:, LANDMARKS.index(name)] = metres * content.points[:, column]
    frame = np.arange(content.first_frame, content.first_frame + count, dtype=np.int64)
    return LandmarkTrajectory(frame, points), content.rate
