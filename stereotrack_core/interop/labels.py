"""Clicks from any tool whose files are understood, by what the file holds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.errors import InputError
from stereotrack_core.interop.clicks_csv import read_clicks
from stereotrack_core.interop.coco import read_coco
from stereotrack_core.interop.deeplabcut import is_deeplabcut, read_deeplabcut
from stereotrack_core.interop.label_source import Labels, LabelSource
from stereotrack_core.interop.run_journal import PART_SUFFIX
from stereotrack_core.interop.sleap import read_sleap
from stereotrack_core.recording.csv_table import read_cells
from stereotrack_core.recording.description import Recording

_UNDERSTOOD = (
    "Supported files: clicks from .csv, DeepLabCut .csv, COCO keypoints .json and SLEAP .slp; "
    "trajectories from .csv with x, y and z, .trc, .c3d and .npz."
)
_OTHERS = {
    ".h5": "DeepLabCut writes a .csv beside every .h5; use that file.",
    ".mat": "Export the labels as .csv or COCO keypoints (.json), and use that file.",
}

_TRAJECTORY_COLUMNS = {"frame", "landmark", "x", "y", "z"}


def is_trajectory(path: Path) -> bool:
    """Whether a file holds points in space instead of clicks.

    Raises
    ------
    InputError
        Where it cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix != ".csv":
        return suffix in (".trc", ".c3d", ".npz", PART_SUFFIX)
    lines = read_cells(path)
    return bool(lines) and set(lines[0]) >= _TRAJECTORY_COLUMNS


def read_labels(source: LabelSource, frames: int | None = None) -> Labels:
    """Read clicks, and everything that is wrong in the file.

    `frames` is the number of frames of the recording, where it is known.

    Raises
    ------
    InputError
        Where the file cannot be read at all, or is of a kind that is not understood.
    """
    suffix = source.path.suffix.lower()
    read = {".json": read_coco, ".slp": read_sleap}.get(suffix)
    if suffix == ".csv" and is_deeplabcut(read_cells(source.path)):
        read = read_deeplabcut
    if read is not None:
        return _checked(read(source), source, frames)
    if suffix != ".csv":
        raise InputError(
            f"labels cannot be read from {suffix or 'files without a suffix'}",
            where=str(source.path),
            remedy=_OTHERS.get(suffix, _UNDERSTOOD),
        )
    for option, given in (("--camera", source.camera), ("--name", source.names)):
        if given:
            raise InputError(
                "a clicks file states views and landmarks itself",
                where=option,
                remedy="Omit this option.",
            )
    return read_clicks(source.path, source.recording, landmarks=source.landmarks, frames=frames)


def _checked(found: Labels, source: LabelSource, frames: int | None) -> Labels:
    """The labels whose frames and places there are, each once."""
    kept: dict[ClickKey, Click] = {}
    problems = list(found.problems)
    for click in found.clicks:
        trouble = _trouble(click, source.recording, frames)
        if click.key in kept:
            trouble = "it is given twice"
        if trouble:
            what = f"{click.landmark} in {click.camera}, frame {click.frame}: {trouble}"
            problems.append(
                InputError(what, where=str(source.path), remedy="Correct or delete it.")
            )
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
