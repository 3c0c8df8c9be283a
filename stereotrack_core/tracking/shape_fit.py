"""Fit the body's shape to a few well seen frames (method.md 4J).

Poses of all frames and one common shape are adjusted together by Gauss and Newton's method;
each frame's pose is eliminated before the shape is solved for. The radii of the arms stay as
they are: block matching widens thin parts, and fitting them made forearms worse.
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
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.tracking.data_to_model import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.limits import limit_residuals
from stereotrack_core.tracking.outlines.edges import EdgeMap
from stereotrack_core.tracking.outlines.fit import fitted_outline
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.upright import UprightResidual, upright

SHAPE_SIGMAS: dict[str, float] = {
    "torso_radius_low": 0.02,
    "torso_radius_high": 0.02,
    "torso_flatness": 0.10,
    "torso_forward_low": 0.015,
    "torso_forward_high": 0.015,
    "shoulder_rise": 0.015,
    "shoulder_radius_factor": 0.15,
    "head_rise": 0.03,
    "head_forward": 0.01,
    "head_radius_factor": 0.12,
    "leg_forward": 0.008,
    "leg_radius_factor": 0.15,
}
"""What is fitted, and how much people differ from the default, in the parameters' units.

Shifts to the front are held firmly: all of them together cannot be told from a body that leans.
"""

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
    *,
    iterations: int = 6,
) -> tuple[BodyParameters, list[Pose]]:
    """Shape that explains the data of all frames best, and the poses that go with it.

    The shape is held to the default by its spread among people.

    Parameters
    ----------
    proportions : Proportions
    shape : BodyParameters
        The default, which is also the start.
    seen : sequence of SeenPose
    parameters : TrackingParameters
    joints : tuple of int
        Joints of the state.
    iterations : int
    """
    names = tuple(SHAPE_SIGMAS)
    prior = np.diag([SHAPE_SIGMAS[name] ** -2.0 for name in names])
    start = np.array([float(shape.values()[name]) for name in names])
    theta, poses = start.copy(), [frame.pose for frame in seen]
    for _ in range(iterations):
        here = _with(shape, names, theta)
        A, b, frames = prior.copy(), prior @ (start - theta), []
        for frame, pose in zip(seen, poses, strict=True):
            standing = upright(pose, len(seen))
            normal = _normal_equations(
                frame.data, pose, proportions, here, parameters, joints, standing
            )
            frames.append(normal)
            A += normal.C - normal.B.T @ np.linalg.solve(normal.A, normal.B)
            b += normal.c - normal.B.T @ np.linalg.solve(normal.A, normal.a)
        step = np.linalg.solve(A, b)
        theta = theta + step
        for i, normal in enumerate(frames):
            delta: FloatArray = scipy.linalg.solve(normal.A, normal.a - normal.B @ step)
            poses[i] = displaced(poses[i], delta, joints)
    return _with(shape, names, theta), poses


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of one frame: pose block A, a; shape block C, c; B between them."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    a: FloatArray
    c: FloatArray


def _normal_equations(
    data: FloatArray,
    pose: Pose,
    proportions: Proportions,
    shape: BodyParameters,
    parameters: TrackingParameters,
    joints: tuple[int, ...],
    standing: tuple[UprightResidual, ...],
) -> _Normal:
    body = body_model(proportions, shape)
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
    S = -np.stack([_change(surface, pose, proportions, shape, name) for name in SHAPE_SIGMAS])
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
    surface: SurfaceResidual,
    pose: Pose,
    proportions: Proportions,
    shape: BodyParameters,
    name: str,
) -> FloatArray:
    """Derivative (m,) of the signed distances by one number of the shape."""
    sides = []
    for sign in (1.0, -1.0):
        value = float(shape.values()[name]) + sign * _STEP
        body = body_model(proportions, shape.replaced(**{name: value}))
        feet = nearest_on_surface(surface.data, placed_cones(body, body.frames(pose)), np.inf)
        sides.append(feet.distance)
    change = (sides[0] - sides[1]) / (2.0 * _STEP)
    return np.where(np.abs(change) < 3.0, change, 0.0)


def _with(shape: BodyParameters, names: tuple[str, ...], theta: FloatArray) -> BodyParameters:
    rows = {row.name: row for row in BodyParameters.rows()}
    values = {}
    for name, value in zip(names, theta, strict=True):
        low, high = rows[name].minimum, rows[name].maximum
        values[name] = float(np.clip(value, low, high))
    return shape.replaced(**values)
