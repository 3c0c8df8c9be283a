"""Bundle adjustment: truth from disturbed beginnings, and the same as scipy's least squares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from stereotrack_core.calibrate.bundle import BundleCamera, adjusted
from stereotrack_core.calibrate.lens import BROWN, LENS_MODELS, Lens, projected
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from tests.calibrate.scenes import BENT, BOARD, HERE, SIZE, boards_before, looking_at


def disturbed(pose, rng):
    """A pose near another one."""
    rotation = rotation_from_vector(rng.normal(0, 0.02, 3)) @ pose.rotation
    return RigidTransform(rotation, pose.translation + rng.normal(0, 0.02, 3))


@pytest.fixture
def scene():
    """Two cameras with lens and pose to estimate, disturbed boards, and the true cameras."""
    rng = np.random.default_rng(3)
    lens = BENT.as_model(BROWN)
    poses = [looking_at((0, -2, 1.2)), looking_at((0.5, -2, 1.3))]
    true = [lens.camera(name, SIZE, pose) for name, pose in zip("ab", poses, strict=True)]
    boards = boards_before(true[0], 6, seed=4)
    cameras = []
    for i, camera in enumerate(true):
        seen = np.array([camera.project(board.apply(BOARD.corners)) for board in boards])
        seen += rng.normal(0, 0.1, seen.shape)
        seen[i, :7] = np.nan
        start = camera.camera_from_world if i == 0 else disturbed(camera.camera_from_world, rng)
        values = lens.values + [5, -5, 3, 3, *np.zeros(8)]
        cameras.append(
            BundleCamera(Lens(BROWN, values), start, np.arange(6), seen, BROWN.free, i > 0)
        )
    return cameras, [disturbed(board, rng) for board in boards], true


def test_it_finds_the_minimum_that_scipy_finds(scene):
    cameras, boards, _ = scene
    found = adjusted(cameras, boards, BOARD.corners)

    free = np.flatnonzero(BROWN.free)

    def residuals(x):
        parts = []
        placed = [
            RigidTransform(rotation_from_vector(v[:3]) @ board.rotation, board.translation + v[3:])
            for v, board in zip(x[22:].reshape(-1, 6), boards, strict=True)
        ]
        for i, camera in enumerate(cameras):
            values = camera.lens.values.copy()
            values[free] += x[8 * i : 8 * i + 8]
            pose = camera.camera_from_world
            if i:
                turn = rotation_from_vector(x[16:19])
                pose = RigidTransform(turn @ pose.rotation, pose.translation + x[19:22])
            for k, board in enumerate(placed):
                points = (pose @ board).apply(BOARD.corners)
                parts.append((camera.pixels[k] - projected(Lens(BROWN, values), points)[0]).ravel())
        return np.nan_to_num(np.concatenate(parts))

    slow = least_squares(residuals, np.zeros(22 + 36), x_scale="jac", xtol=1e-12, ftol=1e-12)
    count = sum(int(np.isfinite(camera.pixels[..., 0]).sum()) for camera in cameras)
    assert found.rms == pytest.approx(np.sqrt(2 * slow.cost / count), rel=1e-6)
    np.testing.assert_allclose(
        found.cameras[0].lens.values[:4], cameras[0].lens.values[:4] + slow.x[:4], atol=0.02
    )
    assert found.covariance.shape == (22, 22)
    normal = np.linalg.inv(slow.jac.T @ slow.jac)[:22, :22]
    variance = 2 * slow.cost / (2 * count - 58)
    mine = np.sqrt(np.diag(found.covariance))
    np.testing.assert_allclose(mine, np.sqrt(variance * np.diag(normal)), rtol=0.02)


def test_wrong_corners_hardly_count_under_a_robust_loss(scene):
    cameras, boards, true = scene
    cameras[1].pixels[2, 10:16] += 40.0
    plain = adjusted(cameras, boards, BOARD.corners)
    robust = adjusted(cameras, boards, BOARD.corners, loss_scale=0.5)

    def off(bundle):
        place = bundle.cameras[1].camera_from_world.inverse().translation
        return np.linalg.norm(place - true[1].position_world)

    assert off(robust) < 0.01
    assert off(robust) < 0.3 * off(plain)


_STEP = 1e-6


@pytest.mark.parametrize("model", LENS_MODELS.values(), ids=LENS_MODELS)
@settings(max_examples=30)
@given(seed=st.integers(0, 10_000))
def test_derivatives_agree_with_finite_differences(model, seed):
    rng = np.random.default_rng(seed)
    values = np.zeros(model.free.size)
    values[:4] = (400, 410, 320, 240)
    values[4:] = rng.normal(0, 0.05, values.size - 4)
    lens = Lens(model, values * model.free)
    points = rng.normal(size=(8, 3)) * (0.5, 0.5, 0.2) + (0, 0, 2)
    points[0, :2] = 0  # on the axis
    pixels, by_point, by_lens = projected(lens, points)
    camera = lens.camera("a", SIZE, HERE)
    if np.isinf(camera.widest_slope):
        np.testing.assert_allclose(camera.project(points), pixels, atol=1e-9)
    for axis in range(3):
        step = _STEP * np.eye(3)[axis]
        change = projected(lens, points + step)[0] - projected(lens, points - step)[0]
        np.testing.assert_allclose(by_point[:, :, axis], change / (2 * _STEP), atol=1e-5)
    for i in range(values.size):
        step = _STEP * np.eye(values.size)[i]
        more, less = (Lens(model, lens.values + sign * step) for sign in (1, -1))
        change = projected(more, points)[0] - projected(less, points)[0]
        np.testing.assert_allclose(by_lens[:, :, i], change / (2 * _STEP), atol=1e-5)
