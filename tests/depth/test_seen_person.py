"""Where the person is seen, in reduced images, and whether anything moves there."""

import numpy as np

from stereotrack_core.depth import seen_person
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.standing import moves
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

HERE = RigidTransform(np.eye(3), np.zeros(3))


def test_a_reduced_camera_sees_points_where_the_reduced_image_shows_them():
    matrix = np.array([[800.0, 0.0, 319.5], [0.0, 790.0, 239.5], [0.0, 0.0, 1.0]])
    camera = Camera("K", 640, 480, matrix, np.zeros(5), False, HERE)
    points = np.array([[0.1, 0.2, 2.0], [-0.3, 0.05, 1.5]])
    reduced = seen_person._reduced(camera, 4)
    expected = (camera.project(points) + 0.5) / 4 - 0.5  # pixels count from their centres
    np.testing.assert_allclose(reduced.project(points), expected)


def test_a_hand_moves_and_noise_does_not():
    geometry = DepthGeometry(100.0, 60.0, 45.0, 0.0, 0.0, 120, 90, HERE)
    anywhere = Volume(np.full(3, -np.inf), np.full(3, np.inf))

    def block_moves(side):
        front = np.zeros((90, 120), dtype=bool)
        front[40 : 40 + side, 50 : 50 + side] = True
        ranges = [np.full(side**2, 2.0, dtype=np.float32)] * 4
        return moves(geometry, anywhere, [front] * 4, lambda _: ranges)

    assert block_moves(6)  # 0.014 square metres, two metres away
    assert not block_moves(4)  # 0.006
