"""``stereotrack export`` of a project's clicks, with the pictures that they were made on."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.cli.arguments import check_output
from stereotrack_core.cli.output import say
from stereotrack_core.cli.progress import watched
from stereotrack_core.cli.sources import recording_of
from stereotrack_core.errors import InputError
from stereotrack_core.interop import coco, deeplabcut
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.pictures import labelled_pictures, write_pictures
from stereotrack_core.interop.point_tables import write_points
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

_WITH_PICTURES = ("coco", "dlc", "slp")


def export_clicks(args: Namespace, project: Project) -> dict[str, Any]:
    """Write the clicks of a project; what is in which file."""
    if args.pictures and args.format not in _WITH_PICTURES:
        raise InputError(
            f"{args.format} names no pictures",
            where="--pictures",
            remedy=f"Omit it, or use --format {', '.join(_WITH_PICTURES)}.",
        )
    recording = recording_of(project)
    check_output(args.output, recording)
    clicks, landmarks = project.clicks.all(), project.landmark_set()
    if not clicks:
        say("The project has no clicks, so the file is empty.")
    written = _write(args, clicks, recording, landmarks)
    facts: dict[Path, str] = {path: f"{count} clicks" for path, count in written.items()}
    if args.pictures and args.format != "slp":
        folder, count = _write_pictures(args, clicks, recording)
        facts[folder] = f"{count} pictures"
    return {"files": facts}


def _write(
    args: Namespace, clicks: Sequence[Click], recording: Recording, landmarks: LandmarkSet
) -> dict[Path, int]:
    path, names = args.output, landmarks.names
    if args.format == "dlc":
        written = deeplabcut.write_deeplabcut(path, clicks, names)
        if args.pictures:
            hdf5 = path.suffix.lower() == ".h5"
            written |= deeplabcut.write_labelled_data(path.parent, clicks, names, hdf5=hdf5)
        return written
    if args.format == "csv":
        write_clicks(path, clicks, recording)
    elif args.format == "coco":
        coco.write_coco(path, clicks, recording, landmarks)
    elif args.format == "slp":
        write_sleap(path, clicks, recording, landmarks, pictures=args.pictures)
    else:
        with FrameReader(recording, read_ahead=0) as reader:
            frames = reader.frame_count
        return {path: write_points(path, clicks, recording, names, args.format, frames)}
    return {path: len(clicks)}


def _write_pictures(
    args: Namespace, clicks: Sequence[Click], recording: Recording
) -> tuple[Path, int]:
    """Write the pictures beside the labels, as they are named there; the folder and how many."""
    name_of = coco.picture_of if args.format == "coco" else deeplabcut.picture_of
    folder, files = args.output.parent, {}
    for camera, frame in labelled_pictures(clicks):
        deeplabcut.file_of_camera(args.output, camera)  # refuses names that lead elsewhere
        files[camera, frame] = folder / name_of(camera, frame)
    with watched("Writing pictures", "The labels and some pictures were written.") as (
        report,
        stopped,
    ):
        write_pictures(files, recording, lambda share: report(share, ""), stopped)
    return folder, len(files)
