"""Names for the array types that cross borders between rooms, and stretches in flags."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
Float32Array: TypeAlias = NDArray[np.float32]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
Int8Array: TypeAlias = NDArray[np.int8]
ImageArray: TypeAlias = NDArray[np.uint8]


def stretches_of(flags: BoolArray, frame: IntArray | None = None) -> list[range]:
    """Where flags (N,), of successive frames (N,), are set one after the other, as index ranges."""
    places = np.flatnonzero(flags)
    steps = np.diff(places if frame is None else frame[places])
    parts = np.split(places, np.flatnonzero(steps > 1) + 1)
    return [range(int(part[0]), int(part[-1]) + 1) for part in parts if len(part)]
