"""MOT, the motion file of OpenSim: joint angles in degrees over time.

The columns have this program's names of the angles (docs/angles.md); the coordinates of a model of
OpenSim have names of their own. Time is the recording's frame over the frame rate, and every frame
from the first to the last has a row. OpenSim stops reading a motion at the first value that is no
number: an angle that is never known has no column, one that is not known in some frames stays as it
was last known, and a file of the same name with ``.json`` behind it lists both.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import write_files
from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import checked_fps, every_frame, held


def write_mot(
    path: Path, frame: IntArray, names: Sequence[str], angle: FloatArray, fps: float
) -> int:
    """Write angles (F, A), radians, of frames (F,), and ``<path>.json``; how many had to be held.

    The header is that of version 1 of OpenSim's storage files, with ``inDegrees=yes``. `fps` in
    frames per second.

    InputError where no angle is known in any frame, there are few frames in a long stretch, or a
    file cannot be written.
    """
    fps = checked_fps(fps)
    columns = np.flatnonzero(np.isfinite(angle).any(axis=0)).tolist()
    if not len(columns):
        raise InputError(
            "no joint angle is known in any frame",
            where=str(path),
            remedy="Track at least one frame.",
        )
    first, values = every_frame(frame, angle[:, columns], str(path))
    frame = np.arange(first, first + len(values))
    kept, missing = [names[k] for k in columns], ~np.isfinite(values)
    header = [
        " ".join(path.stem.split()) or "angles",
        "version=1",
        f"nRows={len(frame)}",
        f"nColumns={1 + len(kept)}",
        "inDegrees=yes",
        "endheader",
    ]
    rows = [("time", *kept)]
    degrees = np.degrees(held(values, missing))
    for number, row in zip(frame.tolist(), degrees.tolist(), strict=True):
        rows.append((f"{number / fps:.10g}", *(f"{value:.8g}" for value in row)))
    notes = {
        "unit": "degrees",
        "frames_per_second": fps,
        "first_frame": first,
        "angles_never_known": [name for name in names if name not in kept],
        "frames_with_held_angles": {
            name: frame[missing[:, k]].tolist()
            for k, name in enumerate(kept)
            if missing[:, k].any()
        },
    }
    beside = path.with_name(path.name + ".json")
    text = "\n".join([*header, *map("\t".join, rows)]) + "\n"
    write_files({path: text, beside: json.dumps(notes, indent=2) + "\n"})
    return int(missing.sum())
