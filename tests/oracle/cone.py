"""Truncated cones by brute force; everything in the cone's own frame, y flattened by s."""

import numpy as np


def side_point(r1, r2, height, s, h, angle):
    """Point of the side at the share h of the height and an angle."""
    radius = r1 + h * (r2 - r1)
    return np.array([radius * np.cos(angle), s * radius * np.sin(angle), h * height])


def nearest(surface, centre, limits, point, steps):
    """Nearest point of a surface (2 numbers to 3): the best of a grid, then of ever finer grids."""
    width = centre.copy()
    for _ in range(14):
        u, v = (np.linspace(c - w, c + w, steps) for c, w in zip(centre, width, strict=True))
        u = np.clip(u, *limits)
        grid = surface(u[:, None] + 0 * v[None], v[None] + 0 * u[:, None])
        distance = np.sqrt(sum((grid[k] - point[k]) ** 2 for k in range(3)))
        i, j = np.unravel_index(np.argmin(distance), distance.shape)
        centre, width = np.array([u[i], v[j]]), width * 4.0 / steps
    return surface(*centre)


def nearest_on_side(r1, r2, height, s, point):
    """Nearest point of the side."""

    def side(h, angle):
        return side_point(r1, r2, height, s, h, angle)

    return nearest(side, np.array([0.5, np.pi]), (0.0, 1.0), point, 48)


def nearest_on_half_sphere(r, centre_z, s, point):
    """Nearest point of the half (flattened) sphere beyond z = centre_z."""

    def half_sphere(up, angle):
        across = r * np.cos(up)
        places = across * np.cos(angle), s * across * np.sin(angle), centre_z + r * np.sin(up)
        return np.array(places)

    return nearest(half_sphere, np.array([np.pi / 4, np.pi]), (0.0, np.pi / 2), point, 60)


def depth_inside(r1, r2, height, s, point):
    """How deep a point is inside the solid, roughly, in metres; negative outside."""
    x, y, z = point
    across = (r1 + (r2 - r1) * z / height) - np.hypot(x, y / s)
    return min(across, z, height - z)
