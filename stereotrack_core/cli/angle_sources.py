"""Files that joint angles are worked out from, and what belongs to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.sources import say_if_unfinished
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from stereotrack_core.evaluation.joint_angles.series import JointAngles
    from stereotrack_core.recording.description import Recording, Segment


@dataclass(frozen=True, eq=False)
class AngleSource:
    """Joint angles of a file.

    Attributes
    ----------
    angles : JointAngles
    fps : float
        Frame sets per second.
    segments : sequence of Segment
    truth : JointAngles or None
        Those of the recording's own reference, where it has one.
    """

    angles: JointAngles
    fps: float
    segments: Sequence[Segment]
    truth: JointAngles | None


def angle_source(path: Path, fps: float | None) -> AngleSource:
    """Angles of a run, a reference or landmarks.

    Parameters
    ----------
    path : Path
    fps : float or None
        Frames per second for files that do not say them; what is given here holds.

    Raises
    ------
    InputError
        For a file that cannot be read, or that nothing states the frame rate of.
    """
    from stereotrack_core.evaluation.joint_angles.series import angles_of_trajectory

    angles, recording, stated = _read(path)
    rate = fps if fps is not None else stated
    if rate is None and recording is not None:
        rate = recording.fps
    if rate is None:
        raise InputError(
            "the file does not say how many frames a second has",
            where=str(path),
            remedy="Give --fps N.",
        )
    reference = None if recording is None else recording.reference
    truth = None if reference is None else angles_of_trajectory(reference)
    segments = () if recording is None else recording.segments
    return AngleSource(angles, rate, segments, truth)


def angles_of_file(path: Path) -> JointAngles:
    """Angles of a run, a reference or landmarks alone."""
    return _read(path)[0]


def write_angles(path: Path, angles: JointAngles, fps: float, cut_off: float | None) -> int:
    """Write the angles of every frame as CSV; the number of frames."""
    from stereotrack_core.atomic import write_file
    from stereotrack_core.evaluation.joint_angles.motion import (
        CUT_OFF_HZ,
        frame_columns,
        frame_rows,
        motion_of,
    )
    from stereotrack_core.recording.csv_table import csv_text

    motion = motion_of(angles, fps, CUT_OFF_HZ if cut_off is None else cut_off)
    write_file(path, csv_text(frame_columns(), frame_rows(angles, motion)))
    return len(angles.frame)


def _read(path: Path) -> tuple[JointAngles, Recording | None, float | None]:
    """Angles, the recording where its folder is known and there, and frames per second."""
    from stereotrack_core.evaluation.joint_angles.series import (
        angles_of_reference,
        angles_of_run,
        angles_of_trajectory,
    )
    from stereotrack_core.interop.reference_npz import (
        fps_of_reference,
        is_reference,
        read_reference,
    )
    from stereotrack_core.interop.run_file import holds_run, read_run, read_timed_trajectory
    from stereotrack_core.tracking.stored import fps_of_run

    if path.suffix.lower() == ".npz" and is_reference(path):
        reference = read_reference(path)
        folder = reference.meta.get("recording_folder")
        place = Path(str(folder)) if folder else path.parent
        return angles_of_reference(reference), _recording(place), fps_of_reference(reference)
    if not holds_run(path):
        trajectory, stated = read_timed_trajectory(path)
        return angles_of_trajectory(trajectory), _recording(path.parent), stated
    run = read_run(path)
    say_if_unfinished(path, run)
    folder = run.meta.get("recording_folder")
    recording = _recording(Path(str(folder))) if folder else None
    return angles_of_run(run), recording, fps_of_run(run) if "fps" in run.meta else None


def _recording(folder: Path) -> Recording | None:
    from stereotrack_core.recording.folder import describe

    return describe(folder, []) if (folder / "recording.toml").is_file() else None
