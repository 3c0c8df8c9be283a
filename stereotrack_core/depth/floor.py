"""The floor that stereo or depth views of a recording see turns a calibration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.align import Alignment, from_floor
from stereotrack_core.depth.chain import source_of
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.sources import NoDepth
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader, FrameSet
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
    """Alignment by the largest plane below the cameras in the depth of one frame of a recording.

    `cameras` is the calibration that is turned; the recording's own is not used. `north` names the
    camera that stands in the north, by default that of the first view; `where` what lacks a camera,
    for the message.

    Raises InputError if a camera is missing, no view has depth, or no floor is seen.
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
    """:func:`alignment_to_floor` as a task of a process, for a window."""

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


_STEP = 3  # pixels between points
_FARTHEST_M = 8.0


def scene_points(
    recording: Recording, frame_set: FrameSet, parameters: DepthParameters, views: Sequence[str]
) -> FloatArray:
    """Points (N, 3), world, metres, of a frame with its background; raises InputError."""
    everywhere = parameters.replaced(disparity_from_volume=False)
    parts = [np.zeros((0, 3))]
    for name in views:
        source = source_of(recording, recording.view(name), everywhere)
        geometry = source.geometry
        try:
            opened = source.open(frame_set.views[name])
            disparity = opened.disparity(Region.whole(geometry.width, geometry.height))
        except (NoDepth, KeyError):
            continue
        ranges = source.ranges(disparity).astype(np.float64)[::_STEP, ::_STEP]
        v, u = np.nonzero(np.isfinite(ranges) & (ranges > 0) & (ranges < _FARTHEST_M))
        parts.append(geometry.points(_STEP * u, _STEP * v, ranges[v, u]))
    return np.concatenate(parts)
