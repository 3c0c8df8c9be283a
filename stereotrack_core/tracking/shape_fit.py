"""Fit the body's shape to a few well seen frames (docs/method.md 4.12).

Poses of all frames and the common numbers of the body are adjusted together by Gauss and
Newton's method; each frame's pose is eliminated before the body is solved for. The radii of the
arms stay as they are: block matching widens thin parts, and fitting them made forearms worse.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.manifold import columns_of, displaced, jacobian
from stereotrack_core.body.model import CONTOUR_NAMES, BodyModel, body_model, placed_cones
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import REST, Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.body.skeleton import CLAVICLES
from stereotrack_core.depth.chain import OnPart
from stereotrack_core.depth.cloud import Cloud, EdgeMap
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals import standing
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.residuals.reprojection import (
    KeypointFit,
    KeypointObservation,
    pixel_gradients,
)
from stereotrack_core.tracking.residuals.silhouette import contours_of, silhouettes_of
from stereotrack_core.tracking.residuals.surface import (
    SurfaceResidual,
    Trust,
    surface_distances,
    surface_residual,
)
from stereotrack_core.tracking.state import Setup

# What is fitted of the surface, and how much people differ from the default, in the parameters'
# units. Shifts to the front are held firmly: all together cannot be told from a body that leans.
_SHAPE_SIGMAS: dict[str, float] = {
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
    "leg_length_factor": 0.12,
}
# How much people of one height differ in their lengths, as parts of them.
LENGTH_SIGMAS: dict[str, float] = {
    "shoulder_width": 0.05,
    "hip_width": 0.07,
    "torso_length": 0.04,
    "upper_arm_length": 0.04,
    "forearm_length": 0.04,
    "hand_length": 0.05,
    "shoulder_to_head": 0.06,
}
_HEIGHT_SIGMA = 0.06  # part by which people differ in height; it moves all lengths together
_STEP = 1e-3  # metres, radians and parts by which derivatives are taken
_ITERATIONS = 6
_POSE_SIGMA = 0.5  # metres and radians: poses are hardly held back
_PRIOR_SIGMA = 0.015  # metres by which margins differ from person to person and camera to camera
_NOISE = 0.015  # metres of one outline's distance
_TOGETHER = 6.0  # so many of them are one independent measurement
_ROUNDS = 8
# Where a detector's keypoints lie beside the landmarks, among the numbers of a body's shape.
OFFSETS = tuple(row.name for row in BodyShape.rows() if row.name.startswith("keypoint_"))
# Metres by which detectors differ from the present shape; those to the front are held firmly, too.
_OFFSET_SIGMA, _FORWARD_SIGMA = 0.02, 0.005
_FRAMES_TOGETHER = 3.0  # that are one measurement: a detector errs alike in successive pictures


def shape_with(shape: BodyShape, names: Sequence[str], values: FloatArray) -> BodyShape:
    """The shape with values (k,) by their names, within the limits of the parameters."""
    rows = {row.name: row for row in shape.rows()}
    limits = [(rows[name].minimum, rows[name].maximum) for name in names]
    within = (float(np.clip(value, *ends)) for value, ends in zip(values, limits, strict=True))
    return shape.replaced(**dict(zip(names, within, strict=True)))


@dataclass(frozen=True, eq=False)
class FreeBody:
    """A body with free numbers: lengths as logarithms of ratios, the surface's as they are."""

    proportions: Proportions  # what lengths are expected to be
    shape: BodyShape  # what the surface is expected to be
    lengths: tuple[str, ...] = ()  # names of the free ones
    surface: tuple[str, ...] = tuple(_SHAPE_SIGMAS)  # names of the free ones

    @property
    def start(self) -> FloatArray:
        """What is expected (k,)."""
        values = self.shape.values()
        return np.array([0.0] * len(self.lengths) + [float(values[name]) for name in self.surface])

    @property
    def information(self) -> FloatArray:
        """Inverse (k, k) of the covariance with which people differ from what is expected."""
        k = len(self.lengths)
        sigmas = [LENGTH_SIGMAS[name] for name in self.lengths]
        sigmas += [_SHAPE_SIGMAS[name] for name in self.surface]
        covariance = np.diag(np.square(sigmas))
        covariance[:k, :k] += _HEIGHT_SIGMA**2
        return np.linalg.inv(covariance)

    def parts(self, theta: FloatArray) -> tuple[Proportions, BodyShape]:
        """Lengths and surface for values (k,) of the free numbers."""
        k = len(self.lengths)
        ratios = dict(zip(self.lengths, np.exp(theta[:k]), strict=True))
        lengths = {name: float(r * getattr(self.proportions, name)) for name, r in ratios.items()}
        shape = shape_with(self.shape, self.surface, theta[k:])
        return dataclasses.replace(self.proportions, **lengths), shape

    def body(self, theta: FloatArray) -> BodyModel:
        """Body for values (k,) of the free numbers."""
        return body_model(*self.parts(theta))


@dataclass(frozen=True, eq=False)
class SeenPose:
    """One frame that the shape is fitted to."""

    data: FloatArray  # (N, 3), world
    pose: Pose  # as followed with the present shape
    edges: tuple[EdgeMap, ...] = ()  # of the views that know the person's outline
    upright: Upright = Z_UP  # which way is up


def fitted_shape(
    body: BodyModel,
    seen: Sequence[SeenPose],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
    on_frame: OnPart = lambda _done, _count: None,
) -> BodyShape:
    """Surface that explains the data of all frames best, and contour that explains their edges."""
    fitted, poses = fitted_surface(body, seen, parameters, joints, on_frame)
    edges = [frame.edges for frame in seen]
    return fitted_outline(fitted, tuple(zip(poses, edges, strict=True)))


def fitted_surface(
    body: BodyModel,
    seen: Sequence[SeenPose],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
    on_frame: OnPart = lambda _done, _count: None,
) -> tuple[BodyModel, tuple[Pose, ...]]:
    """Body whose surface explains the data of all frames best, and the poses that go with it.

    The fit is held to the shape that it starts from by its spread among people.
    """
    free = FreeBody(body.skeleton.proportions, body.shape)
    theta, poses = adjusted(free, seen, parameters, joints, on_frame)
    return free.body(theta), poses


def adjusted(
    free: FreeBody,
    seen: Sequence[SeenPose],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
    on_frame: OnPart = lambda _done, _count: None,
) -> tuple[FloatArray, tuple[Pose, ...]]:
    """The free numbers (k,) of the body and the poses that explain the data of all frames best.

    `joints` are those of the state; `on_frame` is told, in all iterations together, how many frames
    of how many are done.
    """
    prior, start = free.information, free.start
    joints = tuple(joint for joint in joints if joint not in CLAVICLES)
    theta, names = start.copy(), (*free.lengths, *free.surface)
    frames = list[SeenPose]()
    for each in seen:
        # What the shoulders of many frames have in common is the shape, not a movement.
        rotations = each.pose.rotations.copy()
        rotations[list(CLAVICLES)] = REST[list(CLAVICLES)]
        frames.append(dataclasses.replace(each, pose=Pose(each.pose.position, rotations)))
    steps = _STEP * np.eye(len(theta))
    for iteration in range(_ITERATIONS):
        A, b = prior.copy(), prior @ (start - theta)
        # The body, then each of its k numbers a step larger, then each a step smaller.
        bodies = [free.body(theta + step) for step in (np.zeros(len(theta)), *steps, *-steps)]
        normals = list[_Normal]()
        for frame in frames:
            on_frame(iteration * len(seen) + len(normals), _ITERATIONS * len(seen))
            normal = _normal_equations(frame, len(seen), names, bodies, parameters, joints)
            normals.append(normal)
            A += normal.C - normal.B.T @ np.linalg.solve(normal.A, normal.B)
            b += normal.c - normal.B.T @ np.linalg.solve(normal.A, normal.a)
        step = np.linalg.solve(A, b)
        theta = theta + step
        for i, (frame, normal) in enumerate(zip(frames, normals, strict=True)):
            delta: FloatArray = scipy.linalg.solve(normal.A, normal.a - normal.B @ step)
            frames[i] = dataclasses.replace(frame, pose=displaced(frame.pose, delta, joints))
    return theta, tuple(frame.pose for frame in frames)


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of one frame: pose block A, a; body block C, c; B between them."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    a: FloatArray
    c: FloatArray


def _normal_equations(
    seen: SeenPose,
    count: int,
    names: Sequence[str],
    bodies: list[BodyModel],
    parameters: TrackingParameters,
    joints: tuple[int, ...],
) -> _Normal:
    body, pose = bodies[0], seen.pose
    ends = standing.soles(seen.data, body, pose, count)
    surface = surface_residual(seen.data, body, body.frames(pose), Trust.of(parameters))
    n = 6 + 2 * len(joints)
    near = np.concatenate([_STEP * np.eye(n), -_STEP * np.eye(n)])
    frames = body.frames(displaced(pose, near, joints))
    rows = limit_rows(body, pose, parameters, joints)
    limits = gathered((rows,), body.frames(pose), columns_of(joints))
    A, a = limits.A + np.eye(n) / _POSE_SIGMA**2, limits.b
    for residual in standing.upright(pose, count, seen.upright):
        J = _differences(residual.predicted(frames))
        here = residual.predicted(body.frames(displaced(pose, np.zeros((1, n)), joints)))[0]
        A += (J / residual.variance) @ J.T
        a += (J / residual.variance) @ (residual.measured - here)
    J = _differences(surface.predicted(frames))
    S = -np.stack(
        [_change(surface, pose, names[i], bodies[1 + i :: len(names)]) for i in range(len(names))]
    )
    variance, e = surface.variance, surface.distance
    if len(ends.part):
        J = np.hstack([J, _differences(ends.predicted(body, frames))])
        soles = np.array([ends.predicted(each, each.frames(pose)) for each in bodies[1:]])
        S = np.hstack([S, _differences(soles)])
        variance = np.append(variance, ends.variance)
        e = np.append(e, ends.measured - ends.predicted(body, body.frames(pose)))
    weighted = J / variance
    return _Normal(
        A=A + weighted @ J.T,
        B=weighted @ S.T,
        C=(S / variance) @ S.T,
        a=a + weighted @ e,
        c=(S / variance) @ e,
    )


def _differences(predicted: FloatArray) -> FloatArray:
    n = len(predicted) // 2
    return (predicted[:n] - predicted[n:]) / (2.0 * _STEP)


def _change(surface: SurfaceResidual, pose: Pose, name: str, sides: list[BodyModel]) -> FloatArray:
    """Derivative (m,) of the signed distances by a number of the body, a step up and down.

    0 for the legs' length, which soles tell: of somebody who sits, no surface shows where the hips
    are, and the length makes up for hips in a wrong place.
    """
    if name == "leg_length_factor":
        return np.zeros(len(surface.data))
    more, less = (surface_distances(surface.data, body, pose) for body in sides)
    change = (more - less) / (2.0 * _STEP)
    return np.where(np.abs(change) < 3.0, change, 0.0)


def fitted_outline(body: BodyModel, seen: Sequence[tuple[Pose, tuple[EdgeMap, ...]]]) -> BodyShape:
    """The body's shape with the margins that the outlines of some frames show.

    Both sides of a limb are in the pictures, so a pose that is a little wrong shifts one side as
    far out as the other side in, and the margins come out right.
    """
    shape = body.shape
    names = list(dict.fromkeys(name for pair in CONTOUR_NAMES for name in pair))
    start = np.array([float(shape.values()[name]) for name in names])
    A, e = _rows(body, names, seen) if seen else (np.empty(0), np.empty(0))
    if not len(e):
        return shape
    prior = np.eye(len(names)) / _PRIOR_SIGMA**2
    left: FloatArray = e
    for _ in range(_ROUNDS):
        weight = 1.0 / ((1.0 + (left / _NOISE) ** 2) * _NOISE**2 * _TOGETHER)
        theta: FloatArray = scipy.linalg.solve(prior + (A.T * weight) @ A, (A.T * weight) @ e)
        left = e - A @ theta
    return shape_with(shape, names, start + theta)


def _rows(
    body: BodyModel, names: list[str], seen: Sequence[tuple[Pose, tuple[EdgeMap, ...]]]
) -> tuple[FloatArray, FloatArray]:
    """Shares (m, n) of the margins in the outlines' distances, and the distances (m,)."""
    columns = np.array([[names.index(name) for name in pair] for pair in CONTOUR_NAMES])
    shares, distances = [], []
    for pose, edges in seen:
        frames = body.frames(pose)
        placed = placed_cones(body, frames)
        found = contours_of(edges, body, frames)
        rotation, origin = placed["rotation"][found.cone], placed["origin"][found.cone]
        local = np.einsum("mji,mj->mi", rotation, found.point - origin)[:, :2] ** 2
        part = local / np.maximum(local.sum(axis=1, keepdims=True), 1e-12)
        A = np.zeros((len(part), len(names)))
        at = np.arange(len(part))
        for axis in range(2):
            np.add.at(A, (at, columns[found.cone, axis]), part[:, axis])
        shares.append(A)
        distances.append(found.distance)
    return np.concatenate(shares), np.concatenate(distances)


def fitted_offsets(setup: Setup, seen: Sequence[tuple[Pose, Cloud]]) -> BodyShape:
    """The body's shape with the offsets that the keypoints of some frames show.

    A detector's shoulders, hips and wrists are those of the people who labelled its training
    pictures. The offsets are constant in the frames of the parts and mirrored from side to side.
    What a pose could have done as well says nothing about an offset, which the prior then keeps.

    `seen`: frames that are tracked with the present shape, and their poses.
    """
    shape = setup.body.shape
    start = np.array([float(shape.values()[name]) for name in OFFSETS])
    moves = _offset_moves(setup.body)
    forward = np.array([name.endswith("_front") for name in OFFSETS])
    prior = 1.0 / np.where(forward, _FORWARD_SIGMA, _OFFSET_SIGMA) ** 2
    A, b = np.diag(prior), np.zeros(len(start))
    for pose, cloud in seen:
        observed = KeypointObservation(cloud.keypoints, setup.parameters.keypoint_sigma)
        fit = observed.fitted(setup.body, pose)
        if fit is not None:
            reduced, right = _offset_equations(setup, pose, cloud, fit, moves)
            A += reduced / _FRAMES_TOGETHER
            b += right / _FRAMES_TOGETHER
    return shape_with(shape, OFFSETS, start + np.linalg.solve(A, b))


def _offset_moves(body: BodyModel) -> dict[str, FloatArray]:
    """Derivatives (3, k) of the keypoints' places in their parts by the offsets."""
    before, step = keypoint_places(body), 0.01
    values = body.shape.values()
    changed = [
        keypoint_places(body.with_shape(body.shape.replaced(**{name: float(values[name]) + step})))
        for name in OFFSETS
    ]
    return {
        name: np.stack([(other[name].point - place.point) / step for other in changed], axis=1)
        for name, place in before.items()
    }


def _offset_equations(
    setup: Setup, pose: Pose, cloud: Cloud, fit: KeypointFit, moves: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Normal equations (k, k) and (k,) of one frame for the offsets, without its pose."""
    body, n = setup.body, setup.columns.n
    frames, outlines = body.frames(pose), silhouettes_of(cloud, setup.parameters.silhouette_sigma)
    beside = [each.rows(frames) for each in outlines.residuals(body, pose)]
    beside.append(limit_rows(body, pose, setup.parameters, setup.joints))
    others = gathered(beside, frames, setup.columns)
    A, a = others.A + np.eye(n) / _POSE_SIGMA**2, others.b
    B, C, c = np.zeros((n, len(OFFSETS))), np.zeros((len(OFFSETS),) * 2), np.zeros(len(OFFSETS))
    for residual in fit.residuals():
        rows = residual.rows(frames)
        H, nu, R = jacobian(rows, frames, setup.columns), rows["innovation"], rows["variance"]
        along = pixel_gradients(residual.rotation, residual.in_camera(frames), residual.focal)
        turned = along @ frames.rotations[residual.part]
        moved = np.array([moves[fit.seen.names[k]] for k in fit.counted[0].tolist()])
        S = (turned @ moved).reshape(-1, len(OFFSETS))
        weighted = H.T / R
        A, a = A + weighted @ H, a + weighted @ nu
        B, C = B + weighted @ S, C + (S.T / R) @ S
        c = c + (S.T / R) @ nu
    back = np.linalg.solve(A, np.column_stack([B, a]))
    return C - B.T @ back[:, :-1], c - B.T @ back[:, -1]
