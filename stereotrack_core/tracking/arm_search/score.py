"""What speaks for and against an arm (docs/method.md 4.9)."""

import math
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.surface import in_cone
from stereotrack_core.compiled import compiled
from stereotrack_core.tracking.arm_search.arms import LEFT, Arms, ArmShape
from stereotrack_core.tracking.residuals.limits import ROOM, nearest_shares

# Seven places along the arm beyond the elbow (1 elbow, 2 wrist, 3 finger tip), and shares (7, 4) of
# the nodes in them.
_ALONG = np.linspace(0.0, 3.0, 11)[4:]
_SEGMENT = np.minimum(_ALONG.astype(int), 2)
_SHARES = (
    np.eye(4)[_SEGMENT] * (1.0 - _ALONG + _SEGMENT)[:, None]
    + np.eye(4)[_SEGMENT + 1] * (_ALONG - _SEGMENT)[:, None]
)
# First and last node of the left and of the right arm's limbs that may meet, as in ``PAIRS``.
_MEET = np.array([[1, 3, 1, 3], [0, 1, 1, 3], [1, 3, 0, 1]])
# Metres from the torso's surface, negative inside, from which an arm's axis is too deep: bodies
# give way where arms lie on them.
_DEEP = -0.03
# Angles by which upper arm and forearm move easily from frame to frame.
_UPPER_MOVES, _FORE_MOVES = math.radians(30.0), math.radians(40.0)
_FOLDED, _FOLDING = math.radians(140.0), math.radians(15.0)


def anatomy_cost(body: BodyModel, shape: ArmShape, arms: Arms) -> FloatArray:
    """Cost (K,) of elbows bent too far, arms inside the torso, and arms where arms cannot be."""
    cost, mirrored = np.empty(len(arms)), -1.0 if shape.side == LEFT else 1.0
    places = _SHARES @ shape.nodes(arms)
    _anatomy_costs(arms.upper, arms.fore, mirrored, places, body.cones[:1], cost)
    return cost


@compiled()
def change_cost(was_upper: Any, was_fore: Any, upper: Any, fore: Any) -> Any:
    """Cost (K,) of arms (K, 3) for their change against the one that is predicted (1, 3)."""
    cost = np.empty(upper.shape[0])
    for k in range(upper.shape[0]):
        moved = _angle(was_upper[0], upper[k]) / _UPPER_MOVES
        turned = _angle(was_fore[0], fore[k]) / _FORE_MOVES
        cost[k] = 2.0 * (math.log1p(moved * moved) + math.log1p(turned * turned))
    return cost


@compiled(inline="always")
def _angle(a: Any, b: Any) -> float:
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return math.atan2(math.sqrt(x * x + y * y + z * z), a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled()
def crossing_cost(left: Any, right: Any, least: float) -> Any:
    """Cost (K, L) of pairs of arms, nodes (K, 4, 3) and (L, 4, 3), that go through each other.

    Axes of forearms are at `least` so many metres apart, see :mod:`residuals.limits`; 0: none.
    """
    cost = np.zeros((left.shape[0], right.shape[0]))
    if least <= 0.0:
        return cost
    u, v = np.empty(3), np.empty(3)
    for k in range(left.shape[0]):
        for m in range(right.shape[0]):
            for meet in range(3):
                a, b = _MEET[meet, 0], _MEET[meet, 1]
                c, d = _MEET[meet, 2], _MEET[meet, 3]
                for i in range(3):
                    u[i] = left[k, b, i] - left[k, a, i]
                    v[i] = right[m, d, i] - right[m, c, i]
                s, t = nearest_shares(left[k, a], u, right[m, c], v)
                squared = 0.0
                for i in range(3):
                    squared += (left[k, a, i] + s * u[i] - right[m, c, i] - t * v[i]) ** 2
                room = ROOM[meet] * least - math.sqrt(squared)
                cost[k, m] += 3.0 * _steps(room / 0.03)
    return cost


@compiled()
def arm_distances(points: Any, nodes: Any, radii: Any) -> Any:
    """Unsigned distances (K, N) of points (3, N) from the surfaces of arms (K, 4, 3)."""
    result = np.full((nodes.shape[0], points.shape[1]), math.inf)
    x, y, z = points[0], points[1], points[2]
    for k in range(nodes.shape[0]):
        near = result[k]
        for s in range(3):
            ax, ay, az = nodes[k, s, 0], nodes[k, s, 1], nodes[k, s, 2]
            bx, by = nodes[k, s + 1, 0] - ax, nodes[k, s + 1, 1] - ay
            bz = nodes[k, s + 1, 2] - az
            share = 1.0 / (bx * bx + by * by + bz * bz)
            thick, taper = radii[s, 0], radii[s, 1] - radii[s, 0]
            # No branch and no division inside, numbers side by side: compiled to several at once.
            for i in range(points.shape[1]):
                px, py, pz = x[i] - ax, y[i] - ay, z[i] - az
                t = min(1.0, max(0.0, (px * bx + py * by + pz * bz) * share))
                dx, dy, dz = px - t * bx, py - t * by, pz - t * bz
                off = math.sqrt(dx * dx + dy * dy + dz * dz) - (thick + t * taper)
                near[i] = min(near[i], abs(off))
    return result


@compiled()
def pair_sums(others: Any, left: Any, right: Any, squared_scale: float) -> Any:
    """Sums (K, L) of d^2 / (d^2 + s^2), d the least of others (N,) and of a pair's distances.

    Pairs are all of left (K, N) and right (L, N); each counts a datum as its nearer arm alone does.
    """
    result = np.empty((left.shape[0], right.shape[0]))
    one, other = np.empty(left.shape), np.empty(right.shape)
    one_costs, other_costs = np.empty(left.shape), np.empty(right.shape)
    _explained(others, left, squared_scale, one, one_costs)
    _explained(others, right, squared_scale, other, other_costs)
    for k in range(left.shape[0]):
        for m in range(right.shape[0]):
            total = 0.0
            for i in range(others.shape[0]):
                total += one_costs[k, i] if one[k, i] <= other[m, i] else other_costs[m, i]
            result[k, m] = total
    return result


@compiled()
def _explained(others: Any, own: Any, squared_scale: float, near: Any, costs: Any) -> None:
    """Fill the lesser distances (K, N) of others and own, and what they cost."""
    for k in range(own.shape[0]):
        for i in range(own.shape[1]):
            d = min(others[i], own[k, i])
            near[k, i], costs[k, i] = d, d * d / (d * d + squared_scale)


@compiled()
def _anatomy_costs(
    upper: Any, fore: Any, mirrored: float, places: Any, torso: Any, result: Any
) -> None:
    """Fill costs (K,) of elbows bent too far, arms inside the torso, and where arms cannot be.

    `upper` and `fore` (K, 3) are directions in the torso's frame, `mirrored` is -1 for left arms;
    `places` (K, P, 3), beyond the elbows, as well; `torso` (1,) is the torso's cone.
    """
    cone = torso[0]
    for k in range(upper.shape[0]):
        ux, uy, uz = mirrored * upper[k, 0], upper[k, 1], upper[k, 2]
        fx, fy, fz = mirrored * fore[k, 0], fore[k, 1], fore[k, 2]
        along = ux * fx + uy * fy + uz * fz
        cx, cy, cz = uy * fz - uz * fy, uz * fx - ux * fz, ux * fy - uy * fx
        bend = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), along)
        cost = 12.0 * _steps((bend - _FOLDED) / _FOLDING)
        cost += 6.0 * _steps((-uy - 0.55) / 0.25) + 6.0 * _steps((-ux - 0.60) / 0.25)
        if uz < 0.4:
            cost += 6.0 * _steps((along * uy - fy - 0.40) / 0.30)
        for i in range(places.shape[1]):
            x, y, z = in_cone(cone, places[k, i, 0], places[k, i, 1], places[k, i, 2])
            if 0.0 <= z <= cone.height:
                out = math.hypot(x, y / cone.flatness)
                off = out - cone.r1 - (cone.r2 - cone.r1) * z / cone.height
                cost += 3.0 * _steps((_DEEP - (cone.flatness * off if out > 0.0 else off)) / 0.03)
        result[k] = cost


@compiled(inline="always")
def _steps(excess: float) -> float:
    """An excess in units of its step, between none and two."""
    return min(2.0, max(0.0, excess))
