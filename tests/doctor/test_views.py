"""Views whose cameras are elsewhere than the calibration says contradict the others."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.doctor.views import check_views, measured_views, misfits
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.reader import FrameReader
from tests.tracking.recordings import VIEWS, write_depth_recording
from tests.tracking.scenes import pose_with_arms

WALL = 8.0
"""Metres behind the person at which every camera sees something else."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Two frames of four depth views of a person who moves an arm."""
    poses = [
        pose_with_arms([0, 1, 0], [0, 1, 0], [-1, 0, 0], [-1, 0, 0], place=(0, 0, 0.95)),
        pose_with_arms([0, 0, 1], [0, 0, 1], [-1, 0, 0], [-1, 0, 0], place=(0.1, 0, 0.95)),
    ]
    folder = tmp_path_factory.mktemp("doctor") / "cones"
    return write_depth_recording(folder, body_model(AVERAGE), poses)


def measured(recording, views=VIEWS):
    with FrameReader(recording, read_ahead=0) as reader:
        given = DepthParameters().replaced(pixel_step=1, speckle_size=0)
        instants, places = measured_views(recording, reader, views, given)
    behind = [
        {
            name: dataclasses.replace(
                one,
                depth=dataclasses.replace(
                    one.depth,
                    range_z=np.where(one.depth.foreground, one.depth.range_z, np.float32(WALL)),
                ),
            )
            for name, one in seen.items()
        }
        for seen in instants
    ]
    return behind, places


@pytest.fixture(scope="module")
def sound(recording):
    return measured(recording)


def checked(recording):
    return list(check_views(recording, *measured(recording)))


def moved(recording, view, turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
    name = recording.view(view).image.camera
    world = recording.cameras[name].world_from_camera
    place = RigidTransform(
        rotation_from_vector(np.array(turn)) @ world.rotation, world.translation + shift
    )
    camera = dataclasses.replace(recording.cameras[name], camera_from_world=place.inverse())
    return dataclasses.replace(recording, cameras={**recording.cameras, name: camera})


def test_sound_views_have_no_findings(recording, sound):
    assert misfits(*sound).mean() < 0.01
    assert not list(check_views(recording, *sound))


def test_views_that_are_exchanged_are_named(recording):
    cameras = dict(recording.cameras)
    one, other = (recording.view(name).image.camera for name in "NO")
    cameras[one], cameras[other] = cameras[other], cameras[one]
    [finding] = checked(dataclasses.replace(recording, cameras=cameras))
    assert finding.severity == "error"
    assert finding.where == "views N, O"
    assert "they are exchanged" in finding.what


def test_a_view_that_is_displaced_is_named_and_measured(recording):
    [finding] = checked(moved(recording, "S", shift=(0.1, 0.0, 0.0)))
    assert finding.severity == "error"
    assert finding.where == "view S"
    assert "displaced" in finding.what or "turned" in finding.what


def test_of_two_views_it_is_not_told_which_is_wrong(recording):
    wrong = moved(recording, "O", shift=(0.0, 0.0, 0.15))
    instants, places = measured(wrong, ("N", "O"))
    [finding] = check_views(wrong, instants, places)
    assert finding.where == "views N, O"
    assert "cannot be told" in finding.what
    assert "of view O the camera is" in finding.what
    assert finding.correction is None


def test_a_view_without_the_person_is_told(recording, sound):
    instants, places = sound
    without = [{name: one for name, one in seen.items() if name != "W"} for seen in instants]
    [finding] = check_views(recording, without, places)
    assert finding.where == "view W"
    assert "nothing of the person" in finding.what
