"""A trajectory taken as truth that states how good it is, and which of its frames are old."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any
from zlib import crc32

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey, Sigmas
from stereotrack_core.annotation.click_points import click_pixels
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.annotation.provenance import Provenance, provenance_of
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Cameras, Recording
from stereotrack_core.recording.frame_times import (
    at_rate,
    outside_notes,
    resampled_note,
    same_rate,
    stated_fps,
    values_at,
)
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.version import __version__

FITTED_TO = "fitted_to"  # name in a reference's `meta` of frames and checksums of their clicks


def checksums(clicks: Iterable[Click]) -> dict[int, int]:
    """Checksum of what is said of each frame that has clicks."""
    said: dict[int, list[tuple[object, ...]]] = {}
    for one in clicks:
        if not one.deleted:
            place = one.camera, one.landmark, one.position, int(one.visibility)
            said.setdefault(one.frame, []).append((*place, one.flag, one.sigma))
    return {frame: crc32(repr(sorted(own, key=repr)).encode()) for frame, own in said.items()}


@dataclass(frozen=True)
class FittedClicks:
    """The clicks that a reference was fitted to, and where they have changed since."""

    sums: Mapping[int, int]  # checksum of the clicks of each frame, as they were
    changed: frozenset[int]  # frames whose clicks are others now

    def after_edit(self, frames: Collection[int], clicks: Iterable[Click]) -> FittedClicks:
        """The same after an edit of these frames, whose clicks are given as they are now."""
        edited = _changed(self.sums, checksums(clicks), frames)
        return replace(self, changed=(self.changed - set(frames)) | edited)

    def is_old(self, frame: int) -> bool:
        """Whether clicks have changed that decide a frame: its own or, without any, around."""
        clicked = sorted(self.sums)
        before, after = bisect_right(clicked, frame) - 1, bisect_left(clicked, frame)
        first = clicked[before] if before >= 0 else 0
        last = clicked[after] if after < len(clicked) else None
        return any(first <= one and (last is None or one <= last) for one in self.changed)


def fitted_clicks(meta: Mapping[str, Any], clicks: Iterable[Click]) -> FittedClicks | None:
    """Compare the clicks that a reference's `meta` states with those of now; None without."""
    rows = meta.get(FITTED_TO)
    if not isinstance(rows, list) or not all(
        isinstance(row, list) and [type(value) for value in row] == [int, int] for row in rows
    ):
        return None
    sums, now = dict(rows), checksums(clicks)
    return FittedClicks(sums, _changed(sums, now, sums.keys() | now.keys()))


def _changed(
    before: Mapping[int, int], now: Mapping[int, int], frames: Iterable[int]
) -> frozenset[int]:
    return frozenset(frame for frame in frames if before.get(frame) != now.get(frame))


_OUTLIERS = "outliers"
_WORTH_KEEPING = 0.05  # clicks that are less probably outliers are not listed
_STATED = ("covariance", "limb_sigma_deg", "filled")  # what a reference that was fitted states
_LIMB_LENGTH = 0.3  # metres by which the end of a limb moves when it turns by one radian
MAX_SIGMA = 0.1
"""Largest standard deviation of a known landmark in its worst direction, metres.

Turns the end of a forearm by about 20 degrees, half of what counts as an unknown direction. In the
demo it keeps all landmarks if every fifth frame is clicked and depth is used (23 mm at most), and
nine tenths if every third is clicked without depth; five frames from the last click none is left.
"""


@dataclass(frozen=True, eq=False)
class Reference:
    """A trajectory taken as truth, and how good it is; F frames, n landmarks."""

    frame: IntArray  # (F,); ascending
    points: FloatArray  # (F, n, 3), world, metres; NaN where not known
    covariance: FloatArray | None = None  # (F, n, 3, 3), square metres; of each landmark's position
    limb_sigma_deg: FloatArray | None = None  # (F, 6); rms angle by which each limb may be off
    filled: BoolArray | None = None  # (F,); frames that were filled in between annotated ones
    landmark_names: tuple[str, ...] = LANDMARKS
    meta: Mapping[str, Any] = field(default_factory=dict)  # how it was made; JSON-serialisable
    notes: tuple[Finding, ...] = ()  # decisions made while reading; not stored
    provenance: Provenance | None = None  # of all landmarks in all frames

    def __post_init__(self) -> None:
        frames, landmarks = len(self.frame), len(self.landmark_names)
        shapes: dict[str, tuple[Any, tuple[int, ...]]] = {
            "points": (self.points, (frames, landmarks, 3)),
            "covariance": (self.covariance, (frames, landmarks, 3, 3)),
            "limb_sigma_deg": (self.limb_sigma_deg, (frames, 6)),
            "filled": (self.filled, (frames,)),
        }
        if self.provenance is not None:
            arrays = self.provenance.arrays()
            shapes |= {name: (array, (frames, landmarks)) for name, array in arrays.items()}
        for name, (array, shape) in shapes.items():
            if array is not None and array.shape != shape:
                raise ValueError(f"{name} has the shape {array.shape}, expected {shape}")
        if (self.frame[1:] <= self.frame[:-1]).any():
            raise ValueError("the frames are not in ascending order")

    @property
    def fps(self) -> float | None:
        """Frames per second that it states; without it, frames are the recording's."""
        return stated_fps(self.meta)

    def chosen(self, rows: BoolArray) -> Reference:
        """The frames of these rows (F,) alone."""
        parts = {name: getattr(self, name) for name in ("frame", "points", *_STATED)}
        there: dict[str, Any] = {n: part[rows] for n, part in parts.items() if part is not None}
        if self.provenance is not None:
            there["provenance"] = self.provenance.chosen(rows)
        return replace(self, **there)

    def sigma(self) -> FloatArray:
        """Standard deviations (F, n) in the worst directions, metres, or by the limb, or NaN."""
        result: FloatArray = np.full(self.points.shape[:2], np.nan)
        if self.covariance is None:
            return result
        known: BoolArray = np.asarray(np.isfinite(self.covariance).all(axis=(2, 3)))
        variances = np.linalg.eigvalsh(self.covariance[known])[:, -1]
        result[known] = np.sqrt(np.maximum(variances, 0.0))
        if self.limb_sigma_deg is not None:
            for i, name in enumerate(self.landmark_names):
                if name in LANDMARKS and not known[:, i].any():
                    turn = np.radians(self.limb_sigma_deg[:, LIMBS.index(NINE[name].limb)])
                    result[:, i] = _LIMB_LENGTH * turn
        return result

    def within(self, max_sigma: float) -> Reference:
        """The same without the places of landmarks that are less certain than that, metres."""
        uncertain = self.sigma() > max_sigma
        return replace(self, points=np.where(uncertain[..., None], np.nan, self.points))

    def without(self, sources: Collection[str]) -> Reference:
        """The same without landmarks of these sources; nothing is left out if none is stated."""
        if self.provenance is None:
            return self
        out = np.isin(self.provenance.source, list(sources))
        return replace(self, points=np.where(out[..., None], np.nan, self.points))

    def trajectory(self, max_sigma: float = MAX_SIGMA) -> LandmarkTrajectory:
        """The nine landmarks alone; NaN where one is missing or less certain than that, metres."""
        points = self.of_the_nine(self.within(max_sigma).points)
        return LandmarkTrajectory(self.frame, points, self.fps, self.notes)

    def of_the_nine(self, values: FloatArray) -> FloatArray:
        """Values (F, 9, ...) of those of all landmarks (F, n, ...); NaN if one is missing."""
        result: FloatArray = np.full((len(values), len(LANDMARKS), *values.shape[2:]), np.nan)
        for i, name in enumerate(LANDMARKS):
            if name in self.landmark_names:
                result[:, i] = values[:, self.landmark_names.index(name)]
        return result

    def left_out(self, max_sigma: float) -> str:
        """Sentences on what a limit of sigma in metres leaves out; empty if nothing is."""
        places = np.isfinite(self.points).all(axis=2)
        kept = places & ~(self.sigma() > max_sigma)
        count, unknown = int((~kept).sum()), int((~places).sum())
        if not count:
            return ""
        limit = f"with a standard deviation above {1000.0 * max_sigma:g} mm"
        reasons = [f"{count - unknown} {limit}"] * (count > unknown)
        reasons += [f"{unknown} unknown"] * bool(unknown)
        return (
            f"Left out: {count} of {kept.size} landmark positions ({', '.join(reasons)}). "
            f"{int(kept.all(axis=1).sum())} of {len(kept)} frames are complete. Click more frames."
        )

    def at_rate(self, fps: float, where: str) -> Reference:
        """The reference at the frames of another rate; see :meth:`LandmarkTrajectory.at_rate`."""
        own = self.fps
        if own is None or same_rate(own, fps, self.frame):
            return self
        frame, points = at_rate(self.frame, self.points, own, fps, where)

        def there(values: FloatArray, count: int) -> FloatArray:
            flat = values.reshape(len(self.frame), count, values[:1].size // count)
            at = values_at(self.frame, flat, own, fps, frame)
            return at.reshape(len(frame), *values.shape[1:])

        covariance, sigma, filled = self.covariance, self.limb_sigma_deg, self.filled
        position = np.asarray(self.frame * (fps / own))
        meta = {key: self.meta[key] for key in self.meta if key not in (_OUTLIERS, FITTED_TO)}
        return replace(
            self,
            frame=frame,
            points=points,
            covariance=None if covariance is None else there(covariance, covariance.shape[1]),
            limb_sigma_deg=None if sigma is None else there(sigma, sigma.shape[1]),
            filled=None if filled is None else there(filled.astype(float)[:, None], 1)[:, 0] != 0.0,
            provenance=self.provenance and self.provenance.at(position, frame),
            meta={**meta, "fps": fps, "resampled_from_fps": own},
            notes=(*self.notes, resampled_note(own, fps, where)),
        )

    def in_recording(self, count: int, where: str) -> Reference:
        """The frames that a recording of so many has, with a note; unchanged without any."""
        inside = np.asarray((self.frame >= 0) & (self.frame < count))
        if inside.all() or not inside.any():
            return self
        notes = (*self.notes, *outside_notes(self.frame, count, where))
        return replace(self.chosen(inside), notes=notes)


def reference_of_fit(
    fit: TrajectoryFit, meta: Mapping[str, Any], clicks: Iterable[Click]
) -> Reference:
    """The fitted trajectory as a reference; landmarks of the nine that it lacks come last."""
    others = [name for name in LANDMARKS if name not in fit.names]
    extra = fit.nine[:, [LANDMARKS.index(name) for name in others]]
    unknown = np.full((*extra.shape[:2], 3, 3), np.nan)
    outliers = [
        [*key, p] for key, p in sorted(fit.outlier_probability.items()) if p > _WORTH_KEEPING
    ]
    return Reference(
        frame=fit.frame,
        points=np.concatenate([fit.landmarks, extra], axis=1),
        covariance=np.concatenate([fit.covariance, unknown], axis=1),
        limb_sigma_deg=fit.limb_sigma_deg,
        filled=np.asarray(fit.kind == INTERPOLATED),
        landmark_names=(*fit.names, *others),
        meta={**meta, _OUTLIERS: outliers, "sigma_factor": float(fit.sigma_factor)},
        provenance=provenance_of(fit, clicks).of(fit.names, (*fit.names, *others)),
    )


def origin_of(
    recording: Recording, clicks: int, sigma: Sigmas, settings: FitSettings
) -> dict[str, Any]:
    """How a reference was made of clicks, as its `meta` says it."""
    return {
        "program": "stereotrack",
        "version": __version__,
        "recording": recording.name,
        "fps": recording.fps,
        "clicks": clicks,
        "click_sigma_px": sigma,
        "settings": asdict(settings),
    }


def fit_of_reference(
    reference: Reference, landmarks: LandmarkSet, clicks: Iterable[Click], cameras: Cameras
) -> TrajectoryFit | None:
    """The fit of a reference, with residuals of the present clicks; None if it was not fitted."""
    covariance, limb_sigma_deg = reference.covariance, reference.limb_sigma_deg
    if covariance is None or limb_sigma_deg is None or reference.filled is None:
        return None
    if not set(landmarks.names) <= set(reference.landmark_names):
        return None
    columns = [reference.landmark_names.index(name) for name in landmarks.names]
    points = reference.points[:, columns]
    empty = ~np.isfinite(points).any(axis=(1, 2))
    return TrajectoryFit(
        names=landmarks.names,
        frame=reference.frame,
        landmarks=points,
        covariance=covariance[:, columns],
        limb_sigma_deg=limb_sigma_deg,
        kind=np.where(empty, GAP, np.where(reference.filled, INTERPOLATED, CLICKED)),
        nine=reference.of_the_nine(reference.points),
        residual_px=_residuals(reference, points, landmarks, clicks, cameras),
        outlier_probability={
            ClickKey(int(frame), str(camera), str(landmark)): float(p)
            for frame, camera, landmark, p in reference.meta.get(_OUTLIERS, ())
        },
        sigma_factor=float(reference.meta.get("sigma_factor", 1.0)),
    )


def _residuals(
    reference: Reference,
    points: FloatArray,
    landmarks: LandmarkSet,
    clicks: Iterable[Click],
    cameras: Cameras,
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
    fit: TrajectoryFit, gaps: Mapping[str, Collection[int]], clicked: Collection[tuple[int, str]]
) -> TrajectoryFit:
    """The fit without landmarks filled in over their gaps, unless they are `clicked` there."""
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
    """The old reference with these frames of the new one; without an old one, those alone."""
    taken = new.chosen((new.frame >= frames.start) & (new.frame < frames.stop))
    if old is None or old.landmark_names != new.landmark_names:
        return taken
    if any(getattr(old, name) is None for name in _STATED):  # it was not fitted
        return taken
    kept = old.chosen((old.frame < frames.start) | (old.frame >= frames.stop))
    order = np.argsort(np.concatenate([kept.frame, taken.frame]), kind="stable")
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(kept, name), getattr(taken, name)])[order]
        for name in ("frame", "points", *_STATED)
    }
    if taken.provenance is not None:
        before = kept.provenance or Provenance.unknown(*kept.points.shape[:2])
        arrays["provenance"] = before.joined(taken.provenance).chosen(order)
    meta = {**old.meta, **new.meta}
    for name in (_OUTLIERS, FITTED_TO):  # their rows begin with a frame
        others = [row for row in old.meta.get(name, ()) if row[0] not in frames]
        meta[name] = others + [row for row in new.meta.get(name, ()) if row[0] in frames]
    if FITTED_TO not in old.meta:
        del meta[FITTED_TO]  # nobody knows which clicks the old frames were fitted to
    return replace(new, **arrays, meta=meta)
