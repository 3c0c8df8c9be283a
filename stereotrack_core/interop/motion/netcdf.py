"""NetCDF as the package movement keeps poses (https://movement.neuroinformatics.dev).

One dataset with ``position`` (time, space, keypoints, individuals) and ``confidence``, by the
optional libraries xarray and h5netcdf. Positions are metres in the recording's world: x to the
east, y to the north, z up. ``time`` is seconds since the recording's frame 0; every frame between
the first and the last has a row, and what is not known is NaN. The confidence is 1 minus the
probability that the landmark's limb has failed, 1 where nothing states that, and 0 where the
landmark is not known: movement's ``filter_by_confidence`` removes all points whose it is NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop.file_axes import FileAxes
from stereotrack_core.interop.hdf5 import read_hdf5
from stereotrack_core.interop.landmark_file import (
    Stated,
    checked_fps,
    contiguous,
    metres_per,
)
from stereotrack_core.interop.markers import Markers, landmarks_in_world
from stereotrack_core.reading import decoding
from stereotrack_core.recording.frame_times import on_frames, row_times
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tables import LARGEST
from stereotrack_core.versions import extra_library

_WHAT = "this is not a netCDF file of poses of the package movement"
_REMEDY = "Use a file that movement has saved with `to_netcdf`, in the format NETCDF4."
_AXES = "x east, y north, z up; left and right are the person's"
_DIMENSIONS = ("time", "space", "keypoints", "individuals")
PERSON = "person"
"""Name of the one individual."""


def write_netcdf(
    path: Path, trajectory: LandmarkTrajectory, fps: float, confidence: FloatArray | None = None
) -> None:
    """Write landmarks; `fps` in frames per second, `confidence` (F, 9) from 0 to 1 or NaN.

    InputError for a trajectory without frames or with few in a long stretch, where the file cannot
    be written, or xarray is not installed.
    """
    fps = checked_fps(fps)
    first, points = contiguous(trajectory, str(path))
    xarray = netcdf_library(path)
    sure = np.ones(points.shape[:2])
    if confidence is not None:
        sure[trajectory.frame - first] = np.nan_to_num(confidence, nan=1.0)
    sure[np.isnan(points).any(axis=2)] = 0.0
    frame = np.arange(first, first + len(points))
    dataset = xarray.Dataset(
        {
            "position": (_DIMENSIONS, points.transpose(0, 2, 1)[..., None]),
            "confidence": ((_DIMENSIONS[0], *_DIMENSIONS[2:]), sure[..., None]),
        },
        coords={
            "time": frame / fps,
            "space": ["x", "y", "z"],
            "keypoints": list(LANDMARKS),
            "individuals": [PERSON],
            "frame": ("time", frame),
        },
        attrs={
            "ds_type": "poses",
            "source_software": "stereotrack",
            "fps": fps,
            "time_unit": "seconds",
            "space_unit": "m",
            "axes": _AXES,
        },
    )
    data = BytesIO()
    dataset.to_netcdf(data, engine="h5netcdf")
    write_file(path, data.getvalue())


class _Poses(NamedTuple):
    """What a file holds of one individual."""

    keypoints: Sequence[str]
    points: FloatArray  # (F, N, 2 or 3)
    time: FloatArray  # (F,)
    attributes: dict[str, str]
    individuals: Sequence[str]


def read_netcdf(path: Path, stated: Stated | None = None) -> tuple[LandmarkTrajectory, float]:
    """Landmarks and frame rate of a file of poses in space, its keypoints matched by name.

    Frames follow from the times and the frame rate.

    InputError for a damaged file, one of pictures, of several individuals or without unit or rate,
    or where xarray is not installed.
    """
    netcdf_library(path)
    poses = read_hdf5(path, _stored, _WHAT, _REMEDY)
    if poses.points.shape[-1] != 3:
        raise InputError(
            "its poses are pixels of a picture, not points in space",
            where=str(path),
            remedy="Triangulate them first.",
        )
    if len(poses.individuals) != 1:
        raise InputError(
            f"it has poses of {len(poses.individuals)} individuals "
            f"({', '.join(poses.individuals)})",
            where=str(path),
            remedy="Select one with movement, `ds.sel(individuals=[NAME])`, and save that.",
        )
    metres = metres_per(poses.attributes.get("space_unit", ""), f"{path}, space_unit")
    fps = checked_fps(_number(poses.attributes.get("fps", "")))
    in_seconds = poses.attributes.get("time_unit") != "frames"
    seconds = poses.time if in_seconds else poses.time / fps
    if not np.isfinite(seconds).all() or (np.diff(seconds) <= 0).any():
        raise InputError(
            "its times do not follow one another", where=f"{path}, time", remedy=_REMEDY
        )
    start = np.clip(seconds[:1].sum() * fps, -LARGEST, LARGEST)
    number = np.arange(len(seconds)) + round(float(start))
    rows = row_times(number, seconds, fps, str(path))
    own = poses.attributes.get("axes") == _AXES
    axes = FileAxes(np.eye(3), "as stated in axes" if own else "which the file does not state")
    markers = Markers(poses.keypoints, metres * poses.points, axes, path, "keypoints")
    points, notes = landmarks_in_world(markers, stated or Stated())
    frame, points = on_frames(rows, points, str(path))
    return LandmarkTrajectory(frame, points, rows.fps, (*rows.notes, *notes)), rows.fps or fps


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _stored(path: Path) -> _Poses:
    """What the file holds, in this process."""
    with decoding(path, _WHAT, _REMEDY):
        xarray = netcdf_library(path)
        with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as dataset:
            position = dataset["position"]
            if "individuals" not in position.dims:
                position = position.expand_dims("individuals")
            order = ("time", "keypoints", "space", "individuals")
            array = np.asarray(position.transpose(*order).values, dtype=np.float64)
            names = {one: [str(x) for x in position[one].values] for one in order[1::2]}
            attributes = {str(key): str(value) for key, value in dataset.attrs.items()}
            time = np.asarray(position["time"].values, dtype=np.float64)
        return _Poses(names["keypoints"], array[..., 0], time, attributes, names["individuals"])


def netcdf_library(path: Path) -> Any:
    """The library xarray, which writes by h5netcdf; InputError where one is not installed."""
    missing, where, instead = (
        "netCDF files need the library {}, which is not installed",
        str(path),
        "csv",
    )
    for_h5netcdf, for_xarray = missing.format("h5netcdf"), missing.format("xarray")
    extra_library("h5netcdf", "movement", missing=for_h5netcdf, where=where, instead=instead)
    return extra_library("xarray", "movement", missing=for_xarray, where=where, instead=instead)
