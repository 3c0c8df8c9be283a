"""Bundle adjustment: all cameras and all boards at once, by Levenberg and Marquardt's method.

Each board's six unknowns are eliminated from the normal equations (Schur complement; Triggs et al.,
Bundle Adjustment, 2000, section 6.1). What is left has the size of the cameras' unknowns, and its
inverse is their covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.calibrate.lens import Lens, projected
from stereotrack_core.geometry.rotation import rotation_from_vector, skew
from stereotrack_core.geometry.transform import RigidTransform

_ROUNDS = 100
_STILL = 1e-10  # relative change of the cost that ends the search
_GIVE_UP = 1e12  # damping at which no step can help
_BEHIND = 1e-3  # metres in front of the camera from which a corner can be projected
_ROUNDING = 1e-13  # share of an unknown's information that rounding leaves of it
_FAR_OFF = 1e3  # pixels that a corner behind the camera counts as an error


@dataclass(frozen=True, eq=False)
class BundleCamera:
    """A camera with what is known at first, what is estimated and what it saw."""

    lens: Lens
    camera_from_world: RigidTransform
    boards: IntArray  # (F,); numbers of the boards seen, with `pixels` (F, n, 2), NaN where unseen
    pixels: FloatArray
    lens_free: BoolArray  # lens values that are estimated
    pose_free: bool

    @property
    def unknowns(self) -> int:
        """Number of values that are estimated."""
        return int(self.lens_free.sum()) + 6 * self.pose_free


@dataclass(frozen=True, eq=False)
class Bundle:
    """Cameras, boards and errors after the adjustment."""

    cameras: tuple[BundleCamera, ...]
    boards: tuple[RigidTransform, ...]  # world_from_board
    errors: tuple[FloatArray, ...]  # (F, n, 2) pixels, picture minus projection; NaN if unseen
    covariance: FloatArray
    """(m, m) of the estimated values, camera by camera: the lens's free ones, then rotation vector
    (radians) and translation (metres) in the camera's frame. Infinite where they are not
    determined. The scale follows from the errors."""

    @property
    def rms(self) -> float:
        """Root mean square distance of all corners in pixels."""
        return rms_of(np.concatenate([one.reshape(-1, 2) for one in self.errors]))

    def covariance_of(self, camera: int) -> FloatArray:
        """The part of the covariance that belongs to one camera."""
        first = sum(one.unknowns for one in self.cameras[:camera])
        own = slice(first, first + self.cameras[camera].unknowns)
        return self.covariance[own, own]


def rms_of(errors: FloatArray) -> float:
    """Root mean square length of errors (..., 2) in pixels, unseen ones left out; NaN of none."""
    squares = np.square(errors).sum(axis=-1)
    seen = np.isfinite(squares)
    return float(np.sqrt(squares[seen].mean())) if seen.any() else float("nan")


def adjusted(
    cameras: Sequence[BundleCamera],
    boards: Sequence[RigidTransform],
    corners: FloatArray,
    *,
    loss_scale: float | None = None,
    rounds: int = _ROUNDS,
) -> Bundle:
    """Cameras and boards (world_from_board) with the least sum of squared errors.

    `corners` (n, 3) are in the boards' frames; from `loss_scale` pixels errors count linearly
    (Huber).
    """
    state = _State(tuple(cameras), np.array([b.rotation for b in boards]).reshape(-1, 3, 3),
                   np.array([b.translation for b in boards]).reshape(-1, 3))  # fmt: skip
    linear = _linearised(state, corners, loss_scale)
    damping = 1e-4
    for _ in range(rounds):
        step = linear.step(damping)
        moved = None if step is None else state.moved(*step)
        cost = np.inf if moved is None else _cost(moved, corners, loss_scale)
        if moved is None or not cost < linear.cost:
            damping *= 10.0
            still = linear.cost == 0 or cost - linear.cost <= _STILL * linear.cost
            if still or damping > _GIVE_UP:
                break
            continue
        gain = linear.cost - cost
        state, damping = moved, max(damping * 0.1, 1e-12)
        linear = _linearised(state, corners, loss_scale)
        if gain <= _STILL * cost:
            break
    found = tuple(map(RigidTransform, state.rotations, state.translations))
    errors = tuple(_errors(state, c, corners)[0] for c in range(len(cameras)))
    return Bundle(state.cameras, found, errors, _covariance(linear, errors))


@dataclass(frozen=True, eq=False)
class _State:
    cameras: tuple[BundleCamera, ...]
    rotations: FloatArray  # (B, 3, 3)
    translations: FloatArray  # (B, 3)

    def moved(self, by_camera: FloatArray, by_board: FloatArray) -> _State:
        cameras, first = [], 0
        for camera in self.cameras:
            own = by_camera[first : first + camera.unknowns]
            first += camera.unknowns
            values = camera.lens.values.copy()
            values[camera.lens_free] += own[: camera.lens_free.sum()]
            pose = camera.camera_from_world
            if camera.pose_free:
                turn = rotation_from_vector(own[-6:-3])
                pose = RigidTransform(turn @ pose.rotation, pose.translation + own[-3:])
            lens = Lens(camera.lens.model, values)
            cameras.append(replace(camera, lens=lens, camera_from_world=pose))
        turns = rotation_from_vector(by_board[:, :3])
        return _State(tuple(cameras), turns @ self.rotations, self.translations + by_board[:, 3:])


@dataclass(frozen=True, eq=False)
class _Linear:
    """Normal equations: cameras (m, m), boards (B, 6, 6), both (B, m, 6), and their right sides."""

    of_cameras: FloatArray
    of_boards: FloatArray
    mixed: FloatArray
    right_cameras: FloatArray
    right_boards: FloatArray
    cost: float

    def step(self, damping: float) -> tuple[FloatArray, FloatArray] | None:
        """Changes of the cameras (m,) and the boards (B, 6); None where there are none."""
        eye = np.arange(6)
        boards = self.of_boards.copy()
        boards[:, eye, eye] *= 1.0 + damping
        boards[:, eye, eye] += 1e-12
        cameras = self.of_cameras + np.diag(damping * np.diag(self.of_cameras) + 1e-12)
        try:
            inverse = np.linalg.inv(boards)
            reduced = self.mixed @ inverse
            right = self.right_cameras - np.einsum("bmi,bi->m", reduced, self.right_boards)
            own = np.linalg.solve(cameras - _summed(reduced, self.mixed), right)
        except np.linalg.LinAlgError:
            return None
        back = self.right_boards - np.einsum("bmi,m->bi", self.mixed, own)
        return own, np.einsum("bij,bj->bi", inverse, back)


def _summed(a: FloatArray, b: FloatArray) -> FloatArray:
    """Sum (m, m) over boards of a b^T, both (B, m, 6)."""
    boards, count, _ = a.shape
    flat = [one.transpose(1, 0, 2).reshape(count, 6 * boards) for one in (a, b)]
    return np.asarray(flat[0] @ flat[1].T)


def _errors(
    state: _State, number: int, corners: FloatArray
) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray, FloatArray]]:
    """Errors (F, n, 2) of a camera, and what their derivatives are made of."""
    camera = state.cameras[number]
    pose = camera.camera_from_world
    turned = np.einsum("fij,nj->fni", state.rotations[camera.boards], corners)
    world = turned + state.translations[camera.boards][:, None]
    rotated = world @ pose.rotation.T
    points = rotated + pose.translation
    flat = points.reshape(-1, 3)
    behind = ~(flat[:, 2] > _BEHIND)
    safe = np.where(behind[:, None], [0.0, 0.0, 1.0], flat)
    pixels, by_point, by_lens = projected(camera.lens, safe)
    error = camera.pixels - pixels.reshape(*points.shape[:2], 2)
    hidden = behind.reshape(points.shape[:2]) & np.isfinite(camera.pixels[..., 0])
    error[hidden] = _FAR_OFF
    by_point[behind], by_lens[behind] = 0.0, 0.0
    return error, (by_point, by_lens, rotated, turned)


def _weights_and_cost(error: FloatArray, scale: float | None) -> tuple[FloatArray, float]:
    """Weights (F, n) of corners, 0 where unseen, and the cost."""
    squares = np.square(error).sum(axis=-1)
    seen = np.isfinite(squares)
    squares = np.where(seen, squares, 0.0)
    if scale is None:
        return seen.astype(np.float64), float(squares.sum())
    length = np.sqrt(squares)
    far = length > scale
    weight = np.where(far, scale / np.maximum(length, scale), 1.0)
    cost = np.where(far, 2.0 * scale * length - scale * scale, squares).sum()
    return weight * seen, float(cost)


def _cost(state: _State, corners: FloatArray, scale: float | None) -> float:
    numbers = range(len(state.cameras))
    costs = [_weights_and_cost(_errors(state, c, corners)[0], scale)[1] for c in numbers]
    total = float(sum(costs))
    return total if np.isfinite(total) else float("inf")


def _linearised(state: _State, corners: FloatArray, scale: float | None) -> _Linear:
    unknowns = sum(camera.unknowns for camera in state.cameras)
    boards = len(state.rotations)
    of_cameras, right_cameras = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    of_boards, right_boards = np.zeros((boards, 6, 6)), np.zeros((boards, 6))
    mixed = np.zeros((boards, unknowns, 6))
    first, cost = 0, 0.0
    for number, camera in enumerate(state.cameras):
        error, parts = _errors(state, number, corners)
        weight, own_cost = _weights_and_cost(error, scale)
        cost += own_cost
        frames = len(camera.boards)
        root = np.repeat(np.sqrt(weight).reshape(frames, -1), 2, axis=1)[..., None]
        by_camera, by_board = (root * one for one in _jacobians(camera, parts, frames))
        residual = root[..., 0] * np.nan_to_num(error.reshape(frames, -1))
        across = by_board.transpose(0, 2, 1)
        np.add.at(of_boards, camera.boards, across @ by_board)
        np.add.at(right_boards, camera.boards, (across @ residual[..., None])[..., 0])
        own = slice(first, first + camera.unknowns)
        first += camera.unknowns
        np.add.at(mixed[:, own], camera.boards, by_camera.transpose(0, 2, 1) @ by_board)
        flat = by_camera.reshape(residual.size, camera.unknowns)
        of_cameras[own, own] = flat.T @ flat
        right_cameras[own] = flat.T @ residual.ravel()
    return _Linear(of_cameras, of_boards, mixed, right_cameras, right_boards, cost)


def _jacobians(
    camera: BundleCamera, parts: tuple[FloatArray, ...], frames: int
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of pixels by the camera's unknowns (F, 2n, m) and by the board's (F, 2n, 6)."""
    by_point, by_lens, rotated, turned = parts
    count = by_point.shape[0]
    by_pose = np.concatenate([-by_point @ skew(rotated.reshape(-1, 3)), by_point], axis=2)
    in_world = by_point @ camera.camera_from_world.rotation
    by_board = np.concatenate([-in_world @ skew(turned.reshape(-1, 3)), in_world], axis=2)
    own = by_lens[:, :, camera.lens_free]
    if camera.pose_free:
        own = np.concatenate([own, by_pose], axis=2)
    rows = 2 * count // max(frames, 1)
    return own.reshape(frames, rows, camera.unknowns), by_board.reshape(frames, rows, 6)


def _covariance(linear: _Linear, errors: Sequence[FloatArray]) -> FloatArray:
    """Covariance (m, m) of the cameras' unknowns with the boards' taken into account."""
    count = sum(int(np.isfinite(one).sum()) for one in errors)
    freedom = count - linear.of_cameras.shape[0] - 6 * len(linear.of_boards)
    squares = sum(float(np.nansum(np.square(one))) for one in errors)
    variance = squares / freedom if freedom > 0 else np.inf
    unknowns = linear.of_cameras.shape[0]
    covariance: FloatArray = np.full((unknowns, unknowns), np.inf)
    if not np.isfinite(variance):
        return covariance
    try:
        inverse = np.linalg.pinv(linear.of_boards, hermitian=True)
        normal = linear.of_cameras - _summed(linear.mixed @ inverse, linear.mixed)
        # what is left by rounding says nothing of an unknown that the boards can make up for
        known = np.diag(normal) > _ROUNDING * np.diag(linear.of_cameras)
        scale = np.sqrt(np.diag(normal)[known])
        own = normal[np.ix_(known, known)] / scale / scale[:, None]
        values, vectors = np.linalg.eigh(own)
    except np.linalg.LinAlgError:
        return covariance
    spread = 1.0 / np.maximum(values, _ROUNDING)
    covariance[np.ix_(known, known)] = (
        variance * ((vectors * spread) @ vectors.T) / scale / scale[:, None]
    )
    return covariance
