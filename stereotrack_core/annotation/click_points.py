"""Clicked landmarks in space: every landmark from its clicks alone, nothing known of a body."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays


@dataclass(frozen=True, eq=False)
class ClickPixels:
    """Positions of clicks as arrays; F frames, L landmarks, V cameras.

    Attributes
    ----------
    frame : (F,) int64
        Frames that have a click, ascending.
    names : tuple of str
        Landmarks.
    cameras : tuple of Camera
    pixel : (F, L, V, 2) float64
        Raw-image pixels, NaN where nobody gave a position.
    """

    frame: IntArray
    names: tuple[str, ...]
    cameras: tuple[Camera, ...]
    pixel: FloatArray

    def points(self) -> FloatArray:
        """The point nearest to each landmark's rays (F, L, 3), world, metres.

        NaN where fewer than two cameras see it.
        """
        if not self.pixel.size:
            return np.full((*self.pixel.shape[:2], 3), np.nan)
        origins = np.stack([camera.position_world for camera in self.cameras])
        rays = [camera.rays_world(self.pixel[:, :, v]) for v, camera in enumerate(self.cameras)]
        return nearest_to_rays(origins, np.stack(rays, axis=2))


def click_pixels(
    clicks: Iterable[Click], cameras: Mapping[str, Camera], names: Sequence[str]
) -> ClickPixels:
    """Clicks as arrays; deleted ones, and other cameras' and landmarks', are left out."""
    places = {name: i for i, name in enumerate(names)}
    views = {name: v for v, name in enumerate(cameras)}
    kept = [
        (click.frame, places[click.landmark], views[click.camera], *click.position)
        for click in clicks
        if click.position is not None
        and not click.deleted
        and click.landmark in places
        and click.camera in views
    ]
    table = np.array(kept, dtype=np.float64).reshape(-1, 5)
    frame, rows = np.unique(table[:, 0].astype(np.int64), return_inverse=True)
    pixel = np.full((len(frame), len(places), len(views), 2), np.nan)
    pixel[rows, table[:, 1].astype(np.int64), table[:, 2].astype(np.int64)] = table[:, 3:]
    return ClickPixels(frame, tuple(names), tuple(cameras.values()), pixel)
