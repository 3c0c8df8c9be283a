"""The eye that circles around a point of the scene."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray

FIELD_OF_VIEW = np.radians(32.0)
_CLOSEST, _FARTHEST = 0.15, 60.0
_STEEPEST = np.pi / 2
_MARGIN = 1.12
_LEAST_DISTANCE = 1.0


@dataclass(frozen=True, eq=False)
class Orbit:
    """Where the eye is; z is up in the world."""

    focus: FloatArray  # (3,) float64, world, metres. The point that is looked at.
    azimuth: float
    elevation: float
    """`azimuth` and `elevation`: radians. Direction from the focus to the eye; azimuth 0 is east, a
    quarter turn is north."""
    distance: float  # metres

    @property
    def toward_eye(self) -> FloatArray:
        """Unit vector (3,) from the focus to the eye."""
        return self._along(np.cos(self.elevation), np.sin(self.elevation))

    @property
    def eye(self) -> FloatArray:
        """Place of the eye (3,), world, metres."""
        return self.focus + self.distance * self.toward_eye

    @property
    def up(self) -> FloatArray:
        """Unit vector (3,) that points up in the picture; defined from above as well."""
        return self._along(-np.sin(self.elevation), np.cos(self.elevation))

    def _along(self, flat: float, up: float) -> FloatArray:
        return np.array([flat * np.cos(self.azimuth), flat * np.sin(self.azimuth), up])

    @property
    def right(self) -> FloatArray:
        """Unit vector (3,) that points right in the picture."""
        return np.array([-np.sin(self.azimuth), np.cos(self.azimuth), 0.0])

    def turned(self, right: float, up: float) -> Orbit:
        """Return the eye after circling by angles in radians; it stops above and below."""
        elevation = float(np.clip(self.elevation + up, -_STEEPEST, _STEEPEST))
        return replace(self, azimuth=self.azimuth + right, elevation=elevation)

    def moved(self, right: float, up: float) -> Orbit:
        """Return the eye after moving sideways by shares of the picture's height."""
        metres = 2.0 * self.distance * np.tan(FIELD_OF_VIEW / 2)
        return replace(self, focus=self.focus + metres * (right * self.right + up * self.up))

    def zoomed(self, factor: float) -> Orbit:
        """Return the eye `factor` times as near, within sensible limits."""
        distance = float(np.clip(self.distance / factor, _CLOSEST, _FARTHEST))
        return replace(self, distance=distance)

    def project(self, points: FloatArray, width: float, height: float) -> FloatArray:
        """Picture positions (K, 2) of world points (K, 3); NaN behind the eye."""
        relative = np.asarray(points, dtype=np.float64).reshape(-1, 3) - self.eye
        depth = -relative @ self.toward_eye
        depth = np.where(depth > 1e-3, depth, np.nan)
        flat = relative @ np.column_stack([self.right, -self.up]) / depth[:, None]
        scale = height / 2 / np.tan(FIELD_OF_VIEW / 2)
        places: FloatArray = (width / 2, height / 2) + scale * flat
        return places

    def ray(self, x: float, y: float, width: float, height: float) -> FloatArray:
        """Direction (3,), not normalised, from the eye through a position in the picture."""
        slope = np.tan(FIELD_OF_VIEW / 2) / (height / 2)
        aside = (x - width / 2) * self.right + (height / 2 - y) * self.up
        ray: FloatArray = slope * aside - self.toward_eye
        return ray


STANDARD_VIEWS: dict[str, tuple[float, float]] = {
    "home": (np.radians(60.0), np.radians(14.0)),
    "front": (np.pi / 2, 0.0),
    "side": (0.0, 0.0),
    "top": (-np.pi / 2, np.pi / 2),
}
"""Azimuth and elevation; a person in the initial pose faces north, so front is from there."""


def orbit_around(points: FloatArray, view: str, aspect: float = 1.0) -> Orbit:
    """Return the `view`, of :data:`STANDARD_VIEWS`, from which all world `points` (K, 3) are seen.

    Without points a person's place at the origin is looked at; `aspect` is the picture's width over
    its height.
    """
    azimuth, elevation = STANDARD_VIEWS[view]
    if not len(points):
        points = np.array([[-0.9, -0.9, 0.0], [0.9, 0.9, 1.9]])
    orbit = Orbit(points.mean(axis=0), azimuth, elevation, 1.0)
    relative = points - orbit.focus
    across, upward = relative @ orbit.right, relative @ orbit.up
    focus = orbit.focus + _middle(across) * orbit.right + _middle(upward) * orbit.up
    # a point is seen where it stands aside by no more than the opening at its own depth
    slope = np.tan(FIELD_OF_VIEW / 2)
    aside = np.maximum(
        np.abs(across - _middle(across)) / max(aspect, 0.3), np.abs(upward - _middle(upward))
    )
    distance = float(np.max(relative @ orbit.toward_eye + _MARGIN * aside / slope))
    return Orbit(focus, azimuth, elevation, max(distance, _LEAST_DISTANCE))


def _middle(values: FloatArray) -> float:
    return 0.5 * float(values.min() + values.max())
