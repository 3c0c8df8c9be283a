"""Limits of joints and collisions as soft rows of the correction (docs/method.md 4.8)."""

import math
from functools import cache
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import ARMS, ELBOW, REST_ROW, ROW, TORSO_ROW, Rows
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import REST, Pose
from stereotrack_core.body.skeleton import (
    CLAVICLES,
    FOREARMS,
    HEAD,
    PARENTS,
    SHANKS,
    THIGHS,
    TORSO,
    UPPER_ARMS,
)
from stereotrack_core.body.surface import closest_on_cone, in_cone
from stereotrack_core.compiled import compiled
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import GIRDLE_REST

_PARENTS = np.array(PARENTS, dtype=np.int64)
# Of the limbs that no measure counts from straight; they only take data. Those of the clavicles are
# least ones.
_REST_SIGMA = {
    HEAD: np.radians(20.0),
    **dict.fromkeys(THIGHS, np.radians(45.0)),
    **dict.fromkeys(SHANKS, np.radians(60.0)),
    **dict.fromkeys(CLAVICLES, GIRDLE_REST),
}
LEAST_ELBOW_ANGLE = float(np.radians(30.0))  # between upper arm and forearm
_ELBOW_SIGMA = float(np.radians(3.0))  # how firmly an elbow is kept from folding farther
_COLLISION_SIGMA = 0.03  # metres; how firmly an arm is held off the torso
_CHECKED = 4  # places along a forearm, from elbow to hand, whose distance from the torso is checked
_DEEPEST = 0.5  # metres inside the torso beyond which a place is not moved out of it

# Where arms cross, data of the arm in front are near the surface of the one behind as well and
# draw it into the first; nothing in the data speaks against that.
# Parts of the left and of the right arm that may meet.
PAIRS = ((FOREARMS[0], FOREARMS[1]), (UPPER_ARMS[0], FOREARMS[1]), (FOREARMS[0], UPPER_ARMS[1]))
ROOM = (1.0, 2.0, 2.0)  # least distances of the pairs' axes, in those of the forearms
_APART_SIGMA = 0.02  # metres; arms give way
_MEETING = 1e-4  # metres; axes that are nearer have no direction in which to part
# A part that should rest, and an axis of its parent's frame that it should be square to; if it
# `yields`, it is held the less the farther it is off.
RESTING = np.dtype(
    [("part", "i8"), ("across", "f8", (3,)), ("variance", "f8"), ("yields", "?")], align=True
)
Resting = np.ndarray[Any, np.dtype[np.void]]  # records ``RESTING`` (m,)


@cache
def resting(joints: tuple[int, ...]) -> Resting:
    """Two records for every joint that should rest."""
    parts = [joint for joint in joints if joint in _REST_SIGMA for _ in range(2)]
    found = np.zeros(len(parts), dtype=RESTING)
    for k, part in enumerate(parts):
        found[k] = part, REST[part][:, k % 2], _REST_SIGMA[part] ** 2, part in CLAVICLES
    return found


def off_rest(limbs: Resting, rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances of limbs (..., m) from their rest, and variances, of rotations (..., P, 3, 3).

    The farther shoulders are lifted, pushed forward or drawn back, the less they are held: the
    negative logarithm of a Cauchy density, by iterated weights. Where they do not rest they may be
    anywhere; but nobody lowers them far.
    """
    across = limbs["across"]
    off = np.einsum("mi,...mi->...m", across, rotations[..., 2][..., limbs["part"], :])
    held = ~limbs["yields"] | (off * across[:, 2] < 0.0)
    return off, limbs["variance"] + np.where(held, 0.0, off) ** 2


def limit_rows(
    body: BodyModel, pose: Pose, parameters: TrackingParameters, joints: tuple[int, ...]
) -> Rows:
    """Rows for the limits that a pose violates, and for limbs that should rest."""
    frames, limbs = body.frames(pose), resting(joints)
    rows = np.zeros(len(limbs) + len(FOREARMS) * (1 + _CHECKED) + len(PAIRS), dtype=ROW)
    bounds = parameters.clearance, parameters.arms_apart
    placed = frames.rotations, frames.origins
    torso = body.cones[:1]
    count = _fill_limits(limbs, placed, body.skeleton.lengths, torso, bounds, rows)
    result: Rows = rows[:count]
    return result


@compiled()
def _fill_limits(
    limbs: Any, placed: Any, lengths: Any, torso: Any, bounds: Any, out_rows: Any
) -> int:
    """Fill rows and return how many there are; `bounds` are clearance and distance of arms."""
    n = 0
    for i in range(limbs.shape[0]):
        limb, row = limbs[i], out_rows[n]
        x, y, z = limb.across[0], limb.across[1], limb.across[2]
        off = _across(row, limb.part, placed, x, y, z)
        row.kind, row.innovation, row.variance = REST_ROW, -off, limb.variance
        if limb.yields and off * z >= 0.0:
            row.variance += off * off
        n += 1
    for k in range(2):
        n = _unfold(FOREARMS[k], placed, n, out_rows)
    if bounds[0] > 0.0:
        n = _hold_off(placed, lengths, torso[0], bounds[0], n, out_rows)
    if bounds[1] > 0.0:
        for k in range(3):
            n = _part_arms(PAIRS[k], placed, lengths, ROOM[k] * bounds[1], n, out_rows)
    return n


@compiled(inline="always")
def _across(row: Any, part: int, placed: Any, x: float, y: float, z: float) -> float:
    """Fill a row with a part's direction on an axis (3) of its parent; return the component."""
    rotations, origins = placed
    parent, off = _PARENTS[part], 0.0
    row.part, row.until, row.other = part, parent, -1
    for i in range(3):
        axis = rotations[parent, i, 0] * x + rotations[parent, i, 1] * y
        axis += rotations[parent, i, 2] * z
        row.direction[i] = axis
        row.point[i] = origins[part, i] + rotations[part, i, 2]
        off += axis * rotations[part, i, 2]
    return off


@compiled()
def _unfold(fore: int, placed: Any, n: int, out_rows: Any) -> int:
    """Ask an elbow that is bent beyond its limit to come back to it."""
    upper, along = placed[0][_PARENTS[fore]], placed[0][fore]
    x = upper[0, 0] * along[0, 2] + upper[1, 0] * along[1, 2] + upper[2, 0] * along[2, 2]
    y = upper[0, 1] * along[0, 2] + upper[1, 1] * along[1, 2] + upper[2, 1] * along[2, 2]
    z = upper[0, 2] * along[0, 2] + upper[1, 2] * along[1, 2] + upper[2, 2] * along[2, 2]
    bend = math.acos(min(1.0, max(-1.0, z)))
    excess = bend - (math.pi - LEAST_ELBOW_ANGLE)
    if excess <= 0.0:
        return n
    row, side = out_rows[n], math.cos(bend) / max(math.hypot(x, y), 1e-9)
    off = _across(row, fore, placed, side * x, side * y, -math.sin(bend))
    row.kind, row.innovation, row.variance = ELBOW, -excess - off, _ELBOW_SIGMA**2
    return n + 1


@compiled()
def _hold_off(placed: Any, lengths: Any, cone: Any, clearance: float, n: int, out_rows: Any) -> int:
    """Hold the axes of forearms and hands off the torso's large cone."""
    rotations, origins = placed
    R, away = rotations[TORSO], np.empty(3)
    for k in range(2 * _CHECKED):
        fore, row = FOREARMS[k // _CHECKED], out_rows[n]
        along = lengths[fore] * (k % _CHECKED) / (_CHECKED - 1)
        for i in range(3):
            row.point[i] = origins[fore, i] + along * rotations[fore, i, 2]
            away[i] = row.point[i] - origins[TORSO, i]
        x = R[0, 0] * away[0] + R[1, 0] * away[1] + R[2, 0] * away[2]
        y = R[0, 1] * away[0] + R[1, 1] * away[1] + R[2, 1] * away[2]
        z = R[0, 2] * away[0] + R[1, 2] * away[1] + R[2, 2] * away[2]
        x, y, z = in_cone(cone, x, y, z)
        d, _, _, _, nx, ny, nz = closest_on_cone(cone, x, y, z)
        if not -_DEEPEST < d < clearance:
            continue
        for i in range(3):
            away[i] = cone.rotation[i, 0] * nx + cone.rotation[i, 1] * ny
            away[i] += cone.rotation[i, 2] * nz
        for i in range(3):
            row.direction[i] = R[i, 0] * away[0] + R[i, 1] * away[1] + R[i, 2] * away[2]
        row.kind, row.part, row.until, row.other = TORSO_ROW, fore, TORSO, -1
        row.innovation, row.variance = clearance - d, _COLLISION_SIGMA**2
        n += 1
    return n


@compiled()
def _part_arms(pair: Any, placed: Any, lengths: Any, least: float, n: int, out_rows: Any) -> int:
    """Part two limbs whose axes are nearer than they can be."""
    rotations, origins = placed
    left, right = pair
    a, c, u, v = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        a[i], c[i] = origins[left, i], origins[right, i]
        u[i] = lengths[left] * rotations[left, i, 2]
        v[i] = lengths[right] * rotations[right, i, 2]
    s, t = nearest_shares(a, u, c, v)
    row, squared = out_rows[n], 0.0
    for i in range(3):
        row.point[i], row.other_point[i] = a[i] + s * u[i], c[i] + t * v[i]
        row.direction[i] = row.point[i] - row.other_point[i]
        squared += row.direction[i] ** 2
    distance = math.sqrt(squared)
    if not _MEETING < distance < least:
        return n
    for i in range(3):
        row.direction[i] /= distance
    row.kind, row.part, row.until, row.other = ARMS, left, TORSO, right
    row.innovation, row.variance = least - distance, _APART_SIGMA**2
    return n + 1


@compiled()
def nearest_shares(a: Any, u: Any, c: Any, v: Any) -> Any:
    """Shares, 0 to 1, at which the segments a + s u and c + t v, all (3,), are nearest.

    Found on the lines, then moved into the segments one after the other (Ericson, Real-Time
    Collision Detection, section 5.1.9).
    """
    uu = vv = uv = uw = vw = 0.0
    for i in range(3):
        w = a[i] - c[i]
        uu, vv, uv = uu + u[i] * u[i], vv + v[i] * v[i], uv + u[i] * v[i]
        uw, vw = uw + u[i] * w, vw + v[i] * w
    s, determinant = 0.0, uu * vv - uv * uv
    if determinant > 1e-12 * uu * vv:
        s = min(1.0, max(0.0, (uv * vw - uw * vv) / determinant))
    t = min(1.0, max(0.0, (uv * s + vw) / vv)) if vv > 0.0 else 0.0
    s = min(1.0, max(0.0, (uv * t - uw) / uu)) if uu > 0.0 else 0.0
    return s, t
