from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.volume import settled
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from tests.depth.recordings import BOX, MemoryReader, depth_recording, frame_set, stereo_recording
from tests.depth.scenes import camera

USUAL = DepthParameters()
AWAY = np.array([12.0, -7.0, 3.0])


def away(recording):
    """The same recording with the world's origin elsewhere."""
    shift = RigidTransform(np.eye(3), -AWAY)
    cameras = {
        name: replace(one, camera_from_world=one.camera_from_world @ shift)
        for name, one in recording.cameras.items()
    }
    return replace(recording, cameras=cameras)


def passing(recording, empty=False):
    """The box goes from one side to the other."""
    sets = [frame_set(recording, k, shift=s) for k, s in enumerate(np.linspace(-0.6, 0.6, 8))]
    return MemoryReader(recording, sets, empty)


def names(recording):
    return [view.name for view in recording.views]


@pytest.mark.parametrize(
    "recording", [stereo_recording(), depth_recording(), depth_recording(mask=True)]
)
def test_the_volume_is_put_where_somebody_is_seen(recording):
    reader = passing(recording)
    assert settled(recording, USUAL, reader, names(recording)) == USUAL
    found = settled(away(recording), USUAL, reader, names(recording))
    volume = Volume.of(found)
    for shift in (-0.6, 0.6):
        corners = np.array([BOX[:, 0], BOX[:, 1]]) + AWAY + [shift, 0.0, 0.0]
        assert volume.contains(corners).all()
    assert (volume.high - volume.low >= np.array([3.6, 3.6, 2.4]) - 1e-6).all()
    assert (np.abs(volume.corners().mean(axis=0) - AWAY - BOX.mean(axis=1)) < 0.5).all()


def test_the_empty_scene_tells_somebody_who_does_not_move():
    recording = stereo_recording()
    still = MemoryReader(recording, [frame_set(recording, k) for k in range(3)], empty=True)
    volume = Volume.of(settled(away(recording), USUAL, still, names(recording)))
    assert volume.contains(np.array([BOX[:, 0], BOX[:, 1]]) + AWAY).all()
    unknown = MemoryReader(recording, [frame_set(recording, k) for k in range(3)], empty=False)
    assert settled(away(recording), USUAL, unknown, names(recording)) == USUAL


def test_values_that_somebody_has_changed_stay():
    recording = depth_recording()
    for changed in ({"volume_bottom": 0.2}, {"volume_from_recording": False}):
        p = USUAL.replaced(**changed)
        assert settled(away(recording), p, passing(recording), names(recording)) == p


def around(baseline):
    """Two stereo cameras that look at each other, 4 m apart."""
    cameras = {}
    for name, turn, y in (("A", 0.0, -2.0), ("B", np.pi, 2.0)):
        for side, x in (("left", -baseline), ("right", 0.0)):
            place = (x if y < 0 else -x, y, 1.2)
            cameras[f"{name}_{side}"] = camera(f"{name}_{side}", place, (0.0, turn, 0.0))
    views = tuple(
        View(v, "stereo", Stream(f"{v}_right", "-"), left=Stream(f"{v}_left", "-")) for v in "AB"
    )
    return Recording(Path(), "around", 10.0, views, cameras)


def test_cameras_around_the_origin_are_not_asked_for_pictures():
    assert settled(around(0.12), USUAL, None, "AB") == USUAL
    found = settled(around(0.4), USUAL, None, "AB")
    assert found.disparity_count >= 400 * 0.4 / 1.1
    assert found == USUAL.replaced(disparity_count=found.disparity_count)
    few = USUAL.replaced(disparity_count=48)
    assert settled(around(0.4), few, None, "AB") == few
