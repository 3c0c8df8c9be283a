"""C3D, the binary landmark file of motion laboratories.

Positions are in millimetres, z up (``POINT:X_SCREEN`` +X, ``POINT:Y_SCREEN`` +Z). An unknown
landmark is NaN with residual -1, which other readers take as missing. The format stores
single precision and counts frames with 16 bits; frame numbers are the recording's.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.interop.c3d_layout import C3DContent, parse_c3d
from stereotrack_core.interop.gaps import checked_fps, contiguous
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_LAST_FRAME = 0xFFFF - 1
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


def write_c3d(
    path: Path, trajectory: LandmarkTrajectory, fps: float, residual: FloatArray | None = None
) -> None:
    """Write landmarks, and the tracker's residual as the residual of every point.

    Parameters
    ----------
    path : Path
    trajectory : LandmarkTrajectory
        Frames between its frames are written as missing.
    fps : float
        Frames per second.
    residual : (F,) float64, metres, optional
        The format keeps whole millimetres of it.

    Raises
    ------
    InputError
        For a frame number that the format cannot count.
    """
    frame = trajectory.frame
    if len(frame) and (frame[0] < 0 or frame[-1] > _LAST_FRAME):
        raise InputError(
            f"C3D counts frames up to {_LAST_FRAME}",
            where=str(path),
            remedy="Write a part of the run, or another format.",
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

    Raises
    ------
    InputError
        For a damaged file, other axes, an unknown unit, or a file without any of the nine
        landmarks.
    """
    try:
        content = parse_c3d(read_bytes(path, TABLE_BYTES))
    except ValueError as error:
        raise InputError(
            str(error), where=str(path), remedy="Take another copy of it, or export it again."
        ) from error
    metres = _metres(path, content)
    known = [name for name in LANDMARKS if name in content.labels]
    if not known:
        raise InputError(
            "none of the nine landmarks is in the file",
            where=f"{path}, POINT:LABELS",
            remedy=f"The points are named {', '.join(LANDMARKS)}.",
        )
    count = len(content.points)
    points = np.full((count, len(LANDMARKS), 3), np.nan)
    for name in known:
        points[:, LANDMARKS.index(name)] = metres * content.points[:, content.labels.index(name)]
    frame = np.arange(content.first_frame, content.first_frame + count, dtype=np.int64)
    return LandmarkTrajectory(frame, points), content.rate


def _metres(path: Path, content: C3DContent) -> float:
    """Metres per unit; refuses units and axes that would be taken wrongly."""
    metres = _METRES.get(content.units)
    if metres is None:
        raise InputError(
            f"the unit {content.units!r} is not known",
            where=f"{path}, POINT:UNITS",
            remedy="Write m or mm.",
        )
    if content.vertical not in ("", "+Z"):
        raise InputError(
            f"the vertical axis is {content.vertical}",
            where=f"{path}, POINT:Y_SCREEN",
            remedy="Turn the data so that z is up and write +Z.",
        )
    return metres
