"""The first pose of a run, as a person names it: a way to begin, or a file that knows it."""

from contextlib import suppress
from pathlib import Path

import numpy as np

from stereotrack_core.body.posing import pose_of_landmarks
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.interop import run_file
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.frame_times import stated_fps
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.run_spec import AUTO, FirstPose
from stereotrack_core.tracking.stored import pose_of_run


def first_pose(
    text: str,
    frame: int,
    recording: Recording | None = None,
    *,
    stated: Stated | None = None,
    notes: list[Finding] | None = None,
) -> FirstPose:
    """Where ``--init`` says that tracking begins; `stated`: names and axes of its file.

    A file of another frame rate than the recording's is asked by time; `notes` are told so.
    InputError for a file that does not know `frame`.
    """
    if stated is not None and stated.about_file and not run_file.has_own_axes(Path(text)):
        raise run_file.unstatable(Path(text))
    if text in {"auto", "tpose"}:
        return text
    if text.startswith(f"{AUTO} "):
        return with_heading(AUTO, text.removeprefix(f"{AUTO} "))
    path = Path(text)
    if not path.suffix and not path.exists():
        remedy = "Use auto, tpose, or the name of a run or landmarks file."
        raise InputError(f"{text!r} is not an initial pose", "--init", remedy)
    pose = None
    if run_file.holds_run(path):
        run = run_file.read_run(path)
        for i in np.flatnonzero(run.frame == _frame_in_run(run, frame, recording)):
            pose = pose_of_run(run, int(i))
    else:
        trajectory = run_file.read_trajectory(path, stated)
        if recording is not None:
            trajectory = trajectory.at_rate(recording.fps, f"--init {path}")
        if notes is not None:
            notes += trajectory.notes
        for points in trajectory.points[trajectory.frame == frame]:
            with suppress(ValueError):
                pose = pose_of_landmarks(points)
    if pose is None:
        remedy = "Start at a frame that the file contains: --frames A:B."
        raise InputError(f"the file does not contain frame {frame}", f"--init {path}", remedy)
    return pose


_COMPASS = {"north": 0.0, "east": 90.0, "south": 180.0, "west": 270.0}


def with_heading(init: FirstPose, heading: str | None) -> FirstPose:
    """A first pose that is looked for, of somebody who faces a heading.

    `heading` is north, east, south, west, or degrees from north over east; None: not known.
    InputError for anything else, and where the first pose is given.
    """
    if heading is None:
        return init
    if init != AUTO:
        what = "the initial pose is given, and faces a direction already"
        raise InputError(what, "--heading", "Omit --heading, or use it with --init auto.")
    try:
        degrees = _COMPASS.get(heading.lower())
        degrees = float(heading) if degrees is None else degrees
    except ValueError:
        degrees = float("nan")
    if not -360.0 <= degrees <= 360.0:
        remedy = "Use north, east, south, west, or degrees from north over east, such as 135."
        raise InputError(f"{heading!r} is not a heading", "--heading", remedy)
    return f"{AUTO} {degrees % 360.0:g}"


def _frame_in_run(run: Run, frame: int, recording: Recording | None) -> int:
    """The run's frame at the time of a recording's; poses are not interpolated."""
    fps, folder = stated_fps(run.meta), run.meta.get("recording_folder")
    if fps is None or recording is None:
        return frame
    of_recording = folder and Path(str(folder)).resolve() == recording.folder.resolve()
    return frame if of_recording else round(frame * fps / recording.fps)
