"""TRC, the landmark table of OpenSim and Pose2Sim.

The file is y-up, with x to the north and z to the east: (X, Y, Z) = (y, z, x) of this
program's world, as Pose2Sim writes it. Frame numbers are the recording's, time is frame over
frame rate, an unknown landmark is NaN, and so is a whole frame of a gap: OpenSim refuses a row
whose last values are blank. Blanks are read as well. Columns are separated by tabs, or by commas
where other programs do so.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import (
    Stated,
    checked_fps,
    contiguous,
    landmark_columns,
    metres_per,
    world_from_up,
)
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tables import guarded, read_cells, whole_number

_TRC_FROM_WORLD = [1, 2, 0]
_Y_UP = np.array([0.0, 1.0, 0.0])


def write_trc(path: Path, trajectory: LandmarkTrajectory, fps: float) -> None:
    """Write landmarks in metres; `fps` in frames per second.

    Frames between those of the trajectory are written without a known landmark.

    InputError where there are few frames in a long stretch.
    """
    fps = checked_fps(fps)
    first, points = 0, trajectory.points
    if len(trajectory.frame):
        first, points = contiguous(trajectory, str(path))
    rate, count = f"{fps:.10g}", len(points)
    fields = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"]
    fields += ["OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"]
    facts = [rate, rate, str(count), str(len(LANDMARKS)), "m", rate, str(first), str(count)]
    names = [cell for name in LANDMARKS for cell in (name, "", "")]
    axes = [f"{axis}{k}" for k in range(1, len(LANDMARKS) + 1) for axis in "XYZ"]
    rows = [
        ["PathFileType", "4", "(X/Y/Z)", guarded(" ".join(path.name.split()))],
        fields,
        facts,
        ["Frame#", "Time", *names],
        ["", "", *axes],
    ]
    cells = points[..., _TRC_FROM_WORLD].reshape(count, len(LANDMARKS) * 3).tolist()
    for frame, values in enumerate(cells, start=first):
        rows.append(
            [
                str(frame),
                f"{frame / fps:.10g}",
                *(repr(value) if np.isfinite(value) else "NaN" for value in values),
            ]
        )
    write_file(path, "".join("\t".join(row) + "\n" for row in rows))


def read_trc(path: Path, stated: Stated | None = None) -> tuple[LandmarkTrajectory, float]:
    """Landmarks and frame rate of a TRC file, its columns matched by name.

    Landmarks that the file lacks are NaN; columns with other names are left out.

    InputError for a damaged file, an unknown unit, or a file without any of the nine landmarks.
    """
    stated = stated or Stated()
    lines = read_cells(path, delimiter="\t", quoting=csv.QUOTE_NONE)
    if lines and "".join(lines[0][:1]).startswith("PathFileType,"):
        lines = read_cells(path, headers=5)
    if len(lines) < 5 or lines[0][:1] != ["PathFileType"]:
        raise InputError(
            "this is not a TRC file",
            where=str(path),
            remedy="Use a file whose first line begins with PathFileType.",
        )
    facts = dict(zip(lines[1], lines[2], strict=False))
    metres = metres_per(facts.get("Units", ""), f"{path}, Units")
    columns = landmark_columns(lines[3][2:], stated.names, f"{path}, line 4")
    rate = facts.get("DataRate", "")
    try:
        fps = checked_fps(float(rate))
    except ValueError:
        raise InputError(
            f"{rate!r} is not a frame rate",
            where=f"{path}, DataRate",
            remedy="Write a number of frames per second.",
        ) from None
    found = _frames(path, lines[5:], columns)
    count = facts.get("NumFrames", "")
    if count.isdecimal() and len(found) < int(count):
        raise InputError(
            f"the file ends after {len(found)} of its {count} frames",
            where=str(path),
            remedy="Use another copy of the file, or export it again.",
        )
    frames = sorted(found)
    points = np.array([found[frame] for frame in frames]).reshape(-1, len(LANDMARKS), 3)
    turn = stated.world_from_file
    world_from_file = world_from_up(_Y_UP) if turn is None else turn
    world = metres * points @ world_from_file.T
    return LandmarkTrajectory(np.array(frames, dtype=np.int64), world), fps


def _frames(path: Path, lines: list[list[str]], columns: dict[str, int]) -> dict[int, FloatArray]:
    """Landmarks (9, 3) by frame, in the file's unit and axes."""
    found: dict[int, FloatArray] = {}
    for number, line in enumerate(lines, start=6):
        if any(line):
            frame = whole_number(line[0], path, number, "frame")
            if frame in found:
                raise InputError(
                    f"line {number} repeats frame {frame}",
                    where=str(path),
                    remedy="Delete one of the two lines.",
                )
            try:
                found[frame] = _row(line, columns)
            except ValueError as error:
                raise InputError(
                    f"line {number} has a value that is not a number ({error})",
                    where=str(path),
                    remedy="Write numbers with decimal points. Leave unknown values empty.",
                ) from None
    return found


def _row(line: list[str], columns: dict[str, int]) -> FloatArray:
    points: FloatArray = np.full((len(LANDMARKS), 3), np.nan)
    for name, column in columns.items():
        cells = line[2 + column : 5 + column]
        if len(cells) == 3 and all(cells):
            place = np.array([float(cell) for cell in cells])
            points[LANDMARKS.index(name)] = place if np.isfinite(place).all() else np.nan
    return points
