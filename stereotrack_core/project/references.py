"""References in a project: saved by edits, read back bit by bit, made of fits."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.click_points import click_pixels
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.reference_npz import reference_bytes, reference_of_bytes
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.recording.landmarks import LANDMARKS

__all__ = ["Reference", "load_reference", "save_reference"]

_META_SHOWN = ("program", "version", "preset", "seed", "recording", "fingerprint", "views")


def save_reference(name: str, reference: Reference, *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a reference into the project."""
    facts = {"frames": len(reference.frame), **_shown(reference.meta)}
    return SaveEntry(
        REFERENCE.name, name, facts_as_json(facts), reference_bytes(reference), replacing
    )


def load_reference(references: Entries, name: str) -> Reference:
    """A reference of the project.

    Raises
    ------
    InputError
        Where there is none of that name.
    ProjectDamaged
        Where its data are not what was stored.
    """
    data = references.data(name)
    with references.making_sense():
        return reference_of_bytes(data, name)


def _shown(meta: Mapping[str, Any]) -> dict[str, Any]:
    return {key: meta[key] for key in _META_SHOWN if key in meta}


_MISTAKES = "mistakes"
_WORTH_KEEPING = 0.05
"""Clicks that are less probably mistakes are not listed."""


def reference_of_fit(fit: TrajectoryFit, meta: Mapping[str, Any]) -> Reference:
    """The fitted trajectory as a reference; landmarks of the nine that the set lacks come last.

    Parameters
    ----------
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


def without_gaps(
    fit: TrajectoryFit,
    gaps: Mapping[str, Collection[int]],
    clicked: Collection[tuple[int, str]] = (),
) -> TrajectoryFit:
    """The fit without what it has filled in of single landmarks over their gaps.

    Parameters
    ----------
    clicked : collection of (frame, landmark)
        These are known all the same.
    """
    if not gaps:
        return fit
    landmarks, covariance, nine = fit.landmarks.copy(), fit.covariance.copy(), fit.nine.copy()
    for name, frames in gaps.items():
        unknown = [frame for frame in frames if (frame, name) not in clicked]
        rows = np.isin(fit.frame, unknown)
        if name in fit.names:
            landmarks[rows, fit.names.index(name)] = np.nan
            covariance[rows, fit.names.index(name)] = np.nan
        if name in LANDMARKS:
            nine[rows, LANDMARKS.index(name)] = np.nan
    return replace(fit, landmarks=landmarks, covariance=covariance, nine=nine)


def merged_reference(old: Reference | None, new: Reference, frames: range) -> Reference:
    """The old reference with these frames taken from the new one.

    Without an old one of the same landmarks, the new one's frames alone.
    """
    inside = (new.frame >= frames.start) & (new.frame < frames.stop)
    taken = _chosen(new, inside)
    if old is None or not _fits(old, new):
        return taken
    kept = _chosen(old, (old.frame < frames.start) | (old.frame >= frames.stop))
    order = np.argsort(np.concatenate([kept.frame, taken.frame]), kind="stable")

    def both(name: str) -> FloatArray:
        joined: FloatArray = np.concatenate([getattr(kept, name), getattr(taken, name)])[order]
        return joined

    return Reference(
        frame=both("frame").astype(np.int64),
        points=both("points"),
        covariance=both("covariance"),
        limb_sigma_deg=both("limb_sigma_deg"),
        filled=both("filled").astype(np.bool_),
        landmark_names=new.landmark_names,
        meta={**old.meta, **new.meta, "mistakes": _mistakes(old, new, frames)},
    )


def _fits(old: Reference, new: Reference) -> bool:
    parts = (old.covariance, old.limb_sigma_deg, old.filled)
    return old.landmark_names == new.landmark_names and all(part is not None for part in parts)


def _chosen(reference: Reference, rows: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Reference:
    def part(array: FloatArray | None) -> FloatArray | None:
        return None if array is None else array[rows]

    return Reference(
        frame=reference.frame[rows],
        points=reference.points[rows],
        covariance=part(reference.covariance),
        limb_sigma_deg=part(reference.limb_sigma_deg),
        filled=None if reference.filled is None else reference.filled[rows],
        landmark_names=reference.landmark_names,
        meta=reference.meta,
    )


def _mistakes(old: Reference, new: Reference, frames: range) -> list[list[object]]:
    before = [one for one in old.meta.get("mistakes", ()) if one[0] not in frames]
    return before + [one for one in new.meta.get("mistakes", ()) if one[0] in frames]
