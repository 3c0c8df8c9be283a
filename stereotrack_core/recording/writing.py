"""Write a recording folder: the description and, beside it, what it names.

Pictures are written with :class:`video_file.VideoWriter` and :func:`video_file.write_png` to the
names that the views' streams state.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from stereotrack_core.arrays import Float32Array
from stereotrack_core.atomic import filling, write_file
from stereotrack_core.recording.calibration import write_calibration
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.folder import DESCRIPTION, FORMAT
from stereotrack_core.recording.landmarks import write_landmarks
from stereotrack_core.recording.segments_file import write_segments
from stereotrack_core.recording.subject_file import write_subject
from stereotrack_core.recording.video_file import VideoWriter, write_png

__all__ = ["VideoWriter", "counts_of", "write_png", "write_recording_description"]


def write_recording_description(recording: Recording) -> None:
    """Write every file of a recording but its pictures into ``recording.folder``.

    The folder is made if it is not there; ``subject.toml``, ``reference.csv`` and
    ``segments.csv`` are written where the recording has them.

    Raises
    ------
    InputError
        Where not all of them can be written; then the folder stays as it was.
    """
    content: dict[str, Any] = {
        "format": FORMAT,
        "name": recording.name,
        "fps": recording.fps,
        "calibration": "calibration.toml",
    }
    with filling(recording.folder) as folder:
        write_calibration(folder / "calibration.toml", recording.cameras)
        if recording.subject is not None:
            content["subject"] = "subject.toml"
            write_subject(folder / "subject.toml", recording.subject)
        if recording.reference is not None:
            content["reference"] = "reference.csv"
            write_landmarks(folder / "reference.csv", recording.reference)
        if recording.segments:
            content["segments"] = "segments.csv"
            write_segments(folder / "segments.csv", recording.segments)
        content["views"] = [_view(view) for view in recording.views]
        write_file(folder / DESCRIPTION, tomli_w.dumps(content))


def _view(view: View) -> dict[str, Any]:
    content: dict[str, Any] = {"name": view.name, "kind": view.kind}
    if view.display_rotation:
        content["display_rotation"] = view.display_rotation
    for key, stream in view.streams().items():
        content[key] = _stream(stream)
    if view.depth is not None:
        content["depth"]["unit"] = view.depth_unit
    return content


def _stream(stream: Stream) -> dict[str, Any]:
    content: dict[str, Any] = {"frames": stream.frames}
    if stream.camera:
        content["camera"] = stream.camera
    if stream.background is not None:
        content["background"] = stream.background
    if stream.first_frame:
        content["first_frame"] = stream.first_frame
    if stream.time_offset:
        content["time_offset"] = stream.time_offset
    return content


def counts_of(metres: Float32Array, unit: float) -> NDArray[np.uint16]:
    """Depth counts (H, W) of metres; 0 where it is NaN or more than 16 bits hold."""
    counts = np.round(np.nan_to_num(metres, nan=0.0, posinf=0.0, neginf=0.0) / unit)
    counts[(counts < 0) | (counts > np.iinfo(np.uint16).max)] = 0
    return counts.astype(np.uint16)
