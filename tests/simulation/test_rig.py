import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.simulation.rig import COMPASS, SceneOptions, stereo_rig, view_names

ALL = tuple("NOSW")


@pytest.mark.parametrize("view", ALL)
def test_cameras_stand_where_their_names_say_and_see_the_middle(view):
    camera = stereo_rig(ALL, SceneOptions(), 5)[f"{view}_right"]
    place = camera.position_world
    assert place[:2] @ np.array(COMPASS[view]) == pytest.approx(3.0, abs=0.15)
    assert place[2] == pytest.approx(2.1, abs=0.1)
    pixel = camera.project(np.array([0.0, 0.0, 1.0]))
    assert np.abs(pixel - [319.5, 239.5]).max() < 20
    up = camera.project(np.array([0.0, 0.0, 1.5]))
    assert up[1] < pixel[1]


def test_a_view_stands_at_the_same_place_whichever_others_there_are():
    alone = stereo_rig(("S",), SceneOptions(distorted=True, askew=True), 3)["S_left"]
    among = stereo_rig(ALL, SceneOptions(distorted=True, askew=True), 3)["S_left"]
    np.testing.assert_array_equal(alone.matrix, among.matrix)
    np.testing.assert_array_equal(
        alone.camera_from_world.rotation, among.camera_from_world.rotation
    )


@pytest.mark.parametrize("text", ["", "X", "NN", "North"])
def test_wrong_views_are_refused(text):
    with pytest.raises(InputError, match="--views"):
        view_names(text)
