"""Do the lenses of a pair bend what they show, though its calibration states no distortions?

A radial term moves details along the rays from the middle of an image. What stands at different
places in both images is then in different rows: little in the middle of the images, more towards
their edges. A term for each lens is fitted to that, and has to be significant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.doctor.details import FEWEST, Details, Pair
from stereotrack_core.doctor.row_changes import (
    LEFT_FOCAL,
    LENSES,
    NUMBERS,
    RIGHT_FOCAL,
    TURN,
    RowChanges,
)

_LEAST_NOISE_PX = 0.05
_MOST = 9.0
"""Squared standard deviations as which larger offsets count."""

_LEAST_TERM, _MOST_TERM = 0.03, 0.6
"""Sizes of radial terms that are told."""

_EVIDENCE = 30.0
"""Fall of the squared offsets in those that the terms leave per detail, of sound pairs below 26."""


@dataclass(frozen=True)
class Lenses:
    """Radial terms k_1 that a calibration lacks, by camera.

    `row_px` is the median row offset with them, `edge_px` what 5 % of the details exceed without.
    """

    terms: Mapping[str, float]
    row_px: float
    edge_px: float

    @property
    def words(self) -> str:
        """What the lenses lack."""
        terms = ", ".join(f"{name}: {term:.2f}" for name, term in self.terms.items())
        return (
            "The calibration states no distortions of these lenses, but they have some, of about "
            f"k_1 = {terms}"
        )


def distortions_left_out(cameras: Pair, details: Details) -> Lenses | None:
    """Radial terms of the lenses that state none; None where they explain little or nothing.

    A pair whose row offsets come from a camera that is turned, or from another focal length, is
    left to those who ask for that: it has to be explained clearly worse by either.
    """
    bare = {n: one.name for n, one in zip(LENSES, cameras, strict=True) if not any(one.distortions)}
    if not bare or len(details.left) < FEWEST:
        return None
    rays = RowChanges(cameras, details)
    given, bent = rays.rows(np.zeros(NUMBERS)), rays.fitted(tuple(bare))
    known = np.isfinite(given) & np.isfinite(rays.rows(bent))
    left = rays.rows(bent)[known]
    noise = max(1.4826 * float(np.median(np.abs(left))), _LEAST_NOISE_PX)

    def cost(rows: FloatArray) -> float:
        return float(np.sum(np.minimum((rows[known] / noise) ** 2, _MOST)))

    costs = cost(given), cost(rays.rows(bent))
    evidence = (costs[0] - costs[1]) / (costs[1] / len(left))
    terms = {name: -float(bent[n]) for n, name in bare.items()}
    size = abs(float(np.mean(list(terms.values()))))
    if evidence < _EVIDENCE or not _LEAST_TERM < size < _MOST_TERM:
        return None
    others = min(cost(rays.rows(rays.fitted(free))) for free in (TURN, LEFT_FOCAL, RIGHT_FOCAL))
    if others < costs[1]:
        return None
    edge = float(np.percentile(np.abs(given[known]), 95))
    return Lenses(terms, float(np.median(np.abs(left))), edge)
