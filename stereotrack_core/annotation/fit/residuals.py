"""Clicks and measured points as residuals of the fit's state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.fit.measurement import ClickMeasurement
from stereotrack_core.annotation.fit.state import Freedom
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.manifold import Columns
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.tracking.residuals.surface import SurfaceResidual

_NEAREST = 0.05
"""Metres in front of a camera; nearer points, and those behind it, are drawn at this distance."""

_STEP = 0.5
"""Pixels by which the lens distortion's derivative is taken."""


@dataclass(frozen=True, eq=False)
class Clicks:
    """The clicks of one frame, freed from lens distortion.

    A click is where the ray through it meets z = 1 of its camera; differences there are turned
    into raw pixels by the distortion's derivative at the click, so that sigma means what it says
    in every corner of a lens.

    Attributes
    ----------
    landmark : (M,) int64
        Index into the set of landmarks.
    camera : (M,) int64
        Index into `cameras`.
    normalised : (M, 2) float64
    raw_from_normalised : (M, 2, 2) float64
        Pixels.
    sigma : (M,) float64
        Pixels per axis.
    rotations : (M, 3, 3) float64
        camera_from_world.
    translations : (M, 3) float64
    """

    landmark: IntArray
    camera: IntArray
    normalised: FloatArray
    raw_from_normalised: FloatArray
    sigma: FloatArray
    rotations: FloatArray
    translations: FloatArray

    def __len__(self) -> int:
        return len(self.landmark)


def undistorted_clicks(
    measurements: Sequence[ClickMeasurement],
    cameras: Mapping[str, Camera],
    names: Sequence[str],
) -> Clicks:
    """Free clicks from the distortion of their lenses.

    Raises
    ------
    KeyError
        For a camera or landmark that is not known.
    """
    known = tuple(cameras)
    index_of = {name: i for i, name in enumerate(known)}
    camera = np.array([index_of[one.camera] for one in measurements], dtype=np.int64)
    pixel = np.array([one.pixel for one in measurements], dtype=np.float64).reshape(-1, 2)
    normalised, slope = np.empty((len(camera), 2)), np.empty((len(camera), 2, 2))
    around = _STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    for index in np.unique(camera):
        chosen = camera == index
        flat = cameras[known[index]].normalised(pixel[chosen][:, None] + around)
        normalised[chosen] = flat[:, 0]
        slope[chosen] = np.stack([flat[:, 1] - flat[:, 2], flat[:, 3] - flat[:, 4]], axis=-1)
    places = [cameras[known[index]].camera_from_world for index in camera]
    stretch = np.asarray(np.linalg.inv(slope / (2.0 * _STEP)), dtype=np.float64)
    return Clicks(
        landmark=np.array([names.index(one.landmark) for one in measurements], dtype=np.int64),
        camera=camera,
        normalised=normalised,
        raw_from_normalised=stretch,
        sigma=np.array([one.sigma for one in measurements], dtype=np.float64),
        rotations=np.array([place.rotation for place in places]).reshape(-1, 3, 3),
        translations=np.array([place.translation for place in places]).reshape(-1, 3),
    )


@dataclass(frozen=True, eq=False)
class ClickResidual:
    """Places of clicked landmarks in the pictures: raw pixels, x and y of each click in turn.

    Attributes
    ----------
    clicks : Clicks
    freedom : Freedom
    local : (L, 3) float64
        The landmarks in their parts' frames.
    variance : (2 M,) float64
    """

    clicks: Clicks
    freedom: Freedom
    local: FloatArray
    variance: FloatArray

    @property
    def measured(self) -> FloatArray:
        """The clicks (2 M,)."""
        return _pixels(self.clicks, self.clicks.normalised)

    def predicted(self, frames: PartFrames) -> FloatArray:
        """The landmarks (S, 2 M) for stacked poses."""
        part = self.freedom.parts[self.clicks.landmark]
        own = self.local[self.clicks.landmark]
        world = frames.apply(part, own)
        inside = _in_cameras(self.clicks, world)
        return _pixels(self.clicks, inside[..., :2] / inside[..., 2:])

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:  # noqa: ARG002
        """Derivatives (2 M, n) at one pose; the columns are those of the fit's own state."""
        c = self.clicks
        places = frames.apply(self.freedom.parts, self.local)
        inside = _in_cameras(c, places[c.landmark])
        flat = np.zeros((len(c), 2, 3))
        flat[:, 0, 0] = flat[:, 1, 1] = 1.0
        flat[:, :, 2] = -inside[:, :2] / inside[:, 2:]
        flat /= inside[:, 2, None, None]
        gradients = (c.raw_from_normalised @ flat @ c.rotations).reshape(-1, 3)
        return self.freedom.landmark_jacobian(np.repeat(c.landmark, 2), gradients, places, frames)


def _in_cameras(clicks: Clicks, world: FloatArray) -> FloatArray:
    inside: FloatArray = np.einsum("mij,...mj->...mi", clicks.rotations, world)
    inside = inside + clicks.translations
    inside[..., 2] = np.maximum(inside[..., 2], _NEAREST)
    return inside


def _pixels(clicks: Clicks, normalised: FloatArray) -> FloatArray:
    pixels = np.einsum("mij,...mj->...mi", clicks.raw_from_normalised, normalised)
    result: FloatArray = pixels.reshape(*normalised.shape[:-2], -1)
    return result


@dataclass(frozen=True, eq=False)
class SlippingSurface:
    """Distances of measured points, or outlines, from a surface that may slip against its limbs.

    Attributes
    ----------
    surface : SurfaceResidual
        Paired at the slipped frames.
    freedom : Freedom
    slipped : PartFrames or None
        Of the pose that the points were paired at; None where the surface does not slip.
    """

    surface: SurfaceResidual
    freedom: Freedom
    slipped: PartFrames | None

    @property
    def measured(self) -> FloatArray:
        """Signed distances (m,) of the points at the pose that they were paired at."""
        return self.surface.distance

    @property
    def variance(self) -> FloatArray:
        """Variances (m,)."""
        return self.surface.variance

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Nothing to be left (S, m); pairs hold for one pose only."""
        return np.zeros((len(frames.origins), len(self.surface.part)))

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:  # noqa: ARG002
        """Derivatives (m, n) of the feet on their directions."""
        s = self.surface
        J = self.freedom.jacobian(s.foot, s.direction, s.part, frames)
        if self.slipped is None:
            return J
        first = self.freedom.of_slips.start
        for limb in range(len(LIMBS)):
            a, b = np.searchsorted(s.part, [limb, limb + 1])
            if a < b:
                along = s.direction[a:b] @ self.slipped.rotations[limb]
                turn = np.cross(s.foot_in_part[a:b], along)
                at = first + 6 * limb
                J[a:b, at : at + 3], J[a:b, at + 3 : at + 6] = along, turn
        return J
