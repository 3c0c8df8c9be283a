import json

import numpy as np
import pytest

from stereotrack_core.program import main
from stereotrack_core.simulation.rig import SceneOptions, sensor
from tests.simulation.scenes import scene


@pytest.fixture(scope="module")
def made():
    return scene(views=("N", "O"))


def test_depth_of_the_floor_is_where_the_camera_says(made):
    """Rays of the calibrated camera meet the drawn floor at the drawn depth."""
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


def test_the_shadow_goes_with_the_person_and_leaves_the_empty_scene():
    plain, made = (scene(noise=0.0, shadow=share) for share in (0.0, 0.4))
    renderer, people = made.renderers["N_right"], made.people(0)[0]
    expected = plain.renderers["N_right"].background()
    for empty in (renderer.background(), renderer.picture((), 0)):
        np.testing.assert_array_equal(empty, expected)
    alone, both = (one.renderers["N_right"].picture(people, 0) for one in (plain, made))
    floor = renderer.depth(people) == renderer.depth(())
    assert (alone.astype(int) - both)[floor].max() > 20
    assert (both > alone).sum() == 0


def test_exposures_swing_out_of_step_within_ten_seconds():
    light = np.full((1, 1, 1), 100.0, np.float32)
    options = SceneOptions(exposure=0.3, noise=0.0, blur=0.0)
    right, left = (sensor(options, 0, name) for name in ("N_right", "O_right"))
    seen = np.array([[one.exposed(light, k)[0, 0] for k in range(200)] for one in (right, left)])
    np.testing.assert_allclose([seen[0].min(), seen[0].max()], [70, 130], atol=1)
    np.testing.assert_array_equal(seen[:, :100], seen[:, 100:])
    assert np.ptp(seen.astype(int), axis=0).max() > 5
    assert right.exposed(light, -1) == 100


@pytest.mark.slow
def test_fast_keeps_the_arms_in_exposure_and_shadow(tmp_path, capsys):
    film, run = str(tmp_path / "film"), str(tmp_path / "run.npz")
    light = ("--set", "exposure=0.3", "--set", "shadow=0.4")
    assert main(["simulate", film, "--person", "P4", "--frames", "60", *light]) == 0
    assert main(["track", film, "-o", run, "--preset", "fast"]) == 0
    capsys.readouterr()
    assert main(["evaluate", run, "--json"]) == 0
    errors = json.loads(capsys.readouterr().out)
    assert errors["not_tracked"] == 0
    assert errors["lost_percent"] < 3
    assert errors["measures"]["torso_cross"]["median"] < 5
    assert errors["measures"]["upper_arms"]["median"] < 10
