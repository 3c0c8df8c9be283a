"""Which points belong to the body that is followed, and how much of it they show."""

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import HEAD, TORSO
from stereotrack_core.body.surface import limbs_of_cones, nearest_on_surface
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.tracking.initialise.seeds import upright_pose
from stereotrack_core.tracking.residuals.surface import surface_distances

_CELL = 0.10  # side of the cells whose neighbourhood joins points, metres
_LEAST_IN_CELL = 2  # points without which a cell joins nothing; strays are few
_MOST_PEOPLE = 3
_ASIDE = 0.35  # metres from the expected body within which a group of points can be its own
_LARGE = 0.2  # share of the points near the body from which a group is somebody or something else
_ARMS_REACH = 1.3  # metres from the expected hips, on the floor, beyond which nothing is its own
_EVERY = 4  # of so many points one is enough to tell how far a group is from the body
_NEAR = 0.10  # metres from the surface up to which data speak for the patch that they lie on
_ROWS, _COLUMNS = 3, 6  # patches of the torso along its axis and around it
_HEAD_COLUMNS = 4
_SIDE = 0.05  # metres from a side of the working volume
_TURNED = 0.25  # cosine between a patch's normal and the sight line from which a view sees it


def _groups_of(points: FloatArray) -> IntArray:
    """Number (N,) of the group that each point (N, D) belongs to; -1 for strays.

    Points belong together where occupied cells touch.
    """
    cell = np.floor((points - points.min(axis=0)) / _CELL).astype(np.int64)
    counts = np.zeros(cell.max(axis=0) + 1, dtype=np.int64)
    np.add.at(counts, tuple(cell.T), 1)
    around = scipy.ndimage.generate_binary_structure(counts.ndim, counts.ndim)
    labels, _ = scipy.ndimage.label(counts >= _LEAST_IN_CELL, around)
    return np.asarray(labels[tuple(cell.T)].astype(np.int64) - 1)


def people_in(points: FloatArray, least: int) -> list[BoolArray]:
    """Members (N,) of the largest groups of points (N, 3), z up, that stand apart on the floor."""
    if not len(points):
        return []
    group = _groups_of(points[:, :2])
    counts = np.bincount(group[group >= 0], minlength=1)
    order = np.argsort(-counts, kind="stable")[:_MOST_PEOPLE]
    return [np.asarray(group == k) for k in order if counts[k] >= least]


def own_points(points: FloatArray, body: BodyModel, expected: Pose) -> BoolArray:
    """Points (N,) that can be the body's: not those of others who stand apart from it; z is up.

    Small groups in reach of an arm stay, for they may be a hand that moved fast.
    """
    if not len(points):
        return np.zeros(0, dtype=np.bool_)
    within = np.linalg.norm(points[:, :2] - expected.position[:2], axis=1) < _ARMS_REACH
    group = _groups_of(points)
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


def own_part(cloud: Cloud, body: BodyModel, expected: Pose, upright: Upright) -> Cloud:
    """The cloud without the points of others who stand apart from an expected pose."""
    standing = upright_pose(expected, upright)
    return cloud.part(own_points(upright.points(cloud.points), body, standing))


def trunk_support(body: BodyModel, pose: Pose, points: FloatArray, cameras: FloatArray) -> float:
    """Share of the patches of torso and head facing a camera (V, 3) that have points (N, 3)."""
    frames = body.frames(pose)
    seen, expected = 0, 0
    closest = nearest_on_surface(points, placed_cones(body, frames), _NEAR)
    of_part = limbs_of_cones(body, closest.cone)
    for part, rows, columns in ((TORSO, _ROWS, _COLUMNS), (HEAD, 1, _HEAD_COLUMNS)):
        R, origin = frames.rotations[part], frames.origins[part]
        length = body.skeleton.lengths[part]
        local = (closest.point[of_part == part] - origin) @ R
        row = np.clip(local[:, 2] / length * rows, 0, rows - 1).astype(int)
        turn = np.arctan2(local[:, 1], local[:, 0]) / (2.0 * np.pi) + 0.5
        column = np.clip(turn * columns, 0, columns - 1).astype(int)
        hit = np.zeros((rows, columns), dtype=np.bool_)
        hit[row, column] = True
        faces = _facing_cameras(hit.shape, length, R, origin, cameras)
        expected += int(np.count_nonzero(faces))
        seen += int(np.count_nonzero(hit & faces))
    return seen / max(expected, 1)


def depth_inside(points: FloatArray, volume: Volume, upright: Upright = Z_UP) -> FloatArray:
    """Metres (N,) from points (N, 3) to the nearest side of the working volume; outside negative.

    Floor and ceiling are no sides.
    """
    sides = upright.level
    depth = np.minimum(points[:, sides] - volume.low[sides], volume.high[sides] - points[:, sides])
    return np.asarray(depth.min(axis=1))


def share_at_sides(points: FloatArray, volume: Volume, upright: Upright = Z_UP) -> float:
    """Share of points (N, 3) that lie within 50 mm of a side of the working volume.

    Somebody who is cut by a side has many there, somebody who only reaches out has few.
    """
    return float(np.mean(depth_inside(points, volume, upright) < _SIDE)) if len(points) else 0.0


def _facing_cameras(
    shape: tuple[int, int], length: float, R: FloatArray, origin: FloatArray, cameras: FloatArray
) -> BoolArray:
    """Whether patches (rows, columns) are turned towards at least one camera."""
    rows, columns = shape
    turn = 2.0 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5)
    normal = np.stack([np.cos(turn), np.sin(turn), np.zeros(columns)], axis=1) @ R.T
    height = (np.arange(rows) + 0.5) / rows * length
    places = origin + height[:, None] * R[:, 2]
    sight = cameras[None] - places[:, None]
    sight /= np.linalg.norm(sight, axis=2, keepdims=True)
    cosine = np.einsum("rvi,ci->rcv", sight, normal)
    return np.asarray(cosine.max(axis=2) > _TURNED)
