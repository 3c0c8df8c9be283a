"""Left and right that were mixed up are noticed where geometry can tell, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.doubts import find_swaps
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import CLAVICLES
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform

MATRIX = np.array([[520.0, 0, 319.5], [0, 520.0, 239.5], [0, 0, 1]])
DISTORTIONS = np.array([-0.2, 0.05, 0.001, -0.001, 0.0])
AZIMUTHS = {"N": 95.0, "O": 8.0, "S": 262.0, "W": 187.0}
SIGMA = 2.0


def looking_in(azimuth_deg: float) -> RigidTransform:
    """camera_from_world 2.8 m from the middle of the scene, 1.7 m high."""
    azimuth = np.radians(azimuth_deg)
    place = np.array([2.8 * np.cos(azimuth), 2.8 * np.sin(azimuth), 1.7])
    z = np.array([0.0, 0.0, 1.1]) - place
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    return RigidTransform(rotation, -rotation @ place)


CAMERAS = {
    name: Camera(name, 640, 480, MATRIX, DISTORTIONS, False, looking_in(azimuth))
    for name, azimuth in AZIMUTHS.items()
}


def clicks(seed: int, *, frames: int = 1, sigma: float = SIGMA) -> list[Click]:
    """Clicks of a person who turns and moves the arms at random, in all views."""
    rng = np.random.default_rng(seed)
    body = body_model(AVERAGE)
    found = []
    for frame in range(frames):
        turn = rotation_from_vector(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
        pose = hanging_pose(np.array([*rng.uniform(-0.2, 0.2, 2), 0.9]), turn)
        bent = pose.rotations.copy()
        moving = slice(1, CLAVICLES[0])
        bent[moving] @= rotation_from_vector(rng.uniform(-0.6, 0.6, (10, 3)))[moving]
        places = NINE.places(body, body.frames(replace(pose, rotations=bent)))
        for camera in CAMERAS.values():
            pixels = camera.project(places) + rng.normal(0, sigma, (9, 2))
            found += [
                Click(frame, camera.name, name, (float(x), float(y)))
                for name, (x, y) in zip(NINE.names, pixels, strict=True)
            ]
    return found


def mixed_up(good: list[Click], camera: str, pair: tuple[str, str], frame: int = 0) -> list[Click]:
    other = dict([pair, pair[::-1]])
    return [
        replace(click, landmark=other[click.landmark])
        if (click.camera, click.frame) == (camera, frame) and click.landmark in pair
        else click
        for click in good
    ]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("pair", NINE.pairs())
def test_a_view_that_was_mixed_up_is_found_among_four(camera, pair):
    wrong = mixed_up(clicks(3), camera, pair)
    found = find_swaps(wrong, CAMERAS, NINE.pairs())
    assert [(one.cameras, (one.first, one.second), one.certain) for one in found] == [
        ((camera,), pair, True)
    ]
    assert found[0].distance_after < 2 * SIGMA < found[0].distance


def test_good_clicks_are_left_alone():
    """A hundred poses with noise: none of four hundred pairs is called mixed up."""
    assert find_swaps(clicks(1, frames=100), CAMERAS, NINE.pairs()) == ()


def test_most_outliers_are_found_and_none_is_put_right_in_the_wrong_view():
    """Where the landmarks lie in one epipolar plane nothing can be told, and nothing is."""
    good = clicks(2, frames=100)
    rng = np.random.default_rng(0)
    wrong, made = good, {}
    for frame in range(100):
        pair = NINE.pairs()[rng.integers(4)]
        made[frame] = (str(rng.choice(list(CAMERAS))), pair)
        wrong = mixed_up(wrong, *made[frame], frame)
    found = find_swaps(wrong, CAMERAS, NINE.pairs())
    for one in found:
        camera, pair = made[one.frame]
        assert (one.first, one.second) == pair
        assert one.cameras == (camera,)
        assert one.certain
    assert len(found) >= 93


def test_of_two_views_nobody_knows_which_is_wrong():
    pair = ("left_elbow", "right_elbow")
    wrong = [one for one in mixed_up(clicks(3), "N", pair) if one.camera in "NO"]
    (found,) = find_swaps(wrong, CAMERAS, [pair])
    assert not found.certain
    assert len(found.cameras) == 1


def test_one_outlier_is_not_taken_for_a_swap():
    good = clicks(3)
    gross = [
        replace(one, position=(one.position[0] + 150.0, one.position[1] - 60.0))
        if (one.camera, one.landmark) == ("N", "left_elbow")
        else one
        for one in good
    ]
    assert find_swaps(gross, CAMERAS, NINE.pairs()) == ()
