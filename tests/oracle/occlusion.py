"""Occlusion by walking along every sight line in small steps."""

import numpy as np


def deepest(start, end, solids, step=0.002):
    """How deep the segment from `start` to `end` dips into any solid, metres; negative if free.

    `solids` are (world_from_cone (3, 3), origin (3,), r1, r2, height, s); the depth is counted
    across the cone where the point lies between its ends.
    """
    count = int(np.ceil(np.linalg.norm(end - start) / step)) + 1
    walk = start + np.linspace(0.0, 1.0, count)[1:, None] * (end - start)
    most = -np.inf
    for rotation, origin, r1, r2, height, s in solids:
        local = (walk - origin) @ rotation
        z = local[:, 2]
        across = r1 + (r2 - r1) * z / height - np.hypot(local[:, 0], local[:, 1] / s)
        between = (z > 0) & (z < height)
        if between.any():
            most = max(most, across[between].max())
    return most


def solids_of(placed):
    """The cones of a placed body as plain tuples."""
    names = "rotation", "origin", "r1", "r2", "height", "flatness"
    return [tuple(cone[name] for name in names) for cone in placed]
