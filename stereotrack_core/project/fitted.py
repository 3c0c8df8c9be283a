"""A trajectory fitted to clicks as the project's reference, and back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.click_points import click_pixels
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.project.references import Reference
from stereotrack_core.recording.landmarks import LANDMARKS

_MISTAKES = "mistakes"
_WORTH_KEEPING = 0.05
"""Clicks that are less probably mistakes are not listed."""


def reference_of_fit(fit: TrajectoryFit, meta: Mapping[str, Any]) -> Reference:
    """The fitted trajectory as a reference; landmarks of the nine that the set lacks come last.

    Parameters
    ----------
    fit : TrajectoryFit
    meta : mapping
        How it was made; JSON-serialisable.
    """
    others = [name for name in LANDMARKS if name not in fit.names]
    extra = fit.nine[:, [LANDMARKS.index(name) for name in others]]
    unknown = np.full((*extra.shape[:2], 3, 3), np.nan)
    mistakes = [[*key, p] for key, p in sorted(fit.mistake.items()) if p > _WORTH_KEEPING]
    return Reference(
        frame=fit.frame,
        points=np.concatenate([fit.landmarks, extra], axis=1),
        covariance=np.concatenate([fit.covariance, unknown], axis=1),
        limb_sigma_deg=fit.limb_sigma_deg,
        filled=np.asarray(fit.kind == INTERPOLATED),
        landmark_names=(*fit.names, *others),
        meta={**meta, _MISTAKES: mistakes, "sigma_factor": float(fit.sigma_factor)},
    )


def fit_of_reference(
    reference: Reference,
    landmarks: LandmarkSet,
    clicks: Iterable[Click],
    cameras: Mapping[str, Camera],
) -> TrajectoryFit | None:
    """The fit that a reference was made of; residuals are those of the present clicks.

    None where the reference was not fitted, or to other landmarks.
    """
    known = (reference.covariance, reference.limb_sigma_deg, reference.filled)
    if any(array is None for array in known) or not set(landmarks.names) <= set(
        reference.landmark_names
    ):
        return None
    covariance, limb_sigma_deg, filled = known
    assert covariance is not None  # noqa: S101 - asked above
    assert limb_sigma_deg is not None  # noqa: S101 - asked above
    assert filled is not None  # noqa: S101 - asked above
    columns = [reference.landmark_names.index(name) for name in landmarks.names]
    points = reference.points[:, columns]
    empty = ~np.isfinite(points).any(axis=(1, 2))
    kind = np.where(empty, GAP, np.where(filled, INTERPOLATED, CLICKED))
    return TrajectoryFit(
        names=landmarks.names,
        frame=reference.frame,
        landmarks=points,
        covariance=covariance[:, columns],
        limb_sigma_deg=limb_sigma_deg,
        kind=kind,
        nine=reference.trajectory().points,
        residual_px=_residuals(reference, points, landmarks, clicks, cameras),
        mistake={
            ClickKey(int(frame), str(camera), str(landmark)): float(p)
            for frame, camera, landmark, p in reference.meta.get(_MISTAKES, ())
        },
        sigma_factor=float(reference.meta.get("sigma_factor", 1.0)),
    )


def _residuals(
    reference: Reference,
    points: FloatArray,
    landmarks: LandmarkSet,
    clicks: Iterable[Click],
    cameras: Mapping[str, Camera],
) -> dict[ClickKey, FloatArray]:
    found = click_pixels(clicks, cameras, landmarks.names)
    _, own, theirs = np.intersect1d(found.frame, reference.frame, return_indices=True)
    residuals = {}
    for v, camera in enumerate(found.cameras):
        away = found.pixel[own, :, v] - camera.project(points[theirs])
        for row, column in np.argwhere(np.isfinite(away).all(axis=-1)):
            key = ClickKey(int(found.frame[own[row]]), camera.name, landmarks.names[column])
            residuals[key] = away[row, column]
    return residuals
