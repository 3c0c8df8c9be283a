"""How far the outline lies outside of the surface that the clouds show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.cones import OUTLINE_NAMES
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import Pose
from stereotrack_core.tracking.outlines.edges import EdgeMap
from stereotrack_core.tracking.outlines.parameters import OutlineTrust
from stereotrack_core.tracking.outlines.sensor import outlines_of

_PRIOR_SIGMA = 0.015
"""Metres by which margins differ from person to person and camera to camera."""

_NOISE, _TOGETHER = 0.015, 6.0
"""Metres of one outline's distance, and how many of them are one independent measurement."""

_ROUNDS = 8


def fitted_outline(
    body: BodyModel,
    shape: BodyParameters,
    seen: Sequence[tuple[Pose, tuple[EdgeMap, ...]]],
    trust: OutlineTrust,
) -> BodyParameters:
    """Shape with the margins that the outlines of some frames show.

    Both sides of a limb are in the pictures, so a pose that is a little wrong shifts one side as
    far out as the other side in, and the margins come out right.

    Parameters
    ----------
    body : BodyModel
        Made from `shape`.
    shape : BodyParameters
    seen : sequence of (Pose, tuple of EdgeMap)
    trust : OutlineTrust
    """
    names = list(dict.fromkeys(name for pair in OUTLINE_NAMES for name in pair))
    start = np.array([float(shape.values()[name]) for name in names])
    A, e = _rows(body, names, seen, trust)
    if not len(e):
        return shape
    prior = np.eye(len(names)) / _PRIOR_SIGMA**2
    left: FloatArray = e
    for _ in range(_ROUNDS):
        weight = 1.0 / ((1.0 + (left / _NOISE) ** 2) * _NOISE**2 * _TOGETHER)
        theta: FloatArray = scipy.linalg.solve(prior + (A.T * weight) @ A, (A.T * weight) @ e)
        left = e - A @ theta
    known = {row.name: row for row in shape.rows()}
    return shape.replaced(
        **{
            name: float(np.clip(value, known[name].minimum, known[name].maximum))
            for name, value in zip(names, start + theta, strict=True)
        }
    )


def _rows(
    body: BodyModel,
    names: list[str],
    seen: Sequence[tuple[Pose, tuple[EdgeMap, ...]]],
    trust: OutlineTrust,
) -> tuple[FloatArray, FloatArray]:
    """Shares (m, n) of the margins in the outlines' distances, and the distances (m,)."""
    columns = np.array([[names.index(name) for name in pair] for pair in OUTLINE_NAMES])
    shares, distances = [], []
    for pose, edges in seen:
        frames = body.frames(pose)
        placed = placed_cones(body, frames)
        found = outlines_of(edges, body, frames, trust)
        rotation, origin = placed.rotations[found.cone], placed.origins[found.cone]
        local = np.einsum("mji,mj->mi", rotation, found.foot - origin)[:, :2] ** 2
        part = local / np.maximum(local.sum(axis=1, keepdims=True), 1e-12)
        A = np.zeros((len(part), len(names)))
        at = np.arange(len(part))
        for axis in range(2):
            np.add.at(A, (at, columns[found.cone, axis]), part[:, axis])
        shares.append(A)
        distances.append(found.distance)
    if not shares:
        return np.empty((0, len(names))), np.empty(0)
    return np.concatenate(shares), np.concatenate(distances)
