"""Clicks, with the pictures that they were made on, and predictions for other programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop import coco, deeplabcut
from stereotrack_core.interop.keypoints.json_files import write_results
from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.pictures import labelled_pictures, write_pictures
from stereotrack_core.interop.point_tables import write_points
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.project.exporting.formats import (
    ExportFormat,
    check_kind,
    formats_of,
    lost_of_clicks,
)
from stereotrack_core.project.exporting.runs import Exported
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader


def export_clicks(
    path: Path,
    clicks: Sequence[Click],
    recording: Recording,
    landmarks: LandmarkSet,
    form: ExportFormat,
    *,
    pictures: bool = False,
    report: Callable[[float], None] = lambda _share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Exported:
    """Write clicks.

    Raises InputError where the format cannot hold them or the files cannot be written, and
    Cancelled where the writing of pictures is stopped; the labels are there then.

    Parameters
    ----------
    pictures : bool
        Whether the pictures that they were made on are written as well, where the other program
        looks for them.
    report, stopped : callable, optional
        See :func:`~stereotrack_core.interop.pictures.write_pictures`.
    """
    check_kind(form, "clicks")
    if pictures and not form.pictures:
        able = [one.name for one in formats_of("clicks") if one.pictures]
        raise InputError(
            f"{form.name} names no pictures",
            where="--pictures",
            remedy=f"Omit it, or use --format {', '.join(able)}.",
        )
    written = _write(path, clicks, recording, landmarks, form, pictures=pictures)
    files = {file: f"{count} clicks" for file, count in written.items()}
    if pictures and form.name != "slp":
        count = _write_pictures(path, clicks, recording, form, report, stopped)
        files[path.parent] = f"{count} pictures"
    note = lost_of_clicks(form, clicks)
    if not clicks:
        note = "The project has no clicks, so the file is empty."
    return Exported(files, (note,) if note else ())


def _write(
    path: Path,
    clicks: Sequence[Click],
    recording: Recording,
    landmarks: LandmarkSet,
    form: ExportFormat,
    *,
    pictures: bool,
) -> dict[Path, int]:
    names = landmarks.names
    if form.name == "dlc":
        written = deeplabcut.write_deeplabcut(path, clicks, names)
        if pictures:
            hdf5 = path.suffix.lower() == ".h5"
            written |= deeplabcut.write_labelled_data(path.parent, clicks, names, hdf5=hdf5)
        return written
    if form.name == "csv":
        write_clicks(path, clicks, recording)
    elif form.name == "coco":
        coco.write_coco(path, clicks, recording, landmarks)
    elif form.name == "slp":
        write_sleap(path, clicks, recording, landmarks, pictures=pictures)
    else:
        with FrameReader(recording, read_ahead=0) as reader:
            frames = reader.frame_count
        return {path: write_points(path, clicks, recording, names, form.name, frames)}
    return {path: len(clicks)}


def _write_pictures(
    path: Path,
    clicks: Sequence[Click],
    recording: Recording,
    form: ExportFormat,
    report: Callable[[float], None],
    stopped: Callable[[], bool],
) -> int:
    """Write the pictures beside the labels, as they are named there; how many."""
    name_of = coco.picture_of if form.name == "coco" else deeplabcut.picture_of
    files: dict[tuple[str, int], Path] = {}
    for camera, frame in labelled_pictures(clicks):
        deeplabcut.file_of_camera(path, camera)  # refuses names that lead elsewhere
        files[camera, frame] = path.parent / name_of(camera, frame)
    write_pictures(files, recording, report, stopped)
    return len(files)


def export_keypoints(
    path: Path, keypoints: Keypoints, recording: Recording, form: ExportFormat
) -> Exported:
    """Write what detectors have predicted, as a table or as COCO results."""
    check_kind(form, "keypoints")
    others = 0
    if form.name == "csv":
        write_table(path, keypoints, recording)
    else:
        others = write_results(path, keypoints, recording)
    told = f", {others} that COCO does not have left out" if others else ""
    return Exported({path: f"{counted(len(keypoints) - others, 'keypoint')}{told}"})
