import numpy as np
import pytest

from stereotrack_core.simulation.rig import SceneOptions, sensor

LIGHT = np.full((60, 80, 1), 100.0, np.float32)


def test_left_camera_is_brighter_by_the_gain():
    options = SceneOptions(gain_difference=0.04, noise=0.0)
    left = sensor(options, 0, "N_left").exposed(LIGHT, 0)
    right = sensor(options, 0, "N_right").exposed(LIGHT, 0)
    assert (left == 104).all()
    assert (right == 100).all()


def test_noise_has_the_deviation_that_was_asked_for():
    picture = sensor(SceneOptions(noise=2.5), 0, "N_right").exposed(LIGHT, 0)
    assert picture.astype(float).std() == pytest.approx(2.5, rel=0.05)


def test_noise_repeats_for_the_same_frame_and_differs_otherwise():
    def picture(camera, frame, seed=0):
        return sensor(SceneOptions(), seed, camera).exposed(LIGHT, frame)

    assert (picture("N_right", 3) == picture("N_right", 3)).all()
    for other in (picture("N_right", 4), picture("N_left", 3), picture("N_right", 3, 1)):
        assert (picture("N_right", 3).astype(int) - np.median(other) != 0).any()
        assert not (picture("N_right", 3) == other).all()


def test_blur_spreads_a_point_over_its_neighbours():
    point = np.zeros((21, 21, 1), np.float32)
    point[10, 10] = 200
    picture = sensor(SceneOptions(noise=0.0, blur=0.6), 0, "N_right").exposed(point, 0)
    assert 60 < picture[10, 10] < 120
    assert 10 < picture[10, 11] < 50


def test_every_camera_sees_colours_differently():
    light = np.tile(LIGHT, 3)
    options = SceneOptions(colour=True, noise=0.0, gain_difference=0.0)
    means = {c: sensor(options, 0, c).exposed(np.ones((4, 4, 3), np.float32), 0).shape
             for c in ("N_left", "O_left")}  # fmt: skip
    assert set(means.values()) == {(4, 4, 3)}
    responses = [sensor(options, 0, c).response for c in ("N_left", "N_right", "O_left")]
    assert not np.allclose(responses[0], responses[1])
    assert not np.allclose(responses[0], responses[2])
    assert sensor(options, 0, "O_left").exposed(light, 0).ndim == 3
