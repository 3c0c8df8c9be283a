"""Whether views agree about where somebody is: what one measures, no other one sees through.

A wrong calibration puts the views' points in different places; then many of them lie where another
view sees the background behind them. Nothing of the body has to be known for that.
"""

from __future__ import annotations

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.cloud import Cloud, ViewDepth

FRAMES_APART = 5
"""Of so many frames one is asked, which is enough for a calibration."""

_HALO = 9
"""Pixels in an image 640 wide by which a person may be wider than another view's points say."""

_WIDTH = 640

_BEHIND = 0.15
"""Metres by which the background has to be behind a point; what is nearer may be an occluder."""

_EVERY = 7
"""Points of which one is asked for."""

_FEWEST = 20
"""Points of other views without which a view is not asked."""


def contradicted_share(cloud: Cloud) -> float:
    """Share of the points that another view sees through, mean over the views that are asked.

    NaN where there are no two views, or too few points. Pixels without a depth prove nothing.
    """
    shares = []
    for place, name in enumerate(cloud.view_names):
        depth = cloud.depths.get(name)
        if depth is None:
            continue
        through = _seen_through(depth, cloud.points[cloud.view != place][::_EVERY])
        if through is not None:
            shares.append(through)
    return float(np.mean(shares)) if shares else float("nan")


def _seen_through(depth: ViewDepth, points: FloatArray) -> float | None:
    """Share of other views' points (N, 3) behind which a view sees the background."""
    geometry = depth.geometry
    x, y, z = geometry.world_from_depth.inverse().apply(points).T
    ahead = z > 0.0
    x, y, z = x[ahead], y[ahead], z[ahead]
    column = np.rint(geometry.focal * x / z + geometry.c_x)
    row = np.rint(geometry.focal * y / z + geometry.c_y)
    inside = (column >= 0) & (column < geometry.width) & (row >= 0) & (row < geometry.height)
    pixel = row[inside].astype(np.int64), column[inside].astype(np.int64)
    margin = max(1, round(_HALO * geometry.width / _WIDTH))
    kernel = np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)
    person = cv2.dilate(depth.person.view(np.uint8), kernel)[pixel] > 0
    seen = depth.range_z[pixel]
    asked = person | np.isfinite(seen)
    if np.count_nonzero(asked) < _FEWEST:
        return None
    through = ~person & (seen > z[inside] + _BEHIND)
    return float(np.mean(through[asked]))
