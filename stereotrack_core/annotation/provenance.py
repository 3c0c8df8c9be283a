"""Provenance: where each landmark of each frame comes from, by whom, and how well it fits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import ACCEPTED, DETECTED, Click
from stereotrack_core.annotation.fit.results import CLICKED, INTERPOLATED, TrajectoryFit
from stereotrack_core.arrays import BoolArray, FloatArray, IntArray

FITTED = "fit"
_BEST_FIRST = (CLICKED, "merged", "imported", ACCEPTED, DETECTED)
"""Sources of clicks; a landmark has the first one that a click of it has."""
_ON_SAMPLE = 0.25  # frames off which a frame of another rate still shows the clicked instant


@dataclass(frozen=True, eq=False)
class Provenance:
    """Provenance of n landmarks over F frames; what is not known is empty or NaN.

    Their standard deviations follow from the covariance of the reference.
    """

    source: NDArray[np.str_]
    """(F, n); ``clicked``, ``accepted`` (a proposal), ``detector`` (a keypoint that was accepted),
    ``imported`` or ``merged`` clicks; without any ``fit`` in clicked frames, else
    ``interpolated``."""
    annotator: NDArray[np.str_]  # (F, n); several are joined by ``+``
    visibility: FloatArray  # (F, n); the best in any view: 2 seen, 1 guessed, 0 outside
    views: FloatArray  # (F, n); number of cameras with a position
    residual_px: FloatArray  # (F, n); root mean square distance of the clicks from the fit

    @staticmethod
    def unknown(frames: int, landmarks: int, source: str = "") -> Provenance:
        """Nothing known but the source."""
        shape = (frames, landmarks)
        values: tuple[Any, ...] = (source, "", np.nan, np.nan, np.nan)
        return Provenance(*(np.full(shape, value) for value in values))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays by their names."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def chosen(self, rows: BoolArray | IntArray) -> Provenance:
        """These frames alone."""
        return Provenance(*(array[rows] for array in self.arrays().values()))

    def joined(self, other: Provenance, axis: int = 0) -> Provenance:
        """The frames (or, along axis 1, landmarks) of another one behind these."""
        pairs = zip(self.arrays().values(), other.arrays().values(), strict=True)
        return Provenance(*(np.concatenate(pair, axis=axis) for pair in pairs))

    def of(self, known: Sequence[str], names: Sequence[str]) -> Provenance:
        """The landmarks with these names; `known` are the names of the columns."""
        wide = self.joined(Provenance.unknown(len(self.source), 1), axis=1)
        columns = [known.index(name) if name in known else -1 for name in names]
        return Provenance(*(array[:, columns] for array in wide.arrays().values()))

    def at(self, position: FloatArray, frame: IntArray) -> Provenance:
        """At frames of another rate, in which these lie at positions (F,); else interpolated."""
        between = Provenance.unknown(1, self.source.shape[1], INTERPOLATED)
        after = np.clip(np.searchsorted(position, frame), 0, len(position) - 1)
        before = np.maximum(after - 1, 0)
        nearer = abs(position[before] - frame) < abs(position[after] - frame)
        row = np.where(nearer, before, after)
        row[abs(position[row] - frame) > _ON_SAMPLE] = len(position)
        return self.joined(between).chosen(row)


def provenance_of(fit: TrajectoryFit, clicks: Iterable[Click]) -> Provenance:
    """Provenance of the landmarks of a fit, by the clicks that it was fitted to."""
    rows = {int(frame): row for row, frame in enumerate(fit.frame)}
    columns = {name: column for column, name in enumerate(fit.names)}
    own: dict[tuple[int, int], list[Click]] = {}
    for click in clicks:
        if not click.deleted and click.frame in rows and click.landmark in columns:
            own.setdefault((rows[click.frame], columns[click.landmark]), []).append(click)
    clicked = np.asarray(fit.kind == CLICKED)[:, None] & np.ones(len(columns), dtype=np.bool_)
    source = np.where(clicked, FITTED, INTERPOLATED).astype(object)
    texts = {"source": source, "annotator": np.full(clicked.shape, "", dtype=object)}
    numbers = {name: np.full(clicked.shape, np.nan) for name in ("visibility", "residual_px")}
    views = np.zeros(clicked.shape)
    for place, there in own.items():
        seen = [click for click in there if click.position is not None]
        numbers["visibility"][place] = max(click.visibility for click in there)
        views[place] = len(seen)
        texts["annotator"][place] = "+".join(sorted({one.who for one in there if one.who}))
        if seen:
            texts["source"][place] = min((one.source for one in seen), key=_BEST_FIRST.index)
        away = [fit.residual_px[one.key] for one in seen if one.key in fit.residual_px]
        if away:
            numbers["residual_px"][place] = np.sqrt(np.square(away).sum(axis=1).mean())
    unknown = ~np.isfinite(fit.landmarks).all(axis=2)
    texts["source"][unknown] = ""
    views[unknown & (views == 0)] = np.nan
    stated: dict[str, Any] = {name: array.astype(np.str_) for name, array in texts.items()}
    return Provenance(**stated, **numbers, views=views)
