"""C3D, the binary landmark file of motion laboratories.

Files of Intel, DEC and MIPS processors are read, with the axes that ``POINT:X_SCREEN`` and
``POINT:Y_SCREEN`` state; written are Intel's, in millimetres, z up (``X_SCREEN`` +X, ``Y_SCREEN``
+Z). An unknown landmark is NaN with residual -1, which other readers take as missing. The format
stores single precision and counts frames with 16 bits; frame numbers are the recording's.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import (
    Stated,
    axis_in,
    checked_fps,
    contiguous,
    landmark_columns,
    metres_per,
    world_from_up,
)
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_BLOCK = 512
_MAGIC = 0x50
_BYTES = {-1: 1, 1: 1, 2: 2, 4: 4}


@dataclass(frozen=True)
class _Processor:
    """How numbers are stored; `order` as numpy has it."""

    order: str = "<"
    vax_floats: bool = False

    def integers(self, data: bytes) -> npt.NDArray[np.int16]:
        """Numbers of two bytes, with a sign."""
        return np.frombuffer(data, f"{self.order}i2").astype(np.int16)

    def unsigned(self, data: bytes, at: int) -> int:
        """One number of two bytes without a sign."""
        return int(struct.unpack_from(f"{self.order}H", data, at)[0])

    def floats(self, data: bytes) -> FloatArray:
        """Numbers of four bytes.

        Those of a VAX have their halves exchanged, and an exponent that is larger by two.
        """
        if self.vax_floats:
            halves = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(halves).view("<f4")[:, 0].astype(np.float64) / 4.0
        return np.frombuffer(data, f"{self.order}f4").astype(np.float64)


_PROCESSORS = {84: _Processor(), 85: _Processor(vax_floats=True), 86: _Processor(order=">")}
"""Of Intel, DEC and MIPS, by the code of the file."""


@dataclass(frozen=True, eq=False)
class _C3DContent:
    """What a file holds of points (F, N, 3), in `units` and NaN where marked as missing.

    The first frame is counted from 0, as ezc3d does, though the file counts from 1; `right` and
    `vertical` are ``POINT:X_SCREEN`` and ``POINT:Y_SCREEN``, empty where not stated.
    """

    first_frame: int
    rate: float
    units: str
    right: str
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
    """Parse the bytes of a file of any processor."""
    if len(data) < _BLOCK or data[1] != _MAGIC:
        raise ValueError("this is not a C3D file")
    try:
        start = _BLOCK * (data[0] - 1)
        processor = _PROCESSORS.get(data[start + 3]) if start >= 0 else None
        if processor is None:
            raise ValueError("the file is damaged or uses an unsupported processor type")
        with np.errstate(invalid="ignore"):  # damaged floats may be signalling NaN
            return _content(data, processor, _parameters(data, start, processor))
    except (struct.error, IndexError, KeyError, OverflowError) as error:
        raise ValueError("the file is damaged") from error


def _content(data: bytes, processor: _Processor, parameters: dict[str, _Parameter]) -> _C3DContent:
    count, analog, first, last = (processor.unsigned(data, at) for at in (2, 4, 6, 8))
    scale, rate = (float(processor.floats(data[at : at + 4])[0]) for at in (12, 20))
    start = processor.unsigned(data, 16)
    frames = last - first + 1
    if frames < 0 or not 0 < rate < np.inf or not np.isfinite(scale):
        raise ValueError("the file is damaged")
    numbers, width = (processor.floats, 4) if scale < 0 else (processor.integers, 2)
    begin = _BLOCK * (start - 1)
    end = begin + (4 * count + analog) * frames * width
    if begin < _BLOCK or end > len(data):
        raise ValueError("the file ends before its last frame")
    values = numbers(data[begin:end]).reshape(frames, 4 * count + analog)
    rows = values[:, : 4 * count].reshape(frames, count, 4).astype(np.float64)
    points = rows[..., :3] if scale < 0 else rows[..., :3] * scale
    points[(rows[..., 3] < 0) | ~np.isfinite(points).all(axis=-1)] = np.nan
    units, labels, right, vertical = (
        parameters[name].texts() if name in parameters else ()
        for name in ("UNITS", "LABELS", "X_SCREEN", "Y_SCREEN")
    )
    if len(labels) < count:
        raise ValueError("the file contains points without a label")
    unit, east, up = ("".join(texts[:1]) for texts in (units, right, vertical))
    return _C3DContent(first - 1, rate, unit, east, up, labels[:count], points)


def _parameters(data: bytes, start: int, processor: _Processor) -> dict[str, _Parameter]:
    """Parameters of the group POINT by name."""
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
        step = processor.unsigned(data, at)
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
_LARGEST_RESIDUAL = 0xFF  # the format keeps one byte of it


def write_c3d(
    path: Path, trajectory: LandmarkTrajectory, fps: float, residual: FloatArray | None = None
) -> None:
    """Write landmarks, with residuals in metres: of frames (F,) or of their landmarks (F, 9).

    The format keeps whole millimetres of them. Frames between those of the trajectory are missing.

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
    residuals = np.zeros(points.shape[:2])
    if residual is not None:
        millimetres = np.clip(np.nan_to_num(1000.0 * residual), 0.0, _LARGEST_RESIDUAL)
        residuals[trajectory.frame - first] = millimetres.reshape(len(frame), -1)
    file = _new_file(checked_fps(fps), first)
    file["data"]["points"] = np.ones((4, len(LANDMARKS), len(points)))
    file["data"]["points"][:3] = 1000.0 * points.transpose(2, 1, 0)
    missing = np.isnan(points).any(axis=-1).T
    file["data"]["meta_points"]["residuals"] = np.where(missing, -1.0, residuals.T)[None]
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


def read_c3d(path: Path, stated: Stated | None = None) -> tuple[LandmarkTrajectory, float]:
    """Landmarks and frame rate of a C3D file, its points matched by name.

    Up and east are where the file's screen has them, else z and x. Landmarks that the file lacks
    are NaN, points with other names are left out.

    InputError for a damaged file, axes or a unit that are not known, or a file without any of the
    nine landmarks.
    """
    stated = stated or Stated()
    try:
        content = _parse_c3d(read_bytes(path, TABLE_BYTES))
    except ValueError as error:
        raise InputError(
            str(error), where=str(path), remedy="Use another copy of the file, or export it again."
        ) from error
    metres = metres_per(content.units, f"{path}, POINT:UNITS")
    turn = stated.world_from_file
    world_from_file = _world_from_screen(content, path) if turn is None else turn
    columns = landmark_columns(content.labels, stated.names, f"{path}, POINT:LABELS")
    count = len(content.points)
    points = np.full((count, len(LANDMARKS), 3), np.nan)
    for name, column in columns.items():
        points[:, LANDMARKS.index(name)] = metres * content.points[:, column] @ world_from_file.T
    frame = np.arange(content.first_frame, content.first_frame + count, dtype=np.int64)
    return LandmarkTrajectory(frame, points), content.rate


def _world_from_screen(content: _C3DContent, path: Path) -> FloatArray:
    """Rotation (3, 3) from the file's axes, of which the screen's vertical one points up."""
    up, east = axis_in(content.vertical or "+Z"), axis_in(content.right or "+X")
    if up is None:
        raise InputError(
            f"{content.vertical!r} is not an axis",
            where=f"{path}, POINT:Y_SCREEN",
            remedy="State the axes that point east, north and up with --axes.",
        )
    return world_from_up(up, east)
