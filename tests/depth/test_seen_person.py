"""Where the person is seen, in reduced images, and whether anything moves there."""

from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.depth import seen_person
from stereotrack_core.depth.chain import source_of
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.seen_person import SeenPerson
from stereotrack_core.depth.standing import _best_plane, moves
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.reader import ViewImages
from tests.depth.recordings import depth_recording

HERE = RigidTransform(np.eye(3), np.zeros(3))


def test_a_reduced_camera_sees_points_where_the_reduced_image_shows_them():
    matrix = np.array([[800.0, 0.0, 319.5], [0.0, 790.0, 239.5], [0.0, 0.0, 1.0]])
    camera = Camera("K", 640, 480, matrix, np.zeros(5), False, HERE)
    points = np.array([[0.1, 0.2, 2.0], [-0.3, 0.05, 1.5]])
    reduced = seen_person._reduced(camera, 4)
    expected = (camera.project(points) + 0.5) / 4 - 0.5  # pixels count from their centres
    np.testing.assert_allclose(reduced.project(points), expected)


def test_a_person_is_what_is_nearer_than_usual_by_a_pixel_of_disparity():
    recording = depth_recording()
    (view,), wall = recording.views, 4.0
    camera = recording.reference_camera(view)
    source = source_of(recording, view, DepthParameters())

    class Recorded:
        frame_count = 10
        nearer = 0.0  # pixels of disparity

        def background(self, _view):
            return None

        def frame_set(self, k):
            depth = np.full((camera.height, camera.width), wall, np.float32)
            depth[100:140, 20 * k : 20 * k + 20] = source.ranges(
                source.disparity_of(np.float32(wall)) + np.float32(self.nearer)
            )
            grey = np.zeros(depth.shape, np.uint8)
            return SimpleNamespace(views={view.name: ViewImages(image=grey, depth=depth)})

    def seen(nearer):
        pictures = Recorded()
        pictures.nearer = nearer
        (frames,) = SeenPerson(recording, DepthParameters(), pictures, (view.name,)).seen
        return [len(points) > 0 for points in frames]

    assert seen(1.4) == [True] * 10
    assert seen(0.7) == [False] * 10


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


def test_the_plane_with_most_area_near_it_is_found():
    rng = np.random.default_rng(0)
    normal, offset = np.array([0.6, 0.0, 0.8]), -1.7
    wall = rng.uniform(-1.0, 1.0, (300, 3))
    wall += (offset - wall @ normal)[:, None] * normal
    points = np.concatenate([wall, rng.uniform(-3.0, 3.0, (400, 3))])
    found, at = _best_plane(points, np.ones(len(points)), rng)
    np.testing.assert_allclose(np.sign(at * offset) * found, normal, atol=1e-9)
    assert abs(at) == pytest.approx(1.7)
