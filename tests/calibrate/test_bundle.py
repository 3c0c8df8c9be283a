"""Bundle adjustment: truth from disturbed beginnings, and the same as scipy's least squares."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from stereotrack_core.calibrate.bundle import BundleCamera, adjusted
from stereotrack_core.calibrate.lens import BROWN, Lens, projected
from stereotrack_core.calibrate.world_checks import place_sigmas
from stereotrack_core.errors import Cancelled
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from tests.calibrate.scenes import BENT, BOARD, SIZE, boards_before, disturbed, looking_at

_NOTHING = np.zeros(12, dtype=bool)


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
    assert found.converged

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


def test_errors_are_as_large_as_their_covariance_says(scene):
    cameras, boards, true = scene
    found = adjusted(cameras, boards, BOARD.corners)
    for i, camera in enumerate(true):
        sigma = np.sqrt(np.diag(found.covariance_of(i)))[:4]
        off = found.cameras[i].lens.values[:4] - [
            *camera.matrix[[0, 1], [0, 1]], *camera.matrix[:2, 2]
        ]  # fmt: skip
        assert (np.abs(off) < 5 * sigma).all()


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


def test_without_unknowns_of_cameras_the_boards_are_placed(scene):
    cameras, boards, true = scene
    fixed = [
        BundleCamera(BENT.as_model(BROWN), own.camera_from_world, one.boards, one.pixels, _NOTHING,
                     pose_free=False)
        for one, own in zip(cameras, true, strict=True)
    ]  # fmt: skip
    found = adjusted(fixed, boards, BOARD.corners)
    assert found.rms < 0.16
    assert found.covariance.shape == (0, 0)


def test_it_can_be_stopped(scene):
    cameras, boards, _ = scene
    with pytest.raises(Cancelled):
        adjusted(cameras, boards, BOARD.corners, cancelled=lambda: True)


@pytest.mark.filterwarnings("error")
def test_what_is_not_determined_is_infinite_without_a_word_of_numpy(scene):
    cameras, boards, _ = scene
    few = [np.where(np.arange(54)[:, None] < 3, one.pixels[:1], np.nan) for one in cameras]
    seen = [
        replace(one, boards=np.array([0]), pixels=pixels)
        for one, pixels in zip(cameras, few, strict=True)
    ]  # three corners of one board, and two lenses to estimate
    found = adjusted(seen, boards[:1], BOARD.corners)
    assert place_sigmas(found) == ((0.0, np.inf), (0.0, np.inf))
