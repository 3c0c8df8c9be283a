"""Left and right that were mixed up are noticed where geometry can tell, and nowhere else."""

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
from stereotrack_core.geometry.rotation import rotation_from_vector
from tests.annotation.scenes import cameras, clicks_of, moved_click

SIGMA = 2.0
CAMERAS = cameras()


def clicks(seed: int, *, frames: int = 1) -> list[Click]:
    """Clicks of a person who turns and moves the arms at random, in all views."""
    rng = np.random.default_rng(seed)
    body, points = body_model(AVERAGE), []
    for _ in range(frames):
        turn = rotation_from_vector(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
        pose = hanging_pose(np.array([*rng.uniform(-0.2, 0.2, 2), 0.9]), turn)
        bent = pose.rotations.copy()
        moving = slice(1, CLAVICLES[0])
        bent[moving] @= rotation_from_vector(rng.uniform(-0.6, 0.6, (10, 3)))[moving]
        points.append(NINE.places(body, body.frames(replace(pose, rotations=bent))))
    return clicks_of(np.array(points), CAMERAS, sigma=SIGMA, seed=seed)


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
        moved_click(one, (150.0, -60.0))
        if (one.camera, one.landmark) == ("N", "left_elbow")
        else one
        for one in good
    ]
    assert find_swaps(gross, CAMERAS, NINE.pairs()) == ()
