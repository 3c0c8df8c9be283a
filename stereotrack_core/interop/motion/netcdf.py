"""NetCDF as the package movement keeps poses (https://movement.neuroinformatics.dev).

One dataset with ``position`` (time, space, keypoints, individuals) and ``confidence``, by the
optional libraries xarray and h5netcdf. Positions are metres in the recording's world: x to the
east, y to the north, z up. ``time`` is seconds since the recording's frame 0; every frame between
the first and the last has a row, and what is not known is NaN. Nothing here gives a point a
confidence, which is NaN throughout, as movement has it where a source has none.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.atomic import write_file
from stereotrack_core.interop.landmark_file import checked_fps, contiguous
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.versions import extra_library

_DIMENSIONS = ("time", "space", "keypoints", "individuals")
PERSON = "person"
"""Name of the one individual."""


def write_netcdf(path: Path, trajectory: LandmarkTrajectory, fps: float) -> None:
    """Write landmarks; `fps` in frames per second.

    InputError for a trajectory without frames or with few in a long stretch, where the file cannot
    be written, or xarray is not installed.
    """
    fps = checked_fps(fps)
    first, points = contiguous(trajectory, str(path))
    xarray = netcdf_library(path)
    frame = np.arange(first, first + len(points))
    dataset = xarray.Dataset(
        {
            "position": (_DIMENSIONS, points.transpose(0, 2, 1)[..., None]),
            "confidence": (
                (_DIMENSIONS[0], *_DIMENSIONS[2:]),
                np.full((len(points), len(LANDMARKS), 1), np.nan),
            ),
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
            "axes": "x east, y north, z up; left and right are the person's",
        },
    )
    data = BytesIO()
    dataset.to_netcdf(data, engine="h5netcdf")
    write_file(path, data.getvalue())


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
