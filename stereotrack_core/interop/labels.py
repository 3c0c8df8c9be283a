"""Clicks from any file that is understood, by what it holds, and this program's own clicks file.

The clicks file is ``frame,view,landmark,x,y,visibility``, in raw-image pixels, followed by the
provenance ``source,sigma,flag,annotator,time``; files without that are read as well.

Clicks as tables with a row for each frame: DLTdv, Argus and XMALab.

All three have columns for each point in each camera and no column for the frame: the n-th row is
frame n - 1 of the recording. They differ in their columns' names and in what a pixel is:

- ``dltdv``: ``pt1_cam1_X``; the centre of the top-left pixel is (1, 1), y points down. That is
  DLTdv8; DLTdv 5 to 7 count y from the bottom.
- ``argus``: ``head_cam_1_x``; the centre of the top-left pixel is (0, height): y points up.
- ``xmalab``: ``head_cam1_X``; the centre of the top-left pixel is (0, 0), y points down. These are
  the choices of its dialog that are made beforehand: with a header, from 0, y down, distorted.

Cameras are numbered in the recording's order. The tables have no column for how a landmark is seen,
or for what is outside the image.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from stereotrack_core import tables
from stereotrack_core.annotation.click import LAST_FRAME, Click, ClickKey, Visibility
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop import label_source
from stereotrack_core.interop.coco import read_coco
from stereotrack_core.interop.deeplabcut import is_deeplabcut, read_deeplabcut
from stereotrack_core.interop.run_file import TRAJECTORY_SUFFIXES
from stereotrack_core.interop.sleap import read_sleap
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS

_POINT_TABLES = (
    (re.compile(r"(pt\d+)_cam(\d+)_([XY])"), 1, False),  # DLTdv
    (re.compile(r"(.+)_cam_(\d+)_([xy])"), 0, True),  # Argus
    (re.compile(r"(.+)_cam(\d+)_([XY])"), 0, False),  # XMALab
)
"""A column's point, camera's number and axis; the number of the first pixel of a row, whose centre
it is; whether y points up, from the edge below the last row. A header is of the first that fits."""


def _read_points(source: label_source.LabelSource) -> label_source.Labels:
    """Read clicks of the cameras in the recording's order; InputError if no point is known."""
    path = source.path
    lines = tables.read_cells(path, headers=1)
    form, first, upwards = next(one for one in _POINT_TABLES if _has_columns(lines[0], one[0]))
    cameras = {str(k): name for k, name in enumerate(source.recording.cameras, start=1)}
    places: dict[tuple[str, str], dict[str, int]] = {}
    for column, title in enumerate(lines[0]):
        ((point, number, axis),) = form.findall(title)
        if number not in cameras:
            what = f"the file has a camera {number}, the recording has {len(cameras)}"
            raise InputError(what, path, "Remove its columns, or add the camera to the recording.")
        if source.camera is not None and cameras[number] != source.camera_of("", str(path)):
            continue
        places.setdefault((point, cameras[number]), {})[axis.lower()] = column

    def read(row: tuple[int, Sequence[str]], known: Mapping[str, str]) -> list[Click]:
        line, cells = row
        clicks = []
        for (point, name), columns in places.items():
            if point in known and len(columns) == 2:
                written = [cells[k] if k < len(cells) else "" for k in (columns["x"], columns["y"])]
                x, y = (tables.number_or_nan(cell, path, line, point) for cell in written)
                if math.isfinite(x) and math.isfinite(y):
                    height = source.recording.cameras[name].height
                    pixel = x - first, height - y if upwards else y - first
                    clicks.append(Click(line - 2, name, known[point], pixel, origin="imported"))
        return clicks

    rows = enumerate(lines[1:], start=2)
    found = source.labels((point for point, _ in places), rows, read)
    return replace(found, unstated=label_source.PLACES_ALONE)


def _has_columns(header: Sequence[str], form: re.Pattern[str]) -> bool:
    return bool(header) and all(map(form.fullmatch, header))


_UNDERSTOOD = (
    "Supported files: clicks from .csv, DeepLabCut .csv and .h5, DLTdv, Argus and XMALab .csv, "
    "COCO keypoints .json and SLEAP .slp; trajectories from .csv with x, y and z, .trc, .c3d "
    "and .npz."
)
LABEL_SUFFIXES = (".csv", ".h5", ".json", ".slp")  # what :func:`read_labels` reads

_TRAJECTORY_COLUMNS = {"frame", "landmark", "x", "y", "z"}


def is_trajectory(path: Path) -> bool:
    """Whether a file holds points in space instead of clicks; InputError if unreadable."""
    suffix = path.suffix.lower()
    if suffix != ".csv":
        return suffix in TRAJECTORY_SUFFIXES
    lines = tables.read_cells(path)
    return bool(lines) and set(lines[0]) >= _TRAJECTORY_COLUMNS


def read_labels(source: label_source.LabelSource, frames: int | None = None) -> label_source.Labels:
    """Read clicks, and what is wrong in the file; InputError if it is of no known kind."""
    suffix = source.path.suffix.lower()
    read: Callable[[label_source.LabelSource], label_source.Labels] | None
    read = {".json": read_coco, ".slp": read_sleap, ".h5": read_deeplabcut}.get(suffix)
    if suffix == ".csv":
        lines = tables.read_cells(source.path)
        if is_deeplabcut(lines):
            read = read_deeplabcut
        elif lines and any(_has_columns(lines[0], form) for form, *_ in _POINT_TABLES):
            read = _read_points
    if read is not None:
        return _checked(read(source), source, frames)
    if suffix != ".csv":
        what = f"labels cannot be read from {suffix or 'files without a suffix'}"
        raise InputError(what, source.path, _UNDERSTOOD)
    for option, given in (("--camera", source.camera), ("--name", source.names)):
        if given:
            what = "a clicks file states views and landmarks itself"
            raise InputError(what, option, "Omit this option.")
    return read_clicks(source.path, source.recording, landmarks=source.landmarks, frames=frames)


def _checked(
    found: label_source.Labels, source: label_source.LabelSource, frames: int | None
) -> label_source.Labels:
    """The labels whose frames and places there are, each once."""
    kept: dict[ClickKey, Click] = {}
    problems = list(found.problems)
    for click in found.clicks:
        trouble = _trouble(click, source.recording, frames)
        if click.key in kept:
            trouble = "it is given twice"
        if trouble:
            what = f"{click.landmark} in {click.camera}, frame {click.frame}: {trouble}"
            problems.append(InputError(what, source.path, "Correct or delete it."))
        else:
            kept[click.key] = click
    return replace(found, clicks=tuple(kept.values()), problems=tuple(problems))


def _trouble(click: Click, recording: Recording, frames: int | None) -> str:
    if frames is not None and click.frame >= frames:
        return f"the last frame is {frames - 1}"
    camera = recording.cameras.get(click.camera)
    if camera is None:
        return "its camera is not in the calibration"
    if click.position is not None:
        (x, y), size = click.position, (camera.width, camera.height)
        if not (-0.5 <= x <= size[0] - 0.5 and -0.5 <= y <= size[1] - 0.5):
            return f"({x:g}, {y:g}) is outside the image of {size[0]} x {size[1]} pixels"
    return ""


COLUMNS = ("frame", "view", "landmark", "x", "y", "visibility")


def read_clicks(
    path: Path,
    recording: Recording,
    *,
    landmarks: Sequence[str] = LANDMARKS,
    frames: int | None = None,
) -> label_source.Labels:
    """Read clicks of a recording, and everything that is wrong in the file.

    A ``view`` names a view of the recording (that view's reference image) or a camera. `frames` is
    the number of the recording's frames, where it is known.

    Raises InputError where the file cannot be read at all.

    Examples
    --------
    >>> recording = open_recording(Path("recording"))
    >>> clicks = read_clicks(Path("clicks.csv"), recording).checked()
    """
    problems: list[InputError] = []
    lines: dict[ClickKey, int] = {}
    clicks = []
    header = next(iter(tables.read_cells(path)), [])
    columns = (*COLUMNS, *(name for name in label_source.PROVENANCE if name in header))
    for line, cells in tables.read_rows(path, columns, problems):
        try:
            click = _click(path, line, cells, recording, landmarks, frames)
            if click.key in lines:
                own = f"{click.landmark} of frame {click.frame} in {click.camera}"
                what = f"line {line} repeats {own}, given in line {lines[click.key]}"
                raise InputError(what, path, "Delete one of the two lines.")
        except InputError as problem:
            problems.append(problem)
            continue
        lines[click.key] = line
        clicks.append(click)
    problems.sort(key=_line_of)
    unstated = tuple(name for name in ("flag", "sigma") if name not in header)
    return label_source.Labels(tuple(clicks), tuple(problems), unstated=unstated)


def write_clicks(path: Path, clicks: Iterable[Click], recording: Recording) -> None:
    """Write clicks for :func:`read_clicks`, with their provenance.

    Deleted ones are left out. The reference image of a view is named by the view, other cameras by
    their names. InputError where a view has the name of another view's camera.
    """
    there = (click for click in clicks if not click.deleted)
    rows = sorted(_row(click, recording) for click in there)
    write_file(path, tables.csv_text((*COLUMNS, *label_source.PROVENANCE), rows))


def _row(click: Click, recording: Recording) -> tuple[int | str | float, ...]:
    views = {view.image.camera: view.name for view in recording.views}
    name = views.get(click.camera, click.camera)
    if click.camera not in views and name in views.values():
        what = f"the camera {name!r} has the name of a view that shows another camera"
        remedy = "Rename the camera or the view; a clicks file cannot distinguish them."
        raise InputError(what, recording.name, remedy)
    x, y = ("", "") if click.position is None else (repr(float(value)) for value in click.position)
    place = click.frame, name, click.landmark, x, y, int(click.visibility)
    return (*place, *label_source.provenance_of_click(click).values())


def _click(
    path: Path,
    line: int,
    cells: Mapping[str, str],
    recording: Recording,
    landmarks: Sequence[str],
    frames: int | None,
) -> Click:
    views = {view.name: view.image.camera for view in recording.views}
    cameras = {**{camera: camera for camera in recording.cameras}, **views}
    frame = tables.whole_number(cells["frame"], path, line, "frame")
    name, landmark, visibility = cells["view"], cells["landmark"], cells["visibility"]
    last = "" if frames is None else f", the last one is {frames - 1}"
    checks = (
        (0 <= frame < (LAST_FRAME if frames is None else frames),
         f"frame {frame} does not exist", f"Frames are counted from 0{last}."),
        (name in cameras, f"unknown view or camera {name!r}",
         f"Use one of {', '.join(sorted(cameras))}; a view is that view's reference image."),
        (landmark in landmarks, f"unknown landmark {landmark!r}",
         f"The landmarks are {', '.join(landmarks)}."),
        (visibility in ("0", "1", "2"), f"invalid visibility {visibility!r}",
         "Write 2 for seen, 1 for guessed behind something, 0 for outside the image."),
    )  # fmt: skip
    for is_right, what, remedy in checks:
        if not is_right:
            raise InputError(f"line {line}: {what}", path, remedy)
    position, seen = None, Visibility(int(visibility))
    if seen != Visibility.OUTSIDE:
        x, y = (tables.finite_number(cells[axis], path, line, axis) for axis in "xy")
        position = x, y
    stated = label_source.stated_provenance(cells, f"{path}, line {line}")
    click = Click(frame, cameras[name], landmark, position, seen, **stated)
    if trouble := _trouble(click, recording, frames):
        remedy = "Write raw-image pixels (the centre of the first pixel is 0), or visibility 0."
        raise InputError(f"line {line}: {trouble}", path, remedy)
    return click


def _line_of(problem: InputError) -> int:
    digits = problem.what.removeprefix("line ").split(" ", 1)[0].rstrip(":")
    return int(digits) if digits.isdigit() else 0
