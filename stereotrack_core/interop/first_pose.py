"""The first pose of a run, as a person names it: a way to begin, or a file that knows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import holds_run, read_run, read_trajectory
from stereotrack_core.tracking.run_spec import AUTO, FirstPose
from stereotrack_core.tracking.stored import pose_of_run


def first_pose(text: str, frame: int) -> FirstPose:
    """Where ``--init`` says that tracking begins.

    InputError for a file that does not know `frame`.
    """
    if text in {"auto", "tpose"}:
        return text
    if text.startswith(f"{AUTO} "):
        return with_heading(AUTO, text.removeprefix(f"{AUTO} "))
    path = Path(text)
    if not path.suffix and not path.exists():
        raise InputError(
            f"{text!r} is not an initial pose",
            where="--init",
            remedy="Use auto, tpose, or the name of a run or landmarks file.",
        )
    return _pose_in_file(path, frame)


_COMPASS = {"north": 0.0, "east": 90.0, "south": 180.0, "west": 270.0}


def with_heading(init: FirstPose, heading: str | None) -> FirstPose:
    """A first pose that is looked for, of somebody who faces a heading.

    `heading` is north, east, south, west, or degrees from north over east; None: not known.
    InputError for anything else, and where the first pose is given.
    """
    if heading is None:
        return init
    if init != AUTO:
        raise InputError(
            "the initial pose is given, and faces a direction already",
            where="--heading",
            remedy="Omit --heading, or use it with --init auto.",
        )
    try:
        degrees = _COMPASS.get(heading.lower())
        degrees = float(heading) if degrees is None else degrees
    except ValueError:
        degrees = float("nan")
    if not -360.0 <= degrees <= 360.0:
        raise InputError(
            f"{heading!r} is not a heading",
            where="--heading",
            remedy="Use north, east, south, west, or degrees from north over east, such as 135.",
        )
    return f"{AUTO} {degrees % 360.0:g}"


def _pose_in_file(path: Path, frame: int) -> FirstPose:
    pose = None
    if holds_run(path):
        run = read_run(path)
        for i in np.flatnonzero(run.frame == frame):
            pose = pose_of_run(run, int(i))
    else:
        trajectory = read_trajectory(path)
        for points in trajectory.points[trajectory.frame == frame]:
            try:
                pose = pose_of_landmarks(points)
            except ValueError:
                continue
    if pose is None:
        raise InputError(
            f"the file does not contain frame {frame}",
            where=f"--init {path}",
            remedy="Start at a frame that the file contains: --frames A:B.",
        )
    return pose
