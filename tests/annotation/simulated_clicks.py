"""Simulated clicks, fitted and measured against the truth.

A click is simulated where the truth's landmark is inside the reference image of a view and not
hidden: the body of cones is put into the truth's pose, and a landmark is hidden where the line of
sight meets the body's surface more than :data:`COVERED` before it. The fit sees the clicks, the
images' depth and the subject's lengths, never the truth.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.fit.context import pose_at, standing
from stereotrack_core.annotation.fit.fit import ClickFit, Clouds
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.predict import in_image
from stereotrack_core.arrays import BoolArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.body.sampling import segment_blocked
from stereotrack_core.evaluation.summary import Summary, errors_against, summarise, truth_of
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS

COVERED = 0.15  # metres of flesh through which an annotator still sees where a joint is
OUTLIER_PX = (30.0, 100.0)  # least and largest distance of an outlier
# 95 % intervals in standard deviations: of a coordinate, and of a limb's angle, whose two
# components are between equal (1.73) and one alone (1.96).
INTERVAL, ANGLE_INTERVAL = 1.96, 1.85

_SCORED = tuple(limb for limb in LIMBS if limb != "head")


@dataclass(frozen=True)
class AnnotationCase:
    """How somebody annotates."""

    name: str
    sigma: float  # pixels per axis
    every: int  # every so many frames are clicked
    depth: bool
    missing: float = 0.0  # share of clicks that are left out
    outliers: float = 0.0  # share of clicks that are outliers


ALONE = AnnotationCase("clicks alone, every frame, 2 px", 2.0, 1, depth=False)
DIRTY = AnnotationCase("every frame, 2 px, 20 % missing, 3 % outliers", 2.0, 1, False, 0.2, 0.03)
DEPTH = AnnotationCase("clicks and depth, every 5th frame, 2 px", 2.0, 5, depth=True)


@dataclass(frozen=True, eq=False)
class SimulatedClicks:
    """Clicks by frame, and which of them are outliers."""

    by_frame: Mapping[int, tuple[Click, ...]]
    outliers: frozenset[ClickKey]


@dataclass(frozen=True)
class AnnotationScore:
    """How good a fitted reference is."""

    summary: Summary  # errors of all frames
    inside: float  # share of coordinates within their 95 % intervals
    limbs_inside: float  # share of limbs' angles within them
    found: float  # share of the outliers that are flagged; NaN without any
    accused: float  # share of the right clicks that are flagged; NaN without any


def seen_landmarks(recording: Recording, cameras: Sequence[Camera]) -> BoolArray:
    """Whether each camera sees each landmark of the truth (F, C, 9)."""
    truth = truth_of(recording)
    body = body_model(proportions_of(recording.subject))
    seen = np.zeros((len(truth.frame), len(cameras), len(LANDMARKS)), dtype=np.bool_)
    usual = standing(body, np.zeros(3))
    for k, points in enumerate(truth.points):
        placed = placed_cones(body, body.frames(pose_at(points, body, NINE, usual)))
        for c, camera in enumerate(cameras):
            place = camera.position_world
            sight = place - points
            sight = sight / np.linalg.norm(sight, axis=1, keepdims=True)
            covered = segment_blocked(points + COVERED * sight, place, placed)
            seen[k, c] = in_image(camera, camera.project(points)) & ~covered
    return seen


def simulated_clicks(recording: Recording, case: AnnotationCase, seed: int) -> SimulatedClicks:
    """Click the truth in the reference images of all views."""
    truth = truth_of(recording)
    cameras = [recording.reference_camera(view) for view in recording.views]
    seen = seen_landmarks(recording, cameras)
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, case.sigma, (*seen.shape, 2))
    there = seen & (rng.random(seen.shape) >= case.missing)
    wrong = rng.random(seen.shape) < case.outliers
    angle, away = rng.uniform(0.0, 2.0 * np.pi, seen.shape), rng.uniform(*OUTLIER_PX, seen.shape)
    noise[wrong] += (away[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1))[wrong]
    by_frame, outliers = {}, set()
    for k in range(0, len(truth.frame), case.every):
        frame, clicks = int(truth.frame[k]), []
        for c, camera in enumerate(cameras):
            pixels = camera.project(truth.points[k]) + noise[k, c]
            for i in np.flatnonzero(there[k, c]):
                x, y = pixels[i].tolist()
                click = Click(frame, camera.name, LANDMARKS[i], (x, y), sigma=case.sigma)
                clicks.append(click)
                if wrong[k, c, i]:
                    outliers.add(click.key)
        by_frame[frame] = tuple(clicks)
    return SimulatedClicks(by_frame, frozenset(outliers))


def annotated(
    recording: Recording, case: AnnotationCase, seed: int, clouds: Clouds | None
) -> AnnotationScore:
    """Simulate the clicks, fit them, with depth by frame in cases that use it, and measure.

    Raises InputError for a recording without reference.
    """
    truth, clicks = truth_of(recording), simulated_clicks(recording, case, seed)
    subject = proportions_of(recording.subject)
    fitting = ClickFit(recording.cameras, NINE, subject, FitSettings(), fps=recording.fps)
    frames = range(int(truth.frame[0]), int(truth.frame[-1]) + 1)
    fit = fitting.trajectory(clicks.by_frame, frames, clouds=clouds if case.depth else None)
    flagged = set(fit.flagged())
    right = fit.outlier_probability.keys() - clicks.outliers
    errors = errors_against(fit.trajectory(), truth)
    _, own, theirs = np.intersect1d(fit.frame, truth.frame, return_indices=True)
    away = np.abs(fit.landmarks[own] - truth.points[theirs])
    sigma = np.sqrt(np.diagonal(fit.covariance[own], axis1=2, axis2=3))
    known = np.isfinite(away) & np.isfinite(sigma)
    angles = errors.degrees[:, [LIMBS.index(limb) for limb in _SCORED]]
    good_to = fit.limb_sigma_deg[own][:, [LIMBS.index(limb) for limb in _SCORED]]
    limbs = np.isfinite(angles) & np.isfinite(good_to)
    return AnnotationScore(
        summary=summarise(errors),
        inside=float((away < INTERVAL * sigma)[known].mean()),
        limbs_inside=float((angles < ANGLE_INTERVAL * good_to)[limbs].mean()),
        found=len(clicks.outliers & flagged) / (len(clicks.outliers) or np.nan),
        accused=len(flagged & right) / (len(right) or np.nan),
    )
