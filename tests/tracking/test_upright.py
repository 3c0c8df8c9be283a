"""The static trial: what is asked of somebody who holds a T pose, and of nobody else."""

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import PartFrames, t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import HEAD
from stereotrack_core.tracking.residuals.standing import upright
from tests.tracking.scenes import POSES

BODY = body_model(AVERAGE)
JOINTS = (*THESIS_JOINTS, HEAD)


def turned(rotation_vector):
    """A T pose with the whole body turned, world."""
    dx = np.zeros(6 + 2 * len(JOINTS))
    dx[3:6] = rotation_vector
    return displaced(t_pose(np.zeros(3)), dx, JOINTS)


def error(pose):
    (row,) = upright(pose, 4)
    frames = BODY.frames(pose)
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    return row.measured - row.predicted(stacked)[0]


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5, np.pi])
def test_a_lean_is_the_same_whichever_way_somebody_faces(heading):
    assert np.allclose(error(turned([0.0, 0.0, heading])), [0.0, np.sin(np.radians(2.0))])


def test_a_lean_backwards_is_asked_to_come_forward():
    # Turning about the person's right lifts the front: the trunk leans back.
    back = error(turned([np.radians(3.0), 0.0, 0.0]))
    assert back[1] == pytest.approx(np.sin(np.radians(5.0)), abs=1e-3)
    assert abs(back[0]) < 1e-9


def test_all_frames_together_are_one_measurement():
    one, six = upright(turned([0.0] * 3), 1)[0], upright(turned([0.0] * 3), 6)[0]
    assert np.allclose(six.variance, 6 * one.variance)


def test_nothing_is_asked_of_other_poses():
    assert upright(turned([np.radians(20.0), 0.0, 0.0]), 4) == ()
    others = [pose for name, pose in POSES.items() if name != "t"]
    assert len(others) > 1
    assert all(upright(pose, 4) == () for pose in others)
