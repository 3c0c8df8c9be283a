"""Other axes than the world's that a reference may have been written with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS

Axes: TypeAlias = tuple[str, str, str]

AXES: Mapping[str, Axes] = {
    "its y axis points up: z must point up": ("x", "-z", "y"),
    "its y axis points down: z must point up": ("x", "z", "-y"),
    "its x axis points up: z must point up": ("z", "y", "-x"),
    "x and y are exchanged": ("y", "x", "z"),
}
"""What may be wrong about its axes, and what has to be written for x, y and z then."""

_MOST, _MORE = 0.7, 0.04
"""Share of a reference that the images have to show, and by how much more than as it is."""

_LYING, _STANDING = 0.3, 0.6
"""Cosines between a person's trunk and up."""


def turned(points: FloatArray, axes: Axes) -> FloatArray:
    """Points (..., 3) with these coordinates, such as ``-z``, for x, y and z."""
    return np.stack(
        [points[..., "xyz".index(axis[-1])] * (1 - 2 * axis.startswith("-")) for axis in axes], -1
    )


def axes_by_images(recording: Recording) -> tuple[str, float, float] | None:
    """The axes with which the images show an upright reference that they do not show as it is.

    With the shares of it that the images show as it is, and then. For recordings without depth.
    """
    reference = recording.reference
    if reference is None:
        return None
    given = _shown(recording, reference.points)
    if given is None or _uprightness(reference.points) > _LYING:
        return None
    shares = {
        said: share
        for said, axes in AXES.items()
        if _uprightness(points := turned(reference.points, axes)) > _STANDING
        and (share := _shown(recording, points)) is not None
    }
    best = max(shares, key=lambda said: shares[said], default="")
    clear = bool(best) and shares[best] > max(_MOST, given + _MORE)
    return (best, given, shares[best]) if clear else None


def _shown(recording: Recording, points: FloatArray) -> float | None:
    """Share of landmarks (F, 9, 3) within the images, mean over the views; None without any."""
    known = points[np.isfinite(points).all(axis=-1)][::7]
    shares = []
    for view in recording.views:
        camera = recording.cameras.get(view.image.camera)
        if camera is None or not len(known):
            continue
        x, y = camera.project(known).T
        inside = (x >= 0) & (x < camera.width) & (y >= 0) & (y < camera.height)
        shares.append(float(inside.mean()))
    return float(np.mean(shares)) if shares else None


def _uprightness(points: FloatArray) -> float:
    """Cosine between the way from hips to head and up, median over the frames; NaN if unknown."""
    head, *hips = (LANDMARKS.index(name) for name in ("head", "left_hip", "right_hip"))
    trunk = points[:, head] - points[:, hips].mean(axis=1)
    trunk = trunk[np.isfinite(trunk).all(axis=1)]
    if not len(trunk):
        return float("nan")
    return float(np.median(trunk[:, 2] / np.maximum(np.linalg.norm(trunk, axis=1), 1e-9)))
