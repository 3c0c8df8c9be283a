"""The depth chain on recordings that this project did not make."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.match import STEPS, Matcher
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rectify import stereo_rectification
from stereotrack_core.depth.sources import disparity_range
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader


def clouds(folder, frames, **values):
    recording = open_recording(folder)
    chain = DepthChain(recording, DepthParameters().replaced(**values))
    with FrameReader(recording) as reader:
        chain.learn_background(reader, range(reader.frame_count))
        return recording, [chain.process(reader.frame_set(k)) for k in frames]


@pytest.mark.parametrize(("name", "region"), [("mesh-P2", "whole"), ("mesh-P4", "changed")])
def test_the_cloud_of_the_first_frame_lies_around_every_landmark(shared_recording, name, region):
    recording, (cloud,) = clouds(shared_recording(name), [0], match_region=region)
    assert not cloud.problems
    truth = recording.reference.points[list(recording.reference.frame).index(0)]
    distance, _ = KDTree(cloud.points).query(truth)
    assert dict(zip(LANDMARKS, distance < 0.15, strict=True)) == dict.fromkeys(LANDMARKS, True)
    # And the other way round: what is measured belongs to the body that the landmarks span.
    joints = np.concatenate([truth, truth[7:] * [1, 1, 0.5], truth[7:] * [1, 1, 0.15]])
    far, _ = KDTree(joints).query(cloud.points)
    assert (far < 0.45).mean() > 0.97


def test_the_motorcycle_has_its_true_ranges(shared_recording):
    folder = shared_recording("mesh-P2").parents[1] / "stereo" / "middlebury-motorcycle"
    if not folder.is_dir():
        pytest.skip("the recording middlebury-motorcycle is not beside this checkout")
    recording = open_recording(folder)
    parameters = DepthParameters().replaced(
        disparity_minimum=20, disparity_count=96, disparity_from_volume=False
    )
    left, right = (recording.cameras[f"N_{side}"] for side in ("left", "right"))
    rectification = stereo_rectification(left, right)
    assert rectification.left_map is None
    assert rectification.image_map is None
    geometry = rectification.geometry
    assert geometry.disparity_offset == pytest.approx(-31.086)
    with FrameReader(recording, colour=False) as reader:
        images = reader.frame_set(0).views["N"]
    searched = disparity_range(geometry, parameters)
    matcher = Matcher(parameters, searched)
    steps = matcher(images.left, images.image)
    disparity = np.where(steps > searched.invalid, steps / STEPS - matcher.bias, np.nan)
    truth = right_truth(np.load(folder / "disparity_left.npz")["disparity"])
    error = disparity - truth
    known = np.isfinite(error)
    assert np.isfinite(disparity).mean() > 0.7
    assert (np.abs(error[known]) > 2).mean() < 0.08
    assert np.median(np.abs(error[known])) < 0.25
    parallax = disparity - geometry.disparity_offset
    z = geometry.focal * geometry.baseline / parallax[known]
    assert 1.9 < np.percentile(z, 1) < np.percentile(z, 99) < 5.2


def right_truth(left_truth):
    """Disparity of the right image's pixels; the nearest surface where several meet."""
    truth = np.full(left_truth.shape, -np.inf)
    rows, columns = np.nonzero(np.isfinite(left_truth))
    d = left_truth[rows, columns]
    right = np.rint(columns - d).astype(int)
    seen = (right >= 0) & (right < left_truth.shape[1])
    np.maximum.at(truth, (rows[seen], right[seen]), d[seen])
    return np.where(np.isfinite(truth), truth, np.nan)


def test_real_depth_views_give_one_person(shared_recording):
    _, (cloud,) = clouds(shared_recording("rgbd-person-00"), [0])
    assert not cloud.problems
    assert len(np.unique(cloud.view)) == 4
    low, high = np.percentile(cloud.points, [0.5, 99.5], axis=0)
    assert (high - low < [0.7, 0.5, 0.8]).all()
    assert abs(np.median(cloud.points[:, :2], axis=0)).max() < 0.1
