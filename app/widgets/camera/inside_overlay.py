"""What a step inside a frame draws over pictures and into the scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray

_LEAST_MOVE = 0.002
"""Metres by which a part of a ghost differs from the model before it is drawn."""


@dataclass(frozen=True, eq=False)
class Ghosts:
    """One cone of the model in several poses."""

    limb: str
    vertices: FloatArray
    """(S, V, 3) float64, world, metres."""


@dataclass(frozen=True, eq=False)
class Marked:
    """Lines or dots of one colour."""

    colour: str
    """#rrggbb."""
    places: FloatArray
    """(K, 2, 3) or (K, 3) float64, world, metres. Ends of lines, or dots."""


@dataclass(frozen=True, eq=False)
class InsideScene:
    """What one step draws, in the world."""

    ghosts: tuple[Ghosts, ...] = ()
    lines: tuple[Marked, ...] = ()
    dots: tuple[Marked, ...] = ()


@dataclass(frozen=True, eq=False)
class InsideOverlay:
    """The same in a picture's pixels."""

    ghosts: tuple[tuple[str, FloatArray], ...]
    """Tuple of (str, (K, 2) float64). Limb and silhouette of each cone of each ghost."""
    lines: tuple[tuple[str, FloatArray], ...]
    """Tuple of (str, (K, 2, 2) float64)."""
    dots: tuple[tuple[str, FloatArray], ...]
    """Tuple of (str, (K, 2) float64)."""


def inside_overlay(
    scene: InsideScene, project: Callable[[FloatArray], FloatArray]
) -> InsideOverlay:
    """Project what a step draws; see :data:`app.widgets.camera.overlays.Projection`."""
    return InsideOverlay(
        tuple(
            (ghost.limb, outline)
            for ghost in scene.ghosts
            for outline in _silhouettes(project(ghost.vertices))
        ),
        tuple((each.colour, project(each.places)) for each in scene.lines),
        tuple((each.colour, project(each.places)) for each in scene.dots),
    )


def moved_ghosts(ghosts: Sequence[Ghosts], model: Sequence[FloatArray]) -> tuple[Ghosts, ...]:
    """Ghosts without the cones that are where the model (V, 3) of each has them anyway."""
    found = []
    for ghost, vertices in zip(ghosts, model, strict=True):
        off = np.abs(ghost.vertices - vertices).max(axis=(1, 2))
        if (off > _LEAST_MOVE).any():
            found.append(Ghosts(ghost.limb, ghost.vertices[off > _LEAST_MOVE]))
    return tuple(found)


def _silhouettes(pixels: FloatArray) -> list[FloatArray]:
    """Convex hulls of stacked cones (S, V, 2) that lie before the camera."""
    usable = np.isfinite(pixels).all(axis=(1, 2)) & (np.abs(np.nan_to_num(pixels)) < 1e5).all(
        axis=(1, 2)
    )
    hulls = [cv2.convexHull(one.astype(np.float32))[:, 0] for one in pixels[usable]]
    return [np.asarray(hull, dtype=np.float64) for hull in hulls]
