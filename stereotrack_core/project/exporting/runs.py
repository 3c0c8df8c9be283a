"""Runs, trajectories and references in the formats of other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.reference import MAX_SIGMA, Reference
from stereotrack_core.atomic import write_file
from stereotrack_core.counting import counted
from stereotrack_core.evaluation.joint_angles import (
    JointAngles,
    angles_of_reference,
    angles_of_run,
    angles_of_trajectory,
    frame_columns,
    frame_rows,
)
from stereotrack_core.interop.coco import write_coco
from stereotrack_core.interop.deeplabcut import write_deeplabcut
from stereotrack_core.interop.keypoints.json_files import write_results
from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.interop.labels import write_clicks
from stereotrack_core.interop.reference_npz import write_reference, write_reference_table
from stereotrack_core.interop.run_file import write_run, write_trajectory
from stereotrack_core.interop.sleap import write_sleap
from stereotrack_core.project.exporting.formats import ExportFormat, check_kind, lost_of_clicks
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tables import csv_text
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import fps_of_run

ANGLES = "angles"
"""Name of the format of joint angles."""


@dataclass(frozen=True)
class Exported:
    """Files that were written."""

    files: Mapping[Path, str]
    """Files or folders, and in words what is in them."""
    notes: tuple[str, ...] = ()
    """Remarks on them, as sentences."""

    def words(self) -> str:
        """``30 frames saved to run.trc``; of several files the first one is named."""
        path, what = next(iter(self.files.items()))
        others = f" and {counted(len(self.files) - 1, 'file')}" if len(self.files) > 1 else ""
        return " ".join((f"{what} saved to {path}{others}.", *self.notes))


def export_run(path: Path, run: Run, form: ExportFormat, fps: float | None = None) -> Exported:
    """Write a complete run; frames per second are the run's where they are not given.

    Raises InputError where the format cannot hold it, or the file cannot be written.
    """
    check_kind(form, "run")
    if form.name == ANGLES:
        return export_angles(path, angles_of_run(run), fps_of_run(run) if fps is None else fps)
    write_run(path, run, fps)
    return Exported({path: counted(len(run.frame), "frame")})


def export_trajectory(
    path: Path, trajectory: LandmarkTrajectory, form: ExportFormat, fps: float | None
) -> Exported:
    """Write landmarks of any origin; see :func:`export_run`."""
    check_kind(form, "trajectory")
    if form.name == ANGLES and fps is not None:
        return export_angles(path, angles_of_trajectory(trajectory), fps)
    write_trajectory(path, trajectory, fps)
    return Exported({path: counted(len(trajectory.frame), "frame")})


def export_reference(
    path: Path,
    reference: Reference,
    form: ExportFormat,
    fps: float | None,
    max_sigma: float = MAX_SIGMA,
) -> Exported:
    """Write what is known of a reference within a limit of sigma, in metres; says what is not.

    ``npz`` keeps the covariances, ``csv`` the standard deviations along the axes and ``c3d`` the
    largest one as residual; see :func:`export_run` for the rest.
    """
    check_kind(form, "reference")
    known = reference.within(max_sigma)
    if form.name == "npz":
        write_reference(path, known)
        written = Exported({path: counted(len(reference.frame), "frame")})
    elif form.name == "csv":
        write_reference_table(path, known)
        written = Exported({path: counted(len(reference.frame), "frame")})
    elif form.name == ANGLES and fps is not None:
        written = export_angles(path, angles_of_reference(known, np.inf), fps)
    else:
        sigma = None if reference.covariance is None else reference.of_the_nine(reference.sigma())
        write_trajectory(path, known.trajectory(np.inf), fps, sigma)
        written = Exported({path: counted(len(reference.frame), "frame")})
    notes = [reference.left_out(max_sigma), form.lost(reference)]
    return replace(written, notes=(*written.notes, *filter(None, notes)))


def export_angles(path: Path, angles: JointAngles, fps: float) -> Exported:
    """Write joint angles of every frame as CSV."""
    write_file(path, csv_text(frame_columns(), frame_rows(angles, fps)))
    return Exported({path: f"joint angles of {counted(len(angles.frame), 'frame')}"})


def export_clicks(
    path: Path,
    clicks: Sequence[Click],
    recording: Recording,
    landmarks: LandmarkSet,
    form: ExportFormat,
) -> Exported:
    """Write clicks.

    Raises InputError where the format cannot hold them or the files cannot be written.
    """
    check_kind(form, "clicks")
    written = {path: len(clicks)}
    if form.name == "dlc":
        written = write_deeplabcut(path, clicks, landmarks.names)
    elif form.name == "csv":
        write_clicks(path, clicks, recording)
    elif form.name == "coco":
        write_coco(path, clicks, recording, landmarks)
    else:
        write_sleap(path, clicks, recording, landmarks)
    note = lost_of_clicks(form, clicks)
    if not clicks:
        note = "The project has no clicks, so the file is empty."
    return Exported(
        {file: f"{count} clicks" for file, count in written.items()}, (note,) if note else ()
    )


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
