"""What the fit says: places, their uncertainty, the limbs' angles, and words for a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.fit.residuals import Judgement
from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

CLICKED, INTERPOLATED, GAP = "clicked", "interpolated", "gap"
"""Kinds of frames: with clicks of their own, filled between them, nothing known."""

MISTAKEN = 0.5
"""A click is flagged where it is more probably a gross mistake than not."""


@dataclass(frozen=True, eq=False)
class FrameFit:
    """The body fitted to the clicks of one frame.

    Attributes
    ----------
    pose : Pose
    covariance : (n, n) float64
        Of the error state: the pose's numbers first (see :mod:`body.manifold`), then the
        freedom of the joints and landmarks.
    landmarks_world : (L, 3) float64, metres
        In the order of the set of landmarks.
    landmark_covariance : (L, 3, 3) float64, square metres, world
    residual_px : (M, 2) float64
        Click minus fitted place, raw pixels, in the order of the measurements.
    leverage : (M,) float64
        0: the rest decides where the landmark is in this picture; 1: this click alone does.
    mistake : (M,) float64
        Probability that the click is a gross mistake.
    limb_sigma_deg : (6,) float64
        Root mean square angle by which each limb may be off, in the order of ``LIMBS``.
    used_cameras : (L,) int64
        Cameras in which a landmark has a click that is probably no mistake.
    words : tuple of str
        What a person should know, most important first.
    sigma_factor : float
        By which factor the clicks are taken to scatter more than their sigma; 1 where they do not.
    """

    pose: Pose
    covariance: FloatArray
    landmarks_world: FloatArray
    landmark_covariance: FloatArray
    residual_px: FloatArray
    leverage: FloatArray
    mistake: FloatArray
    limb_sigma_deg: FloatArray
    used_cameras: IntArray
    words: tuple[str, ...] = ()
    sigma_factor: float = 1.0


@dataclass(frozen=True, eq=False)
class TrajectoryFit:
    """The body fitted to clicks over frames, forward and backward.

    Attributes
    ----------
    names : tuple of str
        Landmarks, in the order of the arrays.
    frame : (F,) int64
    landmarks : (F, L, 3) float64, world, metres
        NaN where nothing is known.
    covariance : (F, L, 3, 3) float64, square metres, world
    limb_sigma_deg : (F, 6) float64
        In the order of ``LIMBS``.
    kind : (F,) str
        ``clicked``, ``interpolated`` or ``gap``.
    nine : (F, 9, 3) float64, world, metres
        The landmarks of every reference, whatever set was clicked.
    residual_px : mapping from ClickKey to (2,) float64
        Click minus fitted place, raw pixels.
    mistake : mapping from ClickKey to float
        Probability that the click is a gross mistake.
    sigma_factor : float
        By what the clicks scatter more than their sigmas say.
    """

    names: tuple[str, ...]
    frame: IntArray
    landmarks: FloatArray
    covariance: FloatArray
    limb_sigma_deg: FloatArray
    kind: NDArray[np.str_]
    nine: FloatArray
    residual_px: Mapping[ClickKey, FloatArray]
    mistake: Mapping[ClickKey, float]
    sigma_factor: float = 1.0

    def trajectory(self) -> LandmarkTrajectory:
        """The nine landmarks, as a reference holds them."""
        return LandmarkTrajectory(self.frame, self.nine)

    def flagged(self) -> tuple[ClickKey, ...]:
        """Clicks that are more probably gross mistakes than not, in their order."""
        return tuple(sorted(key for key, p in self.mistake.items() if p > MISTAKEN))


_UNSURE = 0.02
"""Metres of standard deviation in the worst direction from which a landmark is spoken of."""

_UNSURE_LIMB = 10.0
"""Degrees from which a limb is spoken of."""

_ALONG = np.cos(np.radians(35.0))
"""A direction nearer to a camera's ray than this is along its view."""


@dataclass(frozen=True, eq=False)
class Reported:
    """One frame in the world.

    Attributes
    ----------
    places : (L, 3) float64, metres
    covariance : (L, 3, 3) float64
    limb_sigma_deg : (6,) float64
    nine : (9, 3) float64
        In the order of ``LANDMARKS``.
    """

    places: FloatArray
    covariance: FloatArray
    limb_sigma_deg: FloatArray
    nine: FloatArray


def reported(freedom: Freedom, state: FitState, P: FloatArray, count: int) -> Reported:
    """Places and uncertainty of a state whose error state has the covariance `P` (n, n).

    The first `count` landmarks of the freedom's set are those that were asked for.
    """
    places, J = freedom.places(state), freedom.place_jacobian(state)
    covariance = J @ P @ np.swapaxes(J, 1, 2)
    names = freedom.landmark_set.names
    nine = places[[names.index(name) for name in LANDMARKS]]
    limbs = _limb_sigmas(names, places, J, P)
    return Reported(places[:count], covariance[:count], limbs, nine)


def _limb_sigmas(
    names: Sequence[str], places: FloatArray, J: FloatArray, P: FloatArray
) -> FloatArray:
    """Root mean square angles (6,) in degrees of the lines between landmarks."""
    sigmas = np.empty(len(LIMBS))
    for i, limb in enumerate(LIMBS):
        weights = np.zeros(len(names))
        for sign, ends in zip((-1.0, 1.0), LIMB_ENDS[limb], strict=True):
            weights[[names.index(name) for name in ends]] = sign / len(ends)
        along = weights @ places
        length = max(float(np.linalg.norm(along)), 1e-6)
        slope = np.tensordot(weights, J, axes=1)
        covariance = slope @ P @ slope.T
        unit = along / length
        across = float(np.trace(covariance) - unit @ covariance @ unit)
        sigmas[i] = np.degrees(np.sqrt(max(across, 0.0)) / length)
    return sigmas


def exact_residuals(
    measurements: Sequence[Click],
    names: Sequence[str],
    places: FloatArray,
    cameras: Mapping[str, Camera],
) -> FloatArray:
    """Click minus place (M, 2) in raw pixels, through the real lens; NaN behind a camera."""
    found = [
        np.array(one.position) - cameras[one.camera].project(places[names.index(one.landmark)])
        for one in measurements
    ]
    return np.array(found, dtype=np.float64).reshape(-1, 2)


def used_cameras(
    measurements: Sequence[Click], names: Sequence[str], mistake: FloatArray
) -> IntArray:
    """Cameras (L,) with a click of each landmark that is probably right."""
    count = np.zeros(len(names), dtype=np.int64)
    for one, p in zip(measurements, mistake, strict=True):
        count[names.index(one.landmark)] += bool(p <= MISTAKEN)
    return count


def words(
    names: Sequence[str],
    report: Reported,
    measurements: Sequence[Click],
    judgement: Judgement,
    residual: FloatArray,
    cameras: Mapping[str, Camera],
    views: Mapping[str, str],
) -> tuple[str, ...]:
    """What a person should know: mistakes first, then what is least certain."""
    said = []
    order = np.argsort(-judgement.mistake, kind="stable")
    for i in order[judgement.mistake[order] > MISTAKEN]:
        one, off = measurements[i], float(np.linalg.norm(residual[i]))
        said.append(mistake_words(one.landmark, views.get(one.camera, one.camera), off))
    used = used_cameras(measurements, names, judgement.mistake)
    values, vectors = np.linalg.eigh(report.covariance)
    sigma = np.sqrt(np.maximum(values[:, -1], 0.0))
    for i in np.argsort(-sigma, kind="stable"):
        if sigma[i] > _UNSURE:
            along = _along(vectors[i, :, -1], report.places[i], cameras, views)
            seen = _seen_by(used[i])
            said.append(f"{_label(names[i])}: {1000.0 * sigma[i]:.0f} mm{along}, {seen}")
    for limb, degrees in zip(LIMBS, report.limb_sigma_deg, strict=True):
        if degrees > _UNSURE_LIMB:
            said.append(f"{_label(limb)}: uncertainty {degrees:.0f} degrees")
    return tuple(said)


def mistake_words(landmark: str, view: str, off_px: float) -> str:
    """What is said of a click that is probably a gross mistake."""
    return f"{_label(landmark)} in {view}: {off_px:.0f} px from the fit, probable outlier"


def _label(name: str) -> str:
    return name.replace("_", " ")


def _seen_by(count: int) -> str:
    numbers = {0: "not clicked in any camera", 1: "seen by one camera"}
    return numbers.get(int(count), f"seen by {count} cameras")


def _along(
    direction: FloatArray,
    place: FloatArray,
    cameras: Mapping[str, Camera],
    views: Mapping[str, str],
) -> str:
    """``along the view of N`` where the direction is nearly that of a camera's ray."""
    nearest, name = _ALONG, ""
    for camera in cameras.values():
        ray = place - camera.position_world
        cosine = abs(float(ray @ direction)) / max(float(np.linalg.norm(ray)), 1e-9)
        if cosine > nearest:
            nearest, name = cosine, views.get(camera.name, camera.name)
    return f" along the view of {name}" if name else ""
