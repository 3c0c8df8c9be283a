import numpy as np
import pytest

from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.render import DepthCamera
from stereotrack_core.simulation.rig import SceneOptions
from tests.simulation.scenes import SMALL, scene

DEPTH = {"kind": "depth", "camera_height": 1.2}


@pytest.fixture
def camera(tmp_path):
    made = scene(motions=("t-pose",), **DEPTH)
    return made, DepthCamera(made.renderers["N"], SMALL["focal"], tmp_path / "N", (0, 1))


def test_ranges_err_as_the_square_of_the_range_and_are_rounded_to_disparities(camera):
    _, depth = camera
    ranges, person = depth.measured((), 0)
    known = np.isfinite(ranges)
    assert known.mean() > 0.5
    assert person.mean() < 0.06  # specks where the floor is seen at a grazing angle
    error = (ranges - depth.empty)[known] / depth.empty[known] ** 2
    assert abs(np.median(error)) < 0.001
    middle = np.percentile(np.abs(error), 68)
    assert 0.0010 < middle < 0.0025  # 1.4 mm at 1 m and the rounding
    steps = 43.5 / ranges[known] / 0.125
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-2)


def test_the_person_is_in_the_mask_and_casts_a_shadow(camera):
    made, depth = camera
    people, _ = made.people(0)
    ranges, person = depth.measured(people, 0)
    true = made.renderers["N"].depth(people) < depth.empty
    assert (person & true).sum() > 0.8 * true.sum()
    assert (person & ~true).mean() < 0.06
    without, _ = depth.measured((), 0)
    hidden = ~np.isfinite(ranges) & np.isfinite(without) & ~true
    columns = np.nonzero(hidden)[1].mean() - np.nonzero(true)[1].mean()
    assert hidden.sum() > 10
    assert columns > 0.0  # the projector is at the camera's left


def test_a_depth_recording_opens_with_depth_and_mask(tmp_path):
    options = SceneOptions(**(SMALL | DEPTH), stature=1.5)
    simulate(tmp_path / "made", Simulation(frames=2, views="N", options=options))
    recording = open_recording(tmp_path / "made")
    assert [view.kind for view in recording.views] == ["depth"]
    truth = recording.reference.points[0]
    assert 1.2 < truth[:, 2].max() < 1.5
    with FrameReader(recording, colour=False) as reader:
        images = reader.frame_set(1).views["N"]
    nearest = np.nanmin(np.where(images.mask, images.depth, np.nan))
    assert nearest == pytest.approx(2.8, abs=0.4)
