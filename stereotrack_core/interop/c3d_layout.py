"""The bytes of a C3D file, read so that no damage can do more than raise an error.

ezc3d, which writes our files, ends the whole program on some damaged ones; hence this reader.
Layout after the C3D User Guide (www.c3d.org): a header of 512 bytes, a section of parameters,
and frames of points as single floats or scaled 16-bit integers.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray

_BLOCK = 512
_MAGIC = 0x50
_INTEL = 84
_BYTES = {-1: 1, 1: 1, 2: 2, 4: 4}


@dataclass(frozen=True, eq=False)
class C3DContent:
    """What a file holds of points.

    Attributes
    ----------
    first_frame : int
        Counted from 0, as ezc3d does; the file counts from 1.
    rate : float
        Frames per second.
    units : str
    vertical : str
        ``POINT:Y_SCREEN``, empty where not stated.
    labels : tuple of str
    points : (F, N, 3) float64
        In `units`; NaN where marked as missing.
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


def parse_c3d(data: bytes) -> C3DContent:
    """Parse the bytes of a file of the Intel kind, which all common programs write.

    Raises
    ------
    ValueError
        Where they are not such a file, or end too early; the text says what is wrong.
    """
    if len(data) < _BLOCK or data[1] != _MAGIC:
        raise ValueError("this is not a C3D file")
    try:
        parameters = _parameters(data, _BLOCK * (data[0] - 1))
        return _content(data, parameters)
    except (struct.error, IndexError, KeyError, OverflowError) as error:
        raise ValueError("the file is damaged") from error


def _content(data: bytes, parameters: dict[str, _Parameter]) -> C3DContent:
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
    texts = {name: parameters[name].texts() for name in ("UNITS", "LABELS", "Y_SCREEN")
             if name in parameters}  # fmt: skip
    labels = texts.get("LABELS", ())
    if len(labels) < count:
        raise ValueError("there are points without a label")
    return C3DContent(
        first_frame=first - 1,
        rate=rate,
        units="".join(texts.get("UNITS", ())[:1]),
        vertical="".join(texts.get("Y_SCREEN", ())[:1]),
        labels=labels[:count],
        points=points,
    )


def _parameters(data: bytes, start: int) -> dict[str, _Parameter]:
    """Parameters of the group POINT by name."""
    if start < 0 or data[start + 3] != _INTEL:
        raise ValueError("the file is damaged or comes from a processor that is not known here")
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
    length = _BYTES[kind]
    for size in sizes:
        length *= size
    if begin + length > len(data):
        raise ValueError("the file is damaged")
    return _Parameter(kind, sizes, data[begin : begin + length])
