import numpy as np
import pytest

from tests.simulation.scenes import scene


@pytest.fixture(scope="module", params=["straight", "distorted and askew"])
def made(request):
    bent = request.param != "straight"
    return scene(views=("N", "O"), distorted=bent, askew=bent)


def test_depth_of_the_floor_is_where_the_camera_says(made):
    """Rays of the calibrated camera meet the drawn floor at the drawn depth, also when bent."""
    for name, camera in made.cameras.items():
        depth = made.renderers[name].depth([])
        rows, columns = np.mgrid[70:119:7, 20:140:9]
        samples = np.stack([columns, rows], axis=-1) - 0.25
        rays = camera.rays_world(samples)
        distance = -camera.position_world[2] / rays[..., 2]
        points = camera.position_world + distance[..., None] * rays
        expected = camera.camera_from_world.apply(points)[..., 2]
        on_floor = np.abs(points[..., :2]).max(axis=-1) < 2.0
        got = depth[rows, columns]
        np.testing.assert_allclose(got[on_floor], expected[on_floor], rtol=2e-3)
        assert on_floor.sum() > 20


def test_person_is_seen_where_the_landmarks_project(made):
    people, points = made.people(0)
    for name, camera in made.cameras.items():
        empty, seen = (made.renderers[name].depth(who) for who in ([], people))
        columns, rows = np.rint(camera.project(points[[0, 1, 6, 7, 8]])).astype(int).T
        assert (seen < empty)[rows, columns].all()


def test_second_person_appears_behind_the_first_now_and_then():
    made = scene(frames=60, second_person=True)
    crowd = [len(made.people(frame)[0]) for frame in range(60)]
    assert set(crowd) == {1, 2}
