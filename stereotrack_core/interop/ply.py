"""PLY, for clouds: binary, with the view of every point as a number and as a colour."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray
from stereotrack_core.atomic import write_file

_COLOURS = "0072B2 E69F00 009E73 CC79A7 56B4E9 D55E00 F0E442 8C8C8C"
VIEW_COLOURS: ImageArray = np.frombuffer(bytes.fromhex(_COLOURS), np.uint8).reshape(-1, 3)
"""RGB of the views in their order (Okabe-Ito, safe for colour-blind eyes); repeats after 8."""

_VERTEX = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
    + [("view", "u1")]
)
_PLY_TYPES = {"<f4": "float", "|u1": "uchar"}


def write_cloud(
    path: Path, points: FloatArray, view: IntArray, view_names: Sequence[str], frame: int
) -> None:
    """Write points (N, 3), world, metres, with the index (N,) of the view, names in comments."""
    vertices = np.empty(len(points), dtype=_VERTEX)
    for k, name in enumerate(("x", "y", "z")):
        vertices[name] = points[:, k]
    colours = VIEW_COLOURS[view % len(VIEW_COLOURS)]
    for k, name in enumerate(("red", "green", "blue")):
        vertices[name] = colours[:, k]
    vertices["view"] = view
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment unit: metre, world frame of the recording",
        f"comment frame: {frame}",
        *(f"comment view {k}: {name}" for k, name in enumerate(view_names)),
        f"element vertex {len(vertices)}",
    ]
    fields = _VERTEX.names or ()
    header += [f"property {_PLY_TYPES[_VERTEX[name].str]} {name}" for name in fields]
    header.append("end_header")
    write_file(path, ("\n".join(header) + "\n").encode() + vertices.tobytes())
