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

_FEW, _MOST = 0.3, 0.7
"""Shares of a reference within the images from which it is elsewhere, or where it should be."""


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
    if given is None or given > _FEW:
        return None
    shares = {
        said: share
        for said, axes in AXES.items()
        if _is_upright(points := turned(reference.points, axes))
        and (share := _shown(recording, points)) is not None
    }
    best = max(shares, key=lambda said: shares[said], default="")
    return (best, given, shares[best]) if best and shares[best] > _MOST else None


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


def _is_upright(points: FloatArray) -> bool:
    head, *hips = (LANDMARKS.index(name) for name in ("head", "left_hip", "right_hip"))
    above = points[:, head, 2] - points[:, hips, 2].mean(axis=1)
    return bool(np.nanmedian(above) > 0) if np.isfinite(above).any() else False
