"""The first pose of a run, as a person names it: a way to begin, or a file that knows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.errors import InputError
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.interop.run_file import (
    has_own_axes,
    holds_run,
    read_run,
    read_trajectory,
    unstatable,
)
from stereotrack_core.tracking.run_spec import AUTO, FirstPose
from stereotrack_core.tracking.stored import pose_of_run


def first_pose(text: str, frame: int, *, stated: Stated | None = None) -> FirstPose:
    """Where ``--init`` says that tracking begins; `stated`: names and axes of its file.

    InputError for a file that does not know `frame`.
    """
    if stated is not None and stated.about_file and not has_own_axes(Path(text)):
        raise unstatable(Path(text))
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
    return _pose_in_file(path, frame, stated)


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


def _pose_in_file(path: Path, frame: int, stated: Stated | None) -> FirstPose:
    pose = None
    if holds_run(path):
        run = read_run(path)
        for i in np.flatnonzero(run.frame == frame):
            pose = pose_of_run(run, int(i))
    else:
        trajectory = read_trajectory(path, stated)
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
