"""TRC, the landmark table of OpenSim and Pose2Sim.

The file is y-up, with x to the north and z to the east: (X, Y, Z) = (y, z, x) of this
program's world, as Pose2Sim writes it. Written frame numbers are the recording's and time is frame
over frame rate; other programs count frames from 1, so times decide. An unknown landmark is NaN,
and so is a whole frame of a gap: OpenSim refuses a row whose last values are blank. Blanks are read
as well. Columns are separated by tabs, or by commas or blanks where other programs do so.
"""

import csv
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop import landmark_file
from stereotrack_core.interop.markers import Markers, landmarks_in_world
from stereotrack_core.recording.frame_times import on_frames, row_times
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tables import guarded, read_cells, whole_number

_TRC_FROM_WORLD = [1, 2, 0]
_Y_UP = np.array([0.0, 1.0, 0.0])


def write_trc(path: Path, trajectory: LandmarkTrajectory, fps: float) -> None:
    """Write landmarks in metres at `fps`; gaps are frames without a known landmark."""
    fps = landmark_file.checked_fps(fps)
    first, points = 0, trajectory.points
    if len(trajectory.frame):
        first, points = landmark_file.contiguous(trajectory, str(path))
    rate, count = f"{fps:.10g}", len(points)
    fields = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"]
    fields += ["OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"]
    rows = [
        ["PathFileType", "4", "(X/Y/Z)", guarded(" ".join(path.name.split()))],
        fields,
        [rate, rate, str(count), str(len(LANDMARKS)), "m", rate, str(first), str(count)],
        ["Frame#", "Time", *(cell for name in LANDMARKS for cell in (name, "", ""))],
        ["", "", *(f"{axis}{k}" for k in range(1, len(LANDMARKS) + 1) for axis in "XYZ")],
    ]
    cells = points[..., _TRC_FROM_WORLD].reshape(count, len(LANDMARKS) * 3).tolist()
    for frame, values in enumerate(cells, start=first):
        numbers = [repr(value) if np.isfinite(value) else "NaN" for value in values]
        rows.append([str(frame), f"{frame / fps:.10g}", *numbers])
    write_file(path, "".join("\t".join(row) + "\n" for row in rows))


def read_trc(path: Path, stated: landmark_file.Stated) -> LandmarkTrajectory:
    """Landmarks by name, NaN where lacking; InputError for a damaged file, or none of the nine."""
    lines = read_cells(path, delimiter="\t", quoting=csv.QUOTE_NONE)
    if lines and "".join(lines[0][:1]).startswith("PathFileType,"):
        lines = read_cells(path, headers=5)
    if len(lines) < 5 or "".join(lines[0][:1]).split()[:1] != ["PathFileType"]:
        remedy = "Use a file whose first line begins with PathFileType."
        raise InputError("this is not a TRC file", path, remedy)
    facts = _header(lines[1], lines[2])
    metres = landmark_file.metres_per(facts.get("Units", ""), f"{path}, Units")
    labels = _labels(lines[3])
    rate = facts.get("DataRate", "")
    try:
        fps = landmark_file.checked_fps(float(rate))
    except ValueError:
        remedy = "Write a number of frames per second."
        raise InputError(f"{rate!r} is not a frame rate", f"{path}, DataRate", remedy) from None
    found, times = _frames(path, lines[5:], len(labels))
    count = facts.get("NumFrames", "")
    if count.isdecimal() and len(found) < int(count):
        what = f"the file ends after {len(found)} of its {count} frames"
        raise InputError(what, path, "Use another copy of the file, or export it again.")
    frames = sorted(found)
    shape = len(frames), len(labels), 3
    points = metres * np.array([found[frame] for frame in frames]).reshape(shape)
    axes = landmark_file.FileAxes(landmark_file.world_from_up(_Y_UP), "as usual in TRC")
    world, notes = landmarks_in_world(Markers(labels, points, axes, path, "line 4"), stated)
    number, time = np.array(frames, dtype=np.int64), np.array([times[one] for one in frames])
    rows = row_times(number, time, fps, str(path))
    frame, places = on_frames(rows, world, str(path))
    return LandmarkTrajectory(frame, places, rows.fps, (*rows.notes, *notes))


def _header(names: list[str], values: list[str]) -> dict[str, str]:
    """Values of the second line by the names of the first, with any white space between them."""
    if len(names) == len(values) and not any(" " in name or not name for name in names):
        return dict(zip(names, values, strict=True))
    return dict(zip(" ".join(names).split(), " ".join(values).split(), strict=False))


def _labels(cells: list[str]) -> list[str]:
    """Labels of all markers; each stands over its three columns, or they follow one another."""
    cells = cells if len(cells) > 1 else "".join(cells).split()
    over = cells[2:]
    names = [name for name in over if name]
    if any(name for k, name in enumerate(over) if k % 3):
        return names
    count = max((k for k, name in enumerate(over) if name), default=-1) // 3 + 1
    return [over[3 * k] for k in range(count)]


def _frames(
    path: Path, lines: list[list[str]], count: int
) -> tuple[dict[int, FloatArray], dict[int, float]]:
    """Points (count, 3) in the file's unit and axes, and seconds (NaN if not stated), by frame."""
    found: dict[int, FloatArray] = {}
    times: dict[int, float] = {}
    for number, line in enumerate(lines, start=6):
        if any(line):
            filled = [cell for cell in line if cell]
            if any(" " in cell for cell in line):  # blanks separate cells as well, and doubled tabs
                line = " ".join(line).split()
            elif len(line) > 2 + 3 * count == len(filled):
                line = filled
            frame = whole_number(line[0], path, number, "frame")
            if frame in found:
                what = f"line {number} repeats frame {frame}"
                raise InputError(what, path, "Delete one of the two lines.")
            try:
                cells = (line[2:] + [""] * (3 * count))[: 3 * count]
                numbers = [float(cell) if cell else np.nan for cell in cells]
                points = found[frame] = np.array(numbers).reshape(count, 3)
                points[~np.isfinite(points).all(axis=-1)] = np.nan
                times[frame] = float("".join(line[1:2]) or "nan")
            except ValueError as error:
                what = f"line {number} has a value that is not a number ({error})"
                remedy = "Write numbers with decimal points. Leave unknown values empty."
                raise InputError(what, path, remedy) from None
    return found, times
