"""Everything that the views measure at one instant, the room included."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.chain import source_of
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.sources import NoDepth
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameSet

_STEP = 3  # pixels between points
_FARTHEST_M = 8.0


def scene_points(
    recording: Recording, frame_set: FrameSet, parameters: DepthParameters, views: Sequence[str]
) -> FloatArray:
    """Points (N, 3), world, metres, of a frame without subtraction of any background.

    Views without depth at that instant give none. Raises InputError for a stereo camera that cannot
    be rectified.
    """
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
