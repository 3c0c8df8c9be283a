"""C3D, the binary landmark file of motion laboratories.

Files of Intel, DEC and MIPS processors are read, with the axes that ``POINT:X_SCREEN`` and
``POINT:Y_SCREEN`` state; written are Intel's, in millimetres, z up (``X_SCREEN`` +X, ``Y_SCREEN``
+Z). An unknown landmark is NaN with residual -1, which other readers take as missing. The format
stores single precision; frame numbers are the recording's. Its header counts frames with 16 bits:
beyond that the group TRIAL and ``POINT:LONG_FRAMES`` count them.
"""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import replacing
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.interop import landmark_file
from stereotrack_core.interop.markers import Markers, landmarks_in_world
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_BLOCK = 512
_LARGEST_WORD = 0xFFFF
_WORDS, _FLOATS = 2, 4  # types of parameters
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
        """Numbers of four bytes; a VAX exchanges halves, its exponent is larger by two."""
        if self.vax_floats:
            halves = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(halves).view("<f4")[:, 0].astype(np.float64) / 4.0
        return np.frombuffer(data, f"{self.order}f4").astype(np.float64)


_PROCESSORS = {84: _Processor(), 85: _Processor(vax_floats=True), 86: _Processor(order=">")}
"""Of Intel, DEC and MIPS, by the code of the file."""


class _C3DContent(NamedTuple):
    """What a file holds."""

    first_frame: int  # counted from 0, as ezc3d does, though the file counts from 1
    rate: float
    texts: Mapping[str, str]  # parameters of :data:`_TEXTS` that are stated
    labels: tuple[str, ...]  # empty of points without one
    points: FloatArray  # (F, N, 3), in its unit; NaN where marked as missing
    notes: tuple[str, ...]


_TEXTS = ("POINT:UNITS", "POINT:X_SCREEN", "POINT:Y_SCREEN")


@dataclass(frozen=True)
class _Parameter:
    """One parameter's type (-1 text, 1 byte, 2 integer, 4 float), sizes and bytes."""

    kind: int
    sizes: tuple[int, ...]
    data: bytes

    def texts(self) -> tuple[str, ...]:
        width = self.sizes[0] if self.sizes else 1
        parts = [self.data[k : k + width] for k in range(0, len(self.data), max(width, 1))]
        return tuple(part.decode("utf-8", "replace").strip("\0 ") for part in parts)

    def number(self, processor: _Processor) -> int:
        """Its whole number, of one word or of a low and a high one, also as floats; 0 if none."""
        if self.kind not in (_WORDS, _FLOATS):
            return 0
        read = processor.integers if self.kind == _WORDS else processor.floats
        words = np.nan_to_num(read(self.data)[:2].astype(np.float64))
        words = np.where(words < 0.0, words + _LARGEST_WORD + 1.0, words)
        total = float(words @ [1.0, _LARGEST_WORD + 1.0][: len(words)])
        return int(total) if 0.0 <= total < 2**31 else 0


def _parse_c3d(data: bytes) -> _C3DContent:
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
    count, analog = (processor.unsigned(data, at) for at in (2, 4))
    scale, rate = (float(processor.floats(data[at : at + 4])[0]) for at in (12, 20))
    if not 0 < rate < np.inf or not np.isfinite(scale):
        raise ValueError("the file is damaged")
    numbers, width = (processor.floats, 4) if scale < 0 else (processor.integers, 2)
    begin = _BLOCK * (processor.unsigned(data, 16) - 1)
    row = (4 * count + analog) * width
    if begin < _BLOCK:
        raise ValueError("the file is damaged")
    stated = {n: parameters[n].number(processor) for n in _FRAME_COUNTS if n in parameters}
    header = processor.unsigned(data, 6), processor.unsigned(data, 8)
    first, frames, notes = _stretch(header, stated, len(data) - begin, row)
    rate, about_rate = _rate_of(rate, parameters.get("POINT:RATE"), processor)
    values = numbers(data[begin : begin + frames * row]).reshape(frames, 4 * count + analog)
    rows = values[:, : 4 * count].reshape(frames, count, 4).astype(np.float64)
    points = rows[..., :3] if scale < 0 else rows[..., :3] * scale
    points[(rows[..., 3] < 0) | ~np.isfinite(points).all(axis=-1)] = np.nan
    texts = {name: "".join(parameters[name].texts()[:1]) for name in _TEXTS if name in parameters}
    labels, notes = _labels(parameters, count), (*about_rate, *notes)
    if unlabelled := labels.count(""):
        notes += (f"{counted(unlabelled, 'point')} of {count} without a label left out",)
    return _C3DContent(first, rate, texts, labels, points, notes)


def _rate_of(
    in_header: float, stated: _Parameter | None, processor: _Processor
) -> tuple[float, tuple[str, ...]]:
    """Frames per second, and notes: ``POINT:RATE`` goes before the header, as in the standard."""
    floats = stated is not None and stated.kind == _FLOATS
    rate = float(processor.floats(stated.data)[0]) if stated and floats else 0.0
    if not 0 < rate < np.inf or abs(rate - in_header) <= 1e-3 * rate:
        return in_header, ()
    return rate, (f"{rate:g} frames per second by POINT:RATE; the header states {in_header:g}",)


_FRAME_COUNTS = (
    "TRIAL:ACTUAL_START_FIELD",
    "TRIAL:ACTUAL_END_FIELD",
    "POINT:LONG_FRAMES",
    "POINT:FRAMES",
)


def _stretch(
    header: tuple[int, int], stated: Mapping[str, int], size: int, row: int
) -> tuple[int, int, tuple[str, ...]]:
    """First frame, counted from 0, number of frames, and notes; ValueError if `size` does not fit.

    `header` states the first and the last frame, counted from 1. It holds if ``POINT:FRAMES``
    agrees and nothing states more than 16 bits can. Otherwise the first statement holds that fits
    into the `size` of the data with their `row` bytes a frame.
    """
    first, last = header
    start, end, long_frames, point_frames = (stated.get(name, 0) for name in _FRAME_COUNTS)
    room = size // row if row else 0
    in_header = last - first + 1
    trial = end - start + 1 if 0 < start <= end else 0
    overflown = _LARGEST_WORD in (last, point_frames) or start > _LARGEST_WORD
    overflown = overflown or any(_LARGEST_WORD < one <= room for one in (trial, long_frames))
    statements = {"the header": in_header}
    if in_header and (overflown or in_header > room or point_frames not in (0, in_header)):
        others = {"the group TRIAL": trial, "POINT:LONG_FRAMES": long_frames}
        others |= {"POINT:FRAMES": point_frames, **statements}
        statements = {name: value for name, value in others.items() if value}
    source = next((name for name, value in statements.items() if 0 <= value <= room), "")
    if not source:
        raise ValueError("the file ends before its last frame")
    frames = statements[source]
    if frames <= _LARGEST_WORD < room and size - frames * row >= _BLOCK:
        raise ValueError("the file is longer than the frames that it counts")
    notes = []
    if frames != in_header:
        notes.append(f"{counted(frames, 'frame')} by {source}; the header states {in_header}")
    if start in (0, first) or frames != trial:
        return first - 1, frames, tuple(notes)
    if start <= _LARGEST_WORD:  # it goes before the header's number of 16 bits
        begins = f"begins at frame {start} by TRIAL:ACTUAL_START_FIELD"
        notes.append(f"{begins}; the header states {first}")
    return start - 1, frames, tuple(notes)


def _labels(parameters: Mapping[str, _Parameter], count: int) -> tuple[str, ...]:
    """Labels of all points; an array holds at most 255, the next ones are LABELS2, LABELS3 ..."""
    arrays = (parameters.get(f"POINT:LABELS{n if n > 1 else ''}") for n in range(1, count + 1))
    labels = [text for array in takewhile(bool, arrays) if array for text in array.texts()]
    return tuple((labels + [""] * count)[:count])


def _parameters(data: bytes, start: int, processor: _Processor) -> dict[str, _Parameter]:
    """Parameters by their group and name, such as ``POINT:LABELS``."""
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
    return {f"{groups.get(group, '')}:{name}": parameter for group, name, parameter in found}


def _parameter(data: bytes, at: int) -> _Parameter:
    kind, dimensions = struct.unpack_from("<bB", data, at)
    sizes = tuple(data[at + 2 : at + 2 + dimensions])
    begin = at + 2 + dimensions
    length = _BYTES[kind] * math.prod(sizes)
    if begin + length > len(data):
        raise ValueError("the file is damaged")
    return _Parameter(kind, sizes, data[begin : begin + length])


_LAST_FRAME = 2**31 - 2
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
        what = f"C3D counts frames from 0 to {_LAST_FRAME}"
        raise InputError(what, path, "Export part of the run, or use another format.")
    first, points = landmark_file.contiguous(trajectory, str(path))
    residuals = np.zeros(points.shape[:2])
    if residual is not None:
        millimetres = np.clip(np.nan_to_num(1000.0 * residual), 0.0, _LARGEST_RESIDUAL)
        residuals[trajectory.frame - first] = millimetres.reshape(len(frame), -1)
    file = _new_file(landmark_file.checked_fps(fps), first, len(points))
    file["data"]["points"] = np.ones((4, len(LANDMARKS), len(points)))
    file["data"]["points"][:3] = 1000.0 * points.transpose(2, 1, 0)
    missing = np.isnan(points).any(axis=-1).T
    file["data"]["meta_points"]["residuals"] = np.where(missing, -1.0, residuals.T)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *missing.shape), dtype=np.bool_)

    def is_whole(written: Path) -> bool:  # ezc3d says nothing where the drive is full
        found = _parse_c3d(read_bytes(written, TABLE_BYTES))
        same = len(found.points) == len(points) and found.first_frame == first
        return same and np.allclose(found.points / 1000.0, points, equal_nan=True)

    with replacing(path, is_whole) as temporary:
        file.write(str(temporary))


def _new_file(fps: float, first: int, frames: int) -> Any:
    import ezc3d

    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"] = [fps]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = list(LANDMARKS)
    file.add_parameter("POINT", "X_SCREEN", "+X")
    file.add_parameter("POINT", "Y_SCREEN", "+Z")
    file["header"]["points"]["first_frame"] = first
    if first + frames >= _LARGEST_WORD:
        for name, number in (("START", first + 1), ("END", first + frames)):
            field = f"ACTUAL_{name}_FIELD"
            file.add_parameter("TRIAL", field, [0, 0])
            words = np.array([number & _LARGEST_WORD, number >> 16])
            # a list would be stored as floats, which Vicon's programs do not expect
            file["parameters"]["TRIAL"][field] |= {"type": _WORDS, "value": words}
        file.add_parameter("POINT", "LONG_FRAMES", [float(frames)])
    return file


def read_c3d(path: Path, stated: landmark_file.Stated) -> LandmarkTrajectory:
    """Landmarks of a C3D file, matched by name and NaN where lacking.

    Up and east are where the file's screen has them, else z and x. InputError for a damaged file,
    unknown axes or unit, or a file without any of the nine landmarks.
    """
    try:
        content = _parse_c3d(read_bytes(path, TABLE_BYTES))
    except ValueError as error:
        what = str(error)
        raise InputError(what, path, "Use another copy of the file, or export it again.") from error
    metres = landmark_file.metres_per(content.texts.get("POINT:UNITS", ""), f"{path}, POINT:UNITS")
    stated_axes = stated.world_from_file is not None
    axes = landmark_file.FileAxes(np.eye(3), "") if stated_axes else _axes_of_screen(content, path)
    markers = Markers(content.labels, metres * content.points, axes, path, "POINT:LABELS")
    points, notes = landmarks_in_world(markers, stated)
    notes = (*(Finding("note", str(path), note, "") for note in content.notes), *notes)
    frame = np.arange(content.first_frame, content.first_frame + len(points), dtype=np.int64)
    return LandmarkTrajectory(frame, points, content.rate, notes)


def _axes_of_screen(content: _C3DContent, path: Path) -> landmark_file.FileAxes:
    """Axes of a file, of which the screen's vertical one points up and its right one east."""
    screen = {name: content.texts.get(name, "") for name in ("POINT:X_SCREEN", "POINT:Y_SCREEN")}
    right, vertical = screen.values()
    east, up = landmark_file.axis_in(right or "+X"), landmark_file.axis_in(vertical or "+Z")
    if up is None:
        remedy = "State the axes that point east, north and up with --axes."
        raise InputError(f"{vertical!r} is not an axis", f"{path}, POINT:Y_SCREEN", remedy)
    given = [name for name, text in screen.items() if text]
    words = f"as stated by {' and '.join(given)}" if given else "as usual in C3D"
    return landmark_file.FileAxes(landmark_file.world_from_up(up, east), words)
