"""Names for the array types that cross borders between rooms, and stretches in flags."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
Float32Array: TypeAlias = NDArray[np.float32]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
ImageArray: TypeAlias = NDArray[np.uint8]


def stretches_of(flags: BoolArray) -> list[range]:
    """Where flags (N,) are set one after the other, as ranges of indices."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return [range(int(first), int(end)) for first, end in edges.reshape(-1, 2)]
