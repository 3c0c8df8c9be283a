"""Which points of a cloud belong together, and which of them to the body that is followed."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.tracking.confidence import surface_distances

_CELL = 0.10
"""Side of the cells whose neighbourhood joins points, metres."""

_LEAST_IN_CELL = 2
"""Points without which a cell joins nothing; strays are few."""

_MOST_PEOPLE = 3

_ASIDE = 0.35
"""Metres from the expected body within which a group of points can be its own."""

_LARGE = 0.2
"""Share of the points near the body from which a group of points is somebody or something else."""

_ARMS_REACH = 1.3
"""Metres from the expected hips, on the floor, beyond which nothing is the body's own."""

_EVERY = 4
"""Of so many points one is enough to tell how far a group is from the body."""


def groups_of(points: FloatArray, *, on_floor: bool) -> IntArray:
    """Number (N,) of the group that each point (N, 3) belongs to; -1 for strays.

    Points belong together where occupied cells touch, seen from above or in space.
    """
    use = points[:, :2] if on_floor else points
    cell = np.floor((use - use.min(axis=0)) / _CELL).astype(np.int64)
    counts = np.zeros(cell.max(axis=0) + 1, dtype=np.int64)
    np.add.at(counts, tuple(cell.T), 1)
    around = ndimage.generate_binary_structure(counts.ndim, counts.ndim)
    labels, _ = ndimage.label(counts >= _LEAST_IN_CELL, around)
    result: IntArray = labels[tuple(cell.T)].astype(np.int64) - 1
    return result


def people_in(points: FloatArray, least: int) -> list[BoolArray]:
    """Members (N,) of the largest groups that stand apart on the floor, largest first."""
    if not len(points):
        return []
    group = groups_of(points, on_floor=True)
    counts = np.bincount(group[group >= 0], minlength=1)
    order = np.argsort(-counts, kind="stable")[:_MOST_PEOPLE]
    return [np.asarray(group == k) for k in order if counts[k] >= least]


def own_points(points: FloatArray, body: BodyModel, expected: Pose) -> BoolArray:
    """Points (N,) that can be the body's: not those of others who stand apart from it.

    Small groups in reach of an arm stay, for they may be a hand that moved fast.
    """
    if not len(points):
        return np.zeros(0, dtype=np.bool_)
    within = np.linalg.norm(points[:, :2] - expected.position[:2], axis=1) < _ARMS_REACH
    group = groups_of(points, on_floor=False)
    if group.max() < 1:
        return np.asarray(within)
    distance = np.abs(surface_distances(points[::_EVERY], body, expected))
    of_group = np.full(group.max() + 1, np.inf)
    known = group[::_EVERY] >= 0
    np.minimum.at(of_group, group[::_EVERY][known], distance[known])
    counts = np.bincount(group[group >= 0], minlength=len(of_group))
    main = int(counts[of_group < _ASIDE].max(initial=0))
    foreign = (of_group >= _ASIDE) & (counts > _LARGE * main)
    return np.asarray(within & ~((group >= 0) & foreign[group]))
