"""The floor that stereo or depth views of a recording see turns a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from stereotrack_core.calibrate.align import Alignment, from_floor
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.scene import scene_points
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.worker_processes import Asker


def alignment_to_floor(
    folder: Path,
    cameras: Mapping[str, Camera],
    parameters: DepthParameters,
    frame: int = 0,
    north: str = "",
    where: str = "calibration",
) -> Alignment:
    """The largest plane below the cameras in the depth of one frame of a recording.

    Parameters
    ----------
    folder
        Of the recording, whose own calibration is not used.
    cameras
        The calibration that is turned; it contains all cameras of the recording's views.
    parameters
        How depth is computed.
    north
        Camera that stands in the north; empty for that of the first view.
    where
        What lacks a camera, in the sentence that says so.

    Raises
    ------
    InputError
        A camera is missing, no view has depth, or no floor is seen.
    """
    recording = open_recording(folder)
    used = {s.camera for view in recording.views for s in view.streams().values() if s.camera}
    if missing := sorted(used - cameras.keys()):
        raise InputError(
            f"the calibration does not contain the camera {missing[0]!r}",
            where=where,
            remedy="Use the calibration of this recording's cameras.",
        )
    recording = replace(recording, cameras=cameras)
    views = usable_views(recording, None)
    with FrameReader(recording, views=views, read_ahead=0) as reader:
        frame_set = reader.frame_set(frame)
    points = scene_points(recording, frame_set, parameters, views)
    seeing = [recording.reference_camera(recording.view(name)) for name in views]
    return from_floor(points, seeing, cameras[north] if north else seeing[0])


@dataclass(frozen=True, eq=False)
class FindFloor:
    """The same as a task of a process, for a window."""

    folder: Path
    cameras: Mapping[str, Camera]
    parameters: DepthParameters
    frame: int
    north: str = ""

    def __call__(self, _asker: Asker) -> Alignment:
        """Do it in the process."""
        return alignment_to_floor(
            self.folder, self.cameras, self.parameters, self.frame, self.north
        )
