"""Ranges of truncated cones, one ray and one quadratic equation at a time."""

import numpy as np


def cast(solids, focal, c_x, c_y, world_from_camera, width, height):
    """Range (H, W) along the camera's z of the first solid on each pixel's ray; inf where none.

    `solids` are (world_from_cone (3, 3), origin (3,), r1, r2, height, s, whether the far end is
    a half sphere). `world_from_camera` has a rotation (3, 3) and a translation (3,).
    """
    v, u = np.mgrid[:height, :width].astype(float)
    rays = np.stack([(u - c_x) / focal, (v - c_y) / focal, np.ones_like(u)], axis=-1)
    rays = rays.reshape(-1, 3) @ world_from_camera.rotation.T
    eye = world_from_camera.translation
    squares, nearest = (rays**2).sum(axis=1), np.full(len(rays), np.inf)
    for turn, origin, r1, r2, h, s, rounded in solids:
        middle = origin + 0.5 * h * turn[:, 2] - eye
        bound = 0.5 * h + 2.0 * max(r1, r2)
        along = rays @ middle
        near = np.flatnonzero((along > 0.0) & (middle @ middle - along**2 / squares < bound**2))
        stretch = np.array([1.0, 1.0 / s, 1.0])
        start, ray = (eye - origin) @ turn * stretch, rays[near] @ turn * stretch
        hits = [*_side(start, ray, r1, r2, h), _disc(start, ray, r1, 0.0)]
        hits += _ball(start, ray, r2, h) if rounded else [_disc(start, ray, r2, h)]
        nearest[near] = np.minimum(nearest[near], np.min(hits, axis=0))
    return nearest.reshape(height, width)


def _roots(a, b, c):
    """Roots (2) of a t^2 + 2 b t + c; inf where there are none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        both = [(-b - root) / a, (-b + root) / a]
    return [np.where(np.isfinite(t) & (t > 0.0), t, np.inf) for t in both]


def _kept(t, start, ray, low, high):
    z = start[2] + np.where(np.isfinite(t), t, 0.0) * ray[:, 2]
    return np.where((z >= low) & (z <= high), t, np.inf)


def _side(start, ray, r1, r2, h):
    k = (r2 - r1) / h
    r, dr = r1 + k * start[2], k * ray[:, 2]
    a = ray[:, 0] ** 2 + ray[:, 1] ** 2 - dr**2
    b = start[0] * ray[:, 0] + start[1] * ray[:, 1] - r * dr
    c = start[0] ** 2 + start[1] ** 2 - r**2
    return [_kept(t, start, ray, 0.0, h) for t in _roots(a, b, c)]


def _ball(start, ray, r, h):
    from_centre = start - [0.0, 0.0, h]
    a, b = (ray**2).sum(axis=1), ray @ from_centre
    return [
        _kept(t, start, ray, h, np.inf) for t in _roots(a, b, from_centre @ from_centre - r * r)
    ]


def _disc(start, ray, r, z):
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (z - start[2]) / ray[:, 2]
        inside = np.hypot(start[0] + t * ray[:, 0], start[1] + t * ray[:, 1]) <= r
    return np.where(inside & (t > 0.0), t, np.inf)
