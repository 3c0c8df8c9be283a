"""Limits of a body in plain NumPy: each is a number that depends on the pose, z - z_hat(pose)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stereotrack_core.body.pose import REST
from stereotrack_core.geometry.triangulation import nearest_on_segments

TORSO, HEAD, UPPER, FORE, LEGS, CLAVICLES = 0, 1, (2, 3), (4, 5), (6, 7, 8, 9), (10, 11)
PARENTS = (-1, 0, 0, 0, 2, 3, 0, 0, 6, 7, 0, 0)
DEGREES = {1: 20.0, 6: 45.0, 7: 45.0, 8: 60.0, 9: 60.0, 10: 2.5, 11: 2.5}


@dataclass
class Number:
    """One number: measured (1,), its variance (1,) and what stacked frames (S,) predict (S, 1)."""

    kind: str
    part: int
    measured: np.ndarray
    variance: np.ndarray
    predicted: Callable


def _number(kind, part, z, sigma, predicted):
    return Number(kind, part, np.array([z]), np.array([sigma**2]), lambda f: predicted(f)[:, None])


def _across(part, axis):
    """Component of a part's direction on an axis of its parent's frame."""
    parent = PARENTS[part]
    return lambda f: np.einsum(
        "sij,j,si->s", f.rotations[:, parent], axis, f.rotations[:, part, :, 2]
    )


def _resting(pose, joints):
    for part in (part for part in joints if part in DEGREES):
        for axis in REST[part][:, 0], REST[part][:, 1]:
            off = axis @ pose.rotations[part, :, 2]
            yields = part in CLAVICLES and off * axis[2] >= 0.0
            sigma = np.hypot(np.radians(DEGREES[part]), off if yields else 0.0)
            yield _number("rest", part, 0.0, sigma, _across(part, axis))


def _elbows(pose):
    for part in FORE:
        x, y, z = pose.rotations[part, :, 2]
        bend = np.arccos(np.clip(z, -1.0, 1.0))
        if bend > np.radians(150.0):
            side = np.array([x, y]) / max(np.hypot(x, y), 1e-9)
            further = np.append(np.cos(bend) * side, -np.sin(bend))
            z = np.radians(150.0) - bend
            yield _number("elbow", part, z, np.radians(3.0), _across(part, further))


def _outside_torso(body, point):
    """Distance of a point of the torso's frame from its large cone and the way out (3,)."""
    c, turn, origin = body.cones, body.cones["rotation"][0], body.cones["origin"][0]
    x, y, z = (point - origin) @ turn
    r1, r2, h, s = (c[name][0] for name in ("r1", "r2", "height", "flatness"))
    rho = np.hypot(x, y / s)
    u = ((rho - r1) * (r2 - r1) + z * h) / ((r2 - r1) ** 2 + h**2)
    foot = np.array([x / rho, y / rho, 0.0]) * (r1 + np.clip(u, 0, 1) * (r2 - r1))
    foot[2] = np.clip(u, 0, 1) * h
    out = np.array([h * x / rho, h * y / rho / s**2, -(r2 - r1)])
    if not 0.0 <= u <= 1.0:  # an inner end: only what is beside it is near to its rim
        out = np.array([x, y, z]) - foot
        if rho < r1 + np.clip(u, 0, 1) * (r2 - r1):
            return np.inf, out
    out /= np.linalg.norm(out)
    return (np.array([x, y, z]) - foot) @ out, turn @ out


def _off_torso(body, frames, clearance):
    for part in FORE:
        for share in np.linspace(0.0, 1.0, 4):
            along = share * body.skeleton.lengths[part]

            def local(f, part=part, along=along):
                world = f.origins[:, part] + along * f.rotations[:, part, :, 2]
                return np.einsum("sji,sj->si", f.rotations[:, 0], world - f.origins[:, 0])

            here = local(frames)[0]
            distance, out = _outside_torso(body, here)
            if -0.5 < distance < clearance:
                z = out @ here + clearance - distance
                yield _number("torso", part, z, 0.03, lambda f, p=local, n=out: p(f) @ n)


def _arms_apart(body, frames, least):
    length = body.skeleton.lengths
    for (left, right), room in zip(
        ((FORE[0], FORE[1]), (UPPER[0], FORE[1]), (FORE[0], UPPER[1])), (1.0, 2.0, 2.0), strict=True
    ):
        a, c = frames.origins[0, left], frames.origins[0, right]
        u, v = (length[p] * frames.rotations[0, p, :, 2] for p in (left, right))
        s, t = nearest_on_segments(a, a + u, c, c + v)
        apart = a + s * u - c - t * v
        distance = np.linalg.norm(apart)

        def predicted(f, ends=((left, s), (right, t)), n=apart / distance):
            one, two = (
                f.origins[:, p] + share * length[p] * f.rotations[:, p, :, 2] for p, share in ends
            )
            return (one - two) @ n

        if 1e-4 < distance < room * least:
            yield _number("arms", left, room * least, 0.02, predicted)


def limits(body, pose, parameters, joints):
    """All limits that a pose violates, and what rests, in the order of the tracker's rows."""
    frames = body.frames(pose[None])
    found = [*_resting(pose, joints), *_elbows(pose)]
    found += _off_torso(body, frames, parameters.clearance) if parameters.clearance > 0 else ()
    found += _arms_apart(body, frames, parameters.arms_apart) if parameters.arms_apart > 0 else ()
    return found
