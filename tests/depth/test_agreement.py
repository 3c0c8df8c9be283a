"""Views that are where the calibration says agree; others do not."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import contradicted_share
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.reader import FrameReader
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import pose_with_arms

WALL = 8.0
"""Metres behind the person at which every camera sees something else."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """One frame of four depth views: an arm points north, the other one west."""
    pose = pose_with_arms([0, 1, 0], [0, 1, 0], [-1, 0, 0], [-1, 0, 0], place=(0, 0, 0.95))
    folder = tmp_path_factory.mktemp("agreement") / "cones"
    return write_depth_recording(folder, body_model(AVERAGE), [pose])


def cloud_of(recording, views=None):
    parameters = DepthParameters().replaced(pixel_step=1, speckle_size=0)
    chain = DepthChain(recording, parameters, views=views)
    try:
        with FrameReader(recording, views=views, read_ahead=0) as reader:
            cloud = chain.process(reader.frame_set(0))
    finally:
        chain.close()
    depths = {
        name: dataclasses.replace(
            depth, range_z=np.where(depth.foreground, depth.range_z, np.float32(WALL))
        )
        for name, depth in cloud.depths.items()
    }
    return dataclasses.replace(cloud, depths=depths)


def exchanged(recording, one, other):
    cameras = dict(recording.cameras)
    cameras[one], cameras[other] = cameras[other], cameras[one]
    return dataclasses.replace(recording, cameras=cameras)


def moved(recording, view, by):
    camera = recording.cameras[view]
    world = camera.world_from_camera
    place = RigidTransform(world.rotation, world.translation + by)
    camera = dataclasses.replace(camera, camera_from_world=place.inverse())
    return dataclasses.replace(recording, cameras={**recording.cameras, view: camera})


def test_sound_views_see_through_nothing_that_another_one_measures(recording):
    assert contradicted_share(cloud_of(recording)) < 0.01


def test_views_that_are_exchanged_or_moved_see_through_each_other_s_points(recording):
    assert contradicted_share(cloud_of(exchanged(recording, "N", "O"))) > 0.05
    assert contradicted_share(cloud_of(moved(recording, "N", [0.3, 0.0, 0.0]))) > 0.05


def test_what_is_hidden_or_not_measured_proves_nothing(recording):
    cloud = cloud_of(exchanged(recording, "N", "O"))
    for ranges in (1.0, np.nan):
        covered = {
            name: dataclasses.replace(
                depth, range_z=np.where(depth.foreground, depth.range_z, np.float32(ranges))
            )
            for name, depth in cloud.depths.items()
        }
        assert contradicted_share(dataclasses.replace(cloud, depths=covered)) == 0.0
