"""Truncated cones by brute force; everything in the cone's own frame, y flattened by s."""

from __future__ import annotations

import numpy as np


def side_point(r1, r2, height, s, h, angle):
    """Point of the side at the share h of the height and an angle."""
    radius = r1 + h * (r2 - r1)
    return np.array([radius * np.cos(angle), s * radius * np.sin(angle), h * height])


def nearest_on_side(r1, r2, height, s, point, steps=48):
    """Nearest point of the side: the best of a grid, then ever finer grids around the best."""
    centre, width = np.array([0.5, np.pi]), np.array([0.5, np.pi])
    for _ in range(14):
        h = np.clip(np.linspace(centre[0] - width[0], centre[0] + width[0], steps), 0.0, 1.0)
        angle = np.linspace(centre[1] - width[1], centre[1] + width[1], steps)
        grid = side_point(r1, r2, height, s, h[:, None] + 0 * angle, angle[None] + 0 * h[:, None])
        distance = np.sqrt(sum((grid[k] - point[k]) ** 2 for k in range(3)))
        i, j = np.unravel_index(np.argmin(distance), distance.shape)
        centre = np.array([h[i], angle[j]])
        width = width * 4.0 / steps
    return side_point(r1, r2, height, s, *centre)


def nearest_on_half_sphere(r, centre_z, s, point, steps=60):
    """Nearest point of the half (flattened) sphere beyond z = centre_z, by ever finer grids."""
    centre, width = np.array([np.pi / 4, np.pi]), np.array([np.pi / 4, np.pi])
    for _ in range(12):
        up = np.clip(np.linspace(centre[0] - width[0], centre[0] + width[0], steps), 0, np.pi / 2)
        angle = np.linspace(centre[1] - width[1], centre[1] + width[1], steps)
        x = r * np.cos(up)[:, None] * np.cos(angle)
        y = s * r * np.cos(up)[:, None] * np.sin(angle)
        z = centre_z + r * np.sin(up)[:, None] + 0 * angle
        distance = np.sqrt((x - point[0]) ** 2 + (y - point[1]) ** 2 + (z - point[2]) ** 2)
        i, j = np.unravel_index(np.argmin(distance), distance.shape)
        centre = np.array([up[i], angle[j]])
        width = width * 4.0 / steps
    return np.array([x[i, j], y[i, j], z[i, j]])


def depth_inside(r1, r2, height, s, point):
    """How deep a point is inside the solid, roughly, in metres; negative outside."""
    x, y, z = point
    across = (r1 + (r2 - r1) * z / height) - np.hypot(x, y / s)
    return min(across, z, height - z)
