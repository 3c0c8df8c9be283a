"""Landmarks in space from the clicks of several cameras, whatever is wrong with some of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from stereotrack_core.annotation.fit.residuals import Clicks
from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays

_FAR_OFF = 5.0
"""Standard deviations beyond which a click does not agree with a point."""

_LEAST_SIGMA = 3.0
"""Pixels; calibrations are no better than that."""


def triangulated(
    clicks: Sequence[Clicks], cameras: Mapping[str, Camera], landmarks: int
) -> FloatArray:
    """Points (F, L, 3), world, that most clicks agree with; NaN where fewer than two are there.

    Every pair of cameras proposes a point; the one that all clicks of the landmark miss least,
    each miss limited, is made again from the clicks that agree with it.

    Parameters
    ----------
    clicks : sequence of Clicks
        One for each of F frames.
    cameras : mapping from name to Camera
        In the order of the clicks' indices.
    landmarks : int
    """
    places = list(cameras.values())
    shape = (len(clicks), landmarks, len(places))
    seen, scale = np.full((*shape, 2), np.nan), np.ones(shape)
    for k, frame in enumerate(clicks):
        at = (k, frame.landmark, frame.camera)
        seen[at] = frame.normalised
        pixels = np.sqrt(np.abs(np.linalg.det(frame.raw_from_normalised)))
        scale[at] = pixels / np.maximum(frame.sigma, _LEAST_SIGMA)
    flat, weight = seen.reshape(-1, *seen.shape[2:]), scale.reshape(-1, len(places))
    origins = np.array([place.position_world for place in places])
    rays = _rays(flat, places)
    best = np.full((len(flat), 3), np.nan)
    least = np.full(len(flat), np.inf)
    for pair in combinations(range(len(places)), 2):
        two = list(pair)
        point = nearest_to_rays(origins[two], rays[:, two])
        cost = np.nansum(np.minimum(_misses(point, flat, weight, places), _FAR_OFF) ** 2, axis=1)
        better = np.isfinite(point).all(axis=1) & (cost < least)
        best[better], least[better] = point[better], cost[better]
    agree = _misses(best, flat, weight, places) < _FAR_OFF
    again = nearest_to_rays(origins, np.where(agree[..., None], rays, np.nan))
    result = np.where(np.isfinite(again), again, best)
    return result.reshape(*shape[:2], 3)


def _rays(flat: FloatArray, places: Sequence[Camera]) -> FloatArray:
    directions = np.concatenate([flat, np.ones_like(flat[..., :1])], axis=-1)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    rotations = np.array([place.camera_from_world.rotation for place in places])
    result: FloatArray = np.einsum("vij,tvi->tvj", rotations, directions)
    return result


def _misses(
    point: FloatArray, flat: FloatArray, weight: FloatArray, places: Sequence[Camera]
) -> FloatArray:
    """By how many standard deviations the clicks miss a point (T, V); NaN without a click."""
    missed = np.full(weight.shape, np.nan)
    for v, place in enumerate(places):
        inside = place.camera_from_world.apply(point)
        depth = np.where(inside[:, 2] > 0, inside[:, 2], np.nan)
        off = np.linalg.norm(inside[:, :2] / depth[:, None] - flat[:, v], axis=1) * weight[:, v]
        behind = ~np.isfinite(off) & np.isfinite(flat[:, v, 0])
        missed[:, v] = np.where(behind, np.inf, off)
    return missed
