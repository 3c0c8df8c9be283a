import numpy as np
import pytest

from stereotrack_core.simulation.rig import COMPASS, SceneOptions, rig

ALL = tuple("NOSW")


@pytest.mark.parametrize("view", ALL)
def test_cameras_stand_where_their_names_say_and_see_the_middle(view):
    camera = rig(ALL, SceneOptions(), 5)[f"{view}_right"]
    place = camera.position_world
    assert place[:2] @ np.array(COMPASS[view]) == pytest.approx(3.0, abs=0.15)
    assert place[2] == pytest.approx(2.1, abs=0.1)
    pixel = camera.project(np.array([0.0, 0.0, 1.0]))
    assert np.abs(pixel - [319.5, 239.5]).max() < 20
    up = camera.project(np.array([0.0, 0.0, 1.5]))
    assert up[1] < pixel[1]
