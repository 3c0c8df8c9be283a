"""Results of a fit: places, their uncertainty, the limbs' angles, and words for a person."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.fit.context import FitContext
from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.annotation.fit.stretch import Fitted
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.counting import spread_words
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

CLICKED, INTERPOLATED, GAP = "clicked", "interpolated", "gap"
"""Kinds of frames: with clicks of their own, filled between them, nothing known."""

PROBABLE = 0.5  # a click is flagged where it is more probably an outlier than not


@dataclass(frozen=True, eq=False)
class FrameFit:
    """The body fitted to the clicks of one frame."""

    pose: Pose
    landmarks_world: FloatArray  # (L, 3), metres; in the order of the set of landmarks
    landmark_covariance: FloatArray  # (L, 3, 3), square metres, world
    residual_px: FloatArray  # (M, 2); click minus fitted place, raw pixels
    outlier_probability: FloatArray  # (M,)
    limb_sigma_deg: FloatArray  # (6,); root mean square angle by which each limb may be off
    words: tuple[str, ...]  # what a person should know, most important first
    sigma_factor: float  # by which the clicks scatter more than their sigma; 1 else


@dataclass(frozen=True, eq=False)
class TrajectoryFit:
    """The body fitted to clicks over frames, forward and backward."""

    names: tuple[str, ...]  # landmarks, in the order of the arrays
    frame: IntArray  # (F,)
    landmarks: FloatArray  # (F, L, 3), world, metres; NaN where nothing is known
    covariance: FloatArray  # (F, L, 3, 3), square metres, world
    limb_sigma_deg: FloatArray  # (F, 6); in the order of ``LIMBS``
    kind: NDArray[np.str_]  # (F,); ``clicked``, ``interpolated`` or ``gap``
    nine: FloatArray  # (F, 9, 3), world, metres; whatever set was clicked
    residual_px: Mapping[ClickKey, FloatArray]  # (2,); click minus fitted place, raw pixels
    outlier_probability: Mapping[ClickKey, float]  # that a click is an outlier
    sigma_factor: float = 1.0  # by what the clicks scatter more than their sigmas say

    def trajectory(self) -> LandmarkTrajectory:
        """The nine landmarks, as a reference holds them."""
        return LandmarkTrajectory(self.frame, self.nine)

    def flagged(self) -> tuple[ClickKey, ...]:
        """Clicks that are more probably outliers than not, in their order."""
        return tuple(sorted(key for key, p in self.outlier_probability.items() if p > PROBABLE))


_SEEN_BY = {0: "not clicked in any camera", 1: "seen by one camera"}
_UNSURE = 0.02  # metres of sigma in the worst direction from which a landmark is spoken of
_UNSURE_LIMB = 10.0  # degrees from which a limb is spoken of
_ALONG = np.cos(np.radians(35.0))  # a direction nearer to a ray is along its view


@dataclass(frozen=True, eq=False)
class Reported:
    """Landmarks (L, 3) of one frame in the world with their covariances, limbs (6,), the nine."""

    places: FloatArray
    covariance: FloatArray
    limb_sigma_deg: FloatArray
    nine: FloatArray


def reported(freedom: Freedom, state: FitState, P: FloatArray, count: int) -> Reported:
    """Places and uncertainty of a state with the covariance `P` (n, n); of `count` landmarks."""
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
    measurements: Sequence[Click], names: Sequence[str], places: FloatArray, cameras: Cameras
) -> FloatArray:
    """Click minus place (M, 2) in raw pixels, through the real lens; NaN behind a camera."""
    found = np.empty((len(measurements), 2))
    for i, one in enumerate(measurements):
        found[i] = one.position
        found[i] -= cameras[one.camera].project(places[names.index(one.landmark)])
    return found


def frame_fit(
    freedom: Freedom, found: Fitted, context: FitContext, clicks: Sequence[Click], factor: float
) -> FrameFit:
    """Result of a fit of one frame whose clicks scatter by a factor more than they state."""
    judgement, names = found.judgements[0], context.asked.names
    report = reported(freedom, found.states[0], found.P[0], len(names))
    residual = exact_residuals(clicks, names, report.places, context.cameras)
    said = _words(report, clicks, judgement.outlier_probability, residual, context)
    if factor > 1.0:
        said = [f"the clicks scatter {factor:.1f} times as much as their stated uncertainty", *said]
    where = found.states[0].pose, report.places, report.covariance, residual
    return FrameFit(
        *where, judgement.outlier_probability, report.limb_sigma_deg, tuple(said), factor
    )


def _words(
    report: Reported,
    measurements: Sequence[Click],
    outlier: FloatArray,
    residual: FloatArray,
    context: FitContext,
) -> list[str]:
    """Remarks for a person: outliers first, then the least certain landmarks and limbs."""
    said, names, views = [], context.asked.names, context.views
    order = np.argsort(-outlier, kind="stable")
    for i in order[outlier[order] > PROBABLE]:
        one, off = measurements[i], float(np.linalg.norm(residual[i]))
        said.append(outlier_words(one.landmark, views.get(one.camera, one.camera), off))
    right = Counter(c.landmark for c, p in zip(measurements, outlier, strict=True) if p <= PROBABLE)
    values, vectors = np.linalg.eigh(report.covariance)
    sigma = np.sqrt(np.maximum(values[:, -1], 0.0))
    for i in np.argsort(-sigma, kind="stable"):
        if sigma[i] > _UNSURE:
            along = _along(vectors[i, :, -1], report.places[i], context.cameras, views)
            count = right[names[i]]
            seen = _SEEN_BY.get(count, f"seen by {count} cameras")
            said.append(f"{_label(names[i])}: {1000.0 * sigma[i]:.0f} mm{along}, {seen}")
    for limb, degrees in zip(LIMBS, report.limb_sigma_deg, strict=True):
        if degrees > _UNSURE_LIMB:
            said.append(f"{_label(limb)}: uncertainty {spread_words(degrees, ' degrees', 0)}")
    return said


def outlier_words(landmark: str, view: str, off_px: float) -> str:
    """Remark on a click that is probably an outlier."""
    return f"{_label(landmark)} in {view}: {off_px:.0f} px from the fit, probable outlier"


def _label(name: str) -> str:
    return name.replace("_", " ")


def _along(
    direction: FloatArray, place: FloatArray, cameras: Cameras, views: Mapping[str, str]
) -> str:
    """``along the view of N`` where the direction is nearly that of a camera's ray."""
    nearest, name = _ALONG, ""
    for camera in cameras.values():
        ray = place - camera.position_world
        cosine = abs(float(ray @ direction)) / max(float(np.linalg.norm(ray)), 1e-9)
        if cosine > nearest:
            nearest, name = cosine, views.get(camera.name, camera.name)
    return f" along the view of {name}" if name else ""
