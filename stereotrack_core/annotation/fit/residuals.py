"""Clicks and measured points as residuals of the fit's state, and which clicks are outliers.

A click is judged by where everything but itself expects the landmark; judged by the fit that it
took part in, a click with a high leverage would always look right.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.state import Freedom
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.filtering.linearisation import Information, information
from stereotrack_core.recording.description import Cameras
from stereotrack_core.tracking.residuals.surface import SurfaceResidual

_NEAREST = 0.05  # metres in front of a camera at which nearer points are drawn
_STEP = 0.5  # pixels by which the lens distortion's derivative is taken


@dataclass(frozen=True, eq=False)
class Clicks:
    """The clicks of one frame, freed from lens distortion, at z = 1 of their cameras.

    Differences are turned into raw pixels by the distortion's derivative at the click.
    """

    landmark: IntArray  # (M,); index into the set of landmarks
    camera: IntArray  # (M,); index into `cameras`
    normalised: FloatArray  # (M, 2)
    raw_from_normalised: FloatArray  # (M, 2, 2); pixels
    sigma: FloatArray  # (M,); pixels per axis
    share: FloatArray  # (M,); how probable an outlier is before anything is known
    rotations: FloatArray  # (M, 3, 3); camera_from_world
    translations: FloatArray  # (M, 3)

    def __len__(self) -> int:
        return len(self.landmark)


def undistorted_clicks(
    measurements: Sequence[Click], cameras: Cameras, names: Sequence[str], share: float
) -> Clicks:
    """Free clicks from distortion, of which a `share` are outliers.

    Raises KeyError for an unknown camera or landmark.
    """
    known = tuple(cameras)
    index_of = {name: i for i, name in enumerate(known)}
    camera = np.array([index_of[one.camera] for one in measurements], dtype=np.int64)
    pixel = np.array([one.position for one in measurements], dtype=np.float64).reshape(-1, 2)
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
        share=_outlier_shares(measurements, share),
        rotations=np.array([place.rotation for place in places]).reshape(-1, 3, 3),
        translations=np.array([place.translation for place in places]).reshape(-1, 3),
    )


def _outlier_shares(clicks: Sequence[Click], share: float) -> FloatArray:
    """Share of outliers (M,) among clicks such as each of them.

    Where a person clicked a landmark that is accepted in other images of the frame, what is
    accepted is wrong in all of them or in none: each alone, three would make the one an outlier.
    """
    accepted = {(one.frame, one.landmark) for one in clicks if one.accepted}
    contested = accepted & {(one.frame, one.landmark) for one in clicks if not one.accepted}
    factor = [
        1.0 if (c.frame, c.landmark) not in contested else _SUSPECT if c.accepted else _BELIEVED
        for c in clicks
    ]
    return np.asarray(np.clip(share * np.array(factor, dtype=np.float64), 1e-12, 0.5))


@dataclass(frozen=True, eq=False)
class ClickResidual:
    """Places of clicked landmarks in the pictures: raw pixels, x and y of each click in turn."""

    clicks: Clicks
    freedom: Freedom
    local: FloatArray  # (L, 3) are the landmarks in their parts' frames, `variance` is (2 M,)
    variance: FloatArray

    def missed(self, frames: PartFrames) -> FloatArray:
        """Click minus landmark (M, 2) in pixels at one pose."""
        c = self.clicks
        inside = _in_cameras(
            c, frames.apply(self.freedom.parts[c.landmark], self.local[c.landmark])
        )
        off = c.normalised - inside[:, :2] / inside[:, 2:]
        return np.asarray(np.einsum("mij,mj->mi", c.raw_from_normalised, off))

    def jacobian(self, frames: PartFrames) -> FloatArray:
        """Derivatives (2 M, n) by the fit's own state at one pose."""
        c = self.clicks
        places = frames.apply(self.freedom.parts, self.local)
        inside = _in_cameras(c, places[c.landmark])
        flat = np.zeros((len(c), 2, 3))
        flat[:, 0, 0] = flat[:, 1, 1] = 1.0
        flat[:, :, 2] = -inside[:, :2] / inside[:, 2:]
        flat /= inside[:, 2, None, None]
        gradients = (c.raw_from_normalised @ flat @ c.rotations).reshape(-1, 3)
        return self.freedom.landmark_jacobian(np.repeat(c.landmark, 2), gradients, places, frames)

    def information(self, frames: PartFrames) -> Information:
        """Normal equations of the fit's own state at one pose."""
        J = self.jacobian(frames)
        return information(J.T, self.missed(frames).ravel(), self.variance)


def _in_cameras(clicks: Clicks, world: FloatArray) -> FloatArray:
    inside: FloatArray = np.einsum("mij,mj->mi", clicks.rotations, world) + clicks.translations
    inside[:, 2] = np.maximum(inside[:, 2], _NEAREST)
    return inside


@dataclass(frozen=True, eq=False)
class BiasedSurface:
    """Distances of points, paired at the biased frames, from a surface that is off its limbs."""

    surface: SurfaceResidual
    freedom: Freedom
    biased: PartFrames

    def information(self, frames: PartFrames) -> Information:
        """Normal equations of the fit's own state, where the points were paired."""
        s = self.surface
        J = self.freedom.jacobian(s.point, s.direction, s.part, frames)
        first = self.freedom.of_biases.start
        point_in_part = s.point_in_part
        for limb in range(len(LIMBS)):
            a, b = np.searchsorted(s.part, [limb, limb + 1])
            if a < b:
                along = s.direction[a:b] @ self.biased.rotations[limb]
                turn = np.cross(point_in_part[a:b], along)
                at = first + 6 * limb
                J[a:b, at : at + 3], J[a:b, at + 3 : at + 6] = along, turn
        return information(J.T, s.distance, s.variance)


_LEAST_WEIGHT = 1e-4
MEDIAN_SURPRISE = 2.0 * np.log(2.0)  # median of chi squared with two degrees of freedom
_UPPER_QUARTILE = 2.0 * np.log(4.0)  # the same for the upper quartile
_TOLD_BY_OTHERS = 0.9  # leverage below which others say something of a click
_ENOUGH = 6  # clicks whose scatter can be told


@dataclass(frozen=True, eq=False)
class Judgement:
    """Each of M clicks judged by the others."""

    outlier_probability: FloatArray  # (M,)
    leverage: FloatArray  # (M,); share (0 to 1) of the click in where its landmark is fitted
    surprise: FloatArray  # (M,); squared distance from what the rest expects, over its variance

    @property
    def weight(self) -> FloatArray:
        """How far each click is believed (M,)."""
        return np.maximum(1.0 - self.outlier_probability, _LEAST_WEIGHT)


_SUSPECT, _BELIEVED = 20.0, 1e-3  # on the share of outliers; see :func:`_outlier_shares`
_OUTLIER_SPREAD = 70.0  # pixels per axis; standard deviation of outliers


def judged(
    residual: FloatArray,
    spread: FloatArray,
    sigma: FloatArray,
    weight: FloatArray,
    share: FloatArray,
) -> Judgement:
    """Judge clicks by all but themselves, expecting a share (M,) of outliers.

    `residual` (M, 2) is click minus fitted place in pixels, `spread` (M, 2, 2) the covariance
    J P J' of the fitted places, in which the clicks took part with the variance sigma^2 / weight.
    """
    if not len(residual):
        return Judgement(np.zeros(0), np.zeros(0), np.zeros(0))
    eye = np.eye(2)
    taken = spread * (weight / sigma**2)[:, None, None]
    leverage = np.clip(0.5 * np.trace(taken, axis1=1, axis2=2), 0.0, 1.0)
    # a click that alone decides is kept just invertible: without it nothing is known
    values, vectors = np.linalg.eigh(0.5 * (taken + np.swapaxes(taken, 1, 2)))
    values = np.clip(values, 0.0, 1.0 - 1e-6)
    kept = np.asarray((vectors * values[:, None, :]) @ np.swapaxes(vectors, 1, 2))
    without = np.asarray(np.linalg.inv(eye - kept), dtype=np.float64)
    alone = np.einsum("mij,mj->mi", without, residual)
    expected = without @ spread
    right = 0.5 * (expected + np.swapaxes(expected, 1, 2)) + sigma[:, None, None] ** 2 * eye
    wrong = right + _OUTLIER_SPREAD**2 * eye
    surprise = np.einsum("mi,mi->m", alone, np.linalg.solve(right, alone[..., None])[..., 0])
    log_right = _log_normal(alone, right) + np.log1p(-share)
    log_wrong = _log_normal(alone, wrong) + np.log(share)
    outlier = np.exp(log_wrong - np.logaddexp(log_right, log_wrong))
    return Judgement(outlier, leverage, surprise)


def mixture_cost(residual: FloatArray, sigma: FloatArray, share: FloatArray) -> FloatArray:
    """Cost (M,) of residuals (M, 2) in pixels: -2 log of how probable they are, 0 for none."""
    right, wrong = _mixture(residual, sigma, share)
    return -2.0 * np.logaddexp(right, wrong)


def mixture_weight(residual: FloatArray, sigma: FloatArray, share: FloatArray) -> FloatArray:
    """Weights (M,) on 1 / sigma^2 of a step that lowers the mixture's cost; never zero."""
    right, wrong = _mixture(residual, sigma, share)
    outlier = np.exp(wrong - np.logaddexp(right, wrong))
    return 1.0 - outlier + outlier * sigma**2 / (sigma**2 + _OUTLIER_SPREAD**2)


def _mixture(
    residual: FloatArray, sigma: FloatArray, share: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Logarithms (M,) of how probable residuals are of right and of wrong clicks."""
    squared = (residual**2).sum(axis=1)
    wide = sigma**2 + _OUTLIER_SPREAD**2
    right = np.log1p(-share) - 0.5 * squared / sigma**2
    wrong = np.log(share) - 0.5 * squared / wide + np.log(sigma**2 / wide)
    return right, wrong


def scatter(judgement: Judgement) -> float:
    """By which factor clicks scatter more than they were taken to (upper quartile); usually 1."""
    told = judgement.surprise[judgement.leverage < _TOLD_BY_OTHERS]
    if len(told) < _ENOUGH:
        return 1.0
    return float(np.sqrt(np.percentile(told, 75.0) / _UPPER_QUARTILE))


def _log_normal(x: FloatArray, P: FloatArray) -> FloatArray:
    squared = np.einsum("mi,mi->m", x, np.linalg.solve(P, x[..., None])[..., 0])
    return np.asarray(-0.5 * (squared + np.log(np.linalg.det(P))))
