"""Hints from the clicks of one frame: points, curves, mixed-up sides, the fitted body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey, measurements
from stereotrack_core.annotation.click_points import ENDS_OF_LENGTHS
from stereotrack_core.annotation.doubts import Swap, find_swaps
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.fit.results import FrameFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.predict import PredictedPoint, epipolar_curve, predicted_points
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.counting import UNKNOWN_DEG
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.points import Volume
from stereotrack_core.recording.description import Cameras
from stereotrack_core.worker_processes import Asker

_AROUND = 16  # corners around a part that is drawn


@dataclass(frozen=True, eq=False)
class FrameClicks:
    """The clicks of one frame, and what is known besides."""

    frame: int
    clicks: tuple[Click, ...]  # of all cameras and landmarks
    cameras: Cameras
    landmark_set: LandmarkSet
    proportions: Proportions
    sigmas: Mapping[str, float]  # of clicks by landmark, pixels per axis, as far as measured


@dataclass(frozen=True, eq=False)
class HintQuestion(FrameClicks):
    """Clicks that are compared with each other."""

    landmark: str  # the one whose curves are wanted
    shown: tuple[str, ...]  # cameras whose images are shown
    volume: Volume  # where landmarks can be


@dataclass(frozen=True, eq=False)
class FitQuestion(FrameClicks):
    """The body that is fitted to the clicks, and to measured points if there are any."""

    views: Mapping[str, str]
    fps: float
    cloud: Cloud | None


@dataclass(frozen=True, eq=False)
class Curve:
    """Where a landmark that was clicked in one camera can be in another; (K, 2) raw pixels."""

    landmark: str
    from_camera: str
    pixels: FloatArray


@dataclass(frozen=True, eq=False)
class ClickHints:
    """The answer; points of landmarks with clicks in two places or more."""

    question: HintQuestion
    points: Mapping[str, PredictedPoint]
    curves: Mapping[str, tuple[Curve, ...]]
    swaps: tuple[Swap, ...]
    lengths: tuple[BoneLength, ...]


def hints_of(question: HintQuestion) -> ClickHints:
    """Everything that the clicks of one frame say about each other."""
    clicks = [one for one in question.clicks if one.camera in question.cameras]
    wanted = {*question.shown, *(click.camera for click in clicks)}
    cameras = {name: camera for name, camera in question.cameras.items() if name in wanted}
    points = predicted_points(cameras, clicks, sigma=question.sigmas)
    return ClickHints(
        question,
        points,
        _curves(question, [one for one in clicks if one.landmark == question.landmark]),
        find_swaps(clicks, question.cameras, question.landmark_set.pairs()),
        bone_lengths(points, question.proportions),
    )


def _curves(question: HintQuestion, clicks: list[Click]) -> dict[str, tuple[Curve, ...]]:
    cameras = question.cameras

    def curve(click: Click, name: str) -> Curve:
        pixel = np.array(click.position)
        pixels = epipolar_curve(cameras[click.camera], pixel, cameras[name], question.volume)
        return Curve(click.landmark, click.camera, pixels)

    placed = [click for click in clicks if click.position is not None]
    shown = [name for name in question.shown if name in cameras]
    return {name: tuple(curve(c, name) for c in placed if c.camera != name) for name in shown}


_DOUBTFUL = 3.0
_LEAST_SIGMA = 0.008  # metres that joints wander on a real body


@dataclass(frozen=True)
class BoneLength:
    """A length as clicked, and as the subject has it; metres."""

    name: str
    clicked: float
    sigma: float  # standard deviation of it, from the clicks
    subject: float

    @property
    def doubtful(self) -> bool:
        """Whether the difference is more than the clicks' uncertainty can explain."""
        sigma = float(np.hypot(self.sigma, _LEAST_SIGMA))
        return abs(self.clicked - self.subject) > _DOUBTFUL * sigma


def bone_lengths(
    points: Mapping[str, PredictedPoint], proportions: Proportions
) -> tuple[BoneLength, ...]:
    """Lengths whose ends have all been clicked in two views or more."""
    found = []
    for name, key, (start, end) in ENDS_OF_LENGTHS:
        if all(landmark in points for landmark in (*start, *end)):
            first, first_covariance = _middle(points, start)
            second, second_covariance = _middle(points, end)
            between = second - first
            length = float(np.linalg.norm(between))
            unit = between / max(length, 1e-9)
            variance = float(unit @ (first_covariance + second_covariance) @ unit)
            sigma, own = float(np.sqrt(variance)), getattr(proportions, key)
            found.append(BoneLength(name, length, sigma, own))
    return tuple(found)


def _middle(
    points: Mapping[str, PredictedPoint], names: Sequence[str]
) -> tuple[FloatArray, FloatArray]:
    """Mean (3,) of points and its covariance (3, 3)."""
    places = np.mean([points[name].world for name in names], axis=0)
    covariance = np.sum([points[name].covariance for name in names], axis=0) / len(names) ** 2
    return places, covariance


@dataclass(frozen=True, eq=False)
class ShownFit:
    """A fit and what is drawn of it."""

    question: FitQuestion
    fit: FrameFit
    meshes: tuple[PartMesh, ...]  # of the limbs whose direction is known
    residuals: Mapping[ClickKey, FloatArray]  # (2,); click minus model, raw pixels
    outliers: Mapping[ClickKey, float]  # probability that the click is an outlier
    places: Mapping[str, FloatArray]  # landmarks of the model (3,), world, metres


def fitted_body(question: FitQuestion, _asker: Asker | None = None) -> ShownFit:
    """Fit the body to the clicks of one frame, also as a task of a process."""
    q, settings = question, FitSettings(use_depth=question.cloud is not None)
    here = [one for one in q.clicks if one.camera in q.cameras]
    taken = measurements(here, q.landmark_set.names, q.sigmas)
    fitting = ClickFit(q.cameras, q.landmark_set, q.proportions, settings, q.fps, q.views)
    fit, keys = fitting.frame(taken, cloud=q.cloud), [one.key for one in taken]
    meshes = body_mesh(body_model(q.proportions), fit.pose, around=_AROUND)
    known = np.array(LIMBS)[fit.limb_sigma_deg <= UNKNOWN_DEG]
    return ShownFit(
        replace(q, cloud=None),  # the points are large, and are known where it goes
        fit,
        tuple(mesh for mesh in meshes if mesh.limb in known),
        dict(zip(keys, fit.residual_px, strict=True)),
        dict(zip(keys, fit.outlier_probability.tolist(), strict=True)),
        dict(zip(q.landmark_set.names, fit.landmarks_world, strict=True)),
    )
