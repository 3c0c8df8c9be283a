"""Fit the body's shape to a few well seen frames (docs/method.md 4.12).

Poses of all frames and the common numbers of the body are adjusted together by Gauss and
Newton's method; each frame's pose is eliminated before the body is solved for. The radii of the
arms stay as they are: block matching widens thin parts, and fitting them made forearms worse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import REST, Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.body.skeleton import CLAVICLES
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.tracking.data_to_model import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.free_body import FreeBody
from stereotrack_core.tracking.limits import limit_residuals
from stereotrack_core.tracking.outlines.edges import EdgeMap
from stereotrack_core.tracking.outlines.fit import fitted_outline
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.upright import UprightResidual, upright

_STEP = 1e-3
"""Metres, radians and parts by which derivatives are taken."""

_POSE_SIGMA = 0.5
"""Metres and radians: poses are hardly held back."""


@dataclass(frozen=True, eq=False)
class SeenPose:
    """One frame that the shape is fitted to.

    Attributes
    ----------
    data : (N, 3) float64, world
    pose : Pose
        As followed with the present shape.
    edges : tuple of EdgeMap
        Of the views that know the person's outline.
    """

    data: FloatArray
    pose: Pose
    edges: tuple[EdgeMap, ...] = ()


def fitted_shape(
    proportions: Proportions,
    shape: BodyParameters,
    seen: Sequence[SeenPose],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
) -> BodyParameters:
    """Surface that explains the data of all frames best, and outline that explains their edges."""
    surface, poses = fitted_surface(proportions, shape, seen, parameters, joints)
    edges = [frame.edges for frame in seen]
    body = body_model(proportions, surface)
    return fitted_outline(body, surface, tuple(zip(poses, edges, strict=True)), parameters.outlines)


def fitted_surface(
    proportions: Proportions,
    shape: BodyParameters,
    seen: Sequence[SeenPose],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
) -> tuple[BodyParameters, list[Pose]]:
    """Shape that explains the data of all frames best, and the poses that go with it.

    Parameters
    ----------
    proportions : Proportions
    shape : BodyParameters
        The default, which is also the start; the fit is held to it by its spread among people.
    seen : sequence of SeenPose
    parameters : TrackingParameters
    joints : tuple of int
        Joints of the state.
    """
    free = FreeBody(proportions, shape)
    found = adjusted(free, seen, parameters, joints)
    return free.parts(found.theta)[1], list(found.poses)


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Numbers of the body and poses that explain the data of all frames best.

    Attributes
    ----------
    theta : (k,) float64
        Of a :class:`FreeBody`.
    sigma : (k,) float64
        Standard deviations.
    poses : tuple of Pose
    """

    theta: FloatArray
    sigma: FloatArray
    poses: tuple[Pose, ...]


def adjusted(
    free: FreeBody,
    seen: Sequence[SeenPose],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
    *,
    iterations: int = 6,
) -> Adjusted:
    """Adjust the poses of all frames and the free numbers of the body together.

    Parameters
    ----------
    free : FreeBody
    seen : sequence of SeenPose
    parameters : TrackingParameters
    joints : tuple of int
        Joints of the state.
    iterations : int
    """
    prior, start = free.information, free.start
    joints = tuple(joint for joint in joints if joint not in CLAVICLES)
    theta, poses = start.copy(), [_with_resting_shoulders(frame.pose) for frame in seen]
    for _ in range(iterations):
        A, b, frames = prior.copy(), prior @ (start - theta), []
        for frame, pose in zip(seen, poses, strict=True):
            standing = upright(pose, len(seen))
            normal = _normal_equations(frame.data, pose, free, theta, parameters, joints, standing)
            frames.append(normal)
            A += normal.C - normal.B.T @ np.linalg.solve(normal.A, normal.B)
            b += normal.c - normal.B.T @ np.linalg.solve(normal.A, normal.a)
        step = np.linalg.solve(A, b)
        theta = theta + step
        for i, normal in enumerate(frames):
            delta: FloatArray = scipy.linalg.solve(normal.A, normal.a - normal.B @ step)
            poses[i] = displaced(poses[i], delta, joints)
    return Adjusted(theta, np.sqrt(np.diagonal(np.linalg.inv(A))), tuple(poses))


def _with_resting_shoulders(pose: Pose) -> Pose:
    """What the shoulders of many frames have in common is the shape, not a movement."""
    rotations = pose.rotations.copy()
    rotations[list(CLAVICLES)] = REST[list(CLAVICLES)]
    return Pose(pose.position, rotations)


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of one frame: pose block A, a; body block C, c; B between them."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    a: FloatArray
    c: FloatArray


def _normal_equations(
    data: FloatArray,
    pose: Pose,
    free: FreeBody,
    theta: FloatArray,
    parameters: TrackingParameters,
    joints: tuple[int, ...],
    standing: tuple[UprightResidual, ...],
) -> _Normal:
    body = free.body(theta)
    p = parameters
    trust = Trust(p.reach, p.robust_narrow, p.sigma_measurement, p.effective_points)
    surface = surface_residual(data, body, body.frames(pose), trust)
    n = 6 + 2 * len(joints)
    near = np.concatenate([_STEP * np.eye(n), -_STEP * np.eye(n)])
    frames = body.frames(displaced(pose, near, joints))
    A, a = np.eye(n) / _POSE_SIGMA**2, np.zeros(n)
    for residual in (*limit_residuals(body, pose, p, joints), *standing):
        J = _differences(residual.predicted(frames))
        here = residual.predicted(body.frames(displaced(pose, np.zeros((1, n)), joints)))[0]
        A += (J / residual.variance) @ J.T
        a += (J / residual.variance) @ (residual.measured - here)
    J = _differences(surface.predicted(frames))
    S = -np.stack([_change(surface, pose, free, theta, i) for i in range(len(theta))])
    weighted = J / surface.variance
    return _Normal(
        A=A + weighted @ J.T,
        B=weighted @ S.T,
        C=(S / surface.variance) @ S.T,
        a=a + weighted @ surface.distance,
        c=(S / surface.variance) @ surface.distance,
    )


def _differences(predicted: FloatArray) -> FloatArray:
    n = len(predicted) // 2
    return (predicted[:n] - predicted[n:]) / (2.0 * _STEP)


def _change(
    surface: SurfaceResidual, pose: Pose, free: FreeBody, theta: FloatArray, i: int
) -> FloatArray:
    """Derivative (m,) of the signed distances by the i-th number of the body."""
    sides = []
    for step in (_STEP, -_STEP):
        moved = theta.copy()
        moved[i] += step
        body = free.body(moved)
        feet = nearest_on_surface(surface.data, placed_cones(body, body.frames(pose)), np.inf)
        sides.append(feet.distance)
    change = (sides[0] - sides[1]) / (2.0 * _STEP)
    return np.where(np.abs(change) < 3.0, change, 0.0)
