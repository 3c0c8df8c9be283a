"""A rig, a person who stands in it, and its calibration as other tools would hold it."""

from dataclasses import replace

import numpy as np

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, ForeignCamera
from tests.calibrate.scenes import looking_at


def rig(*, fisheye: bool = False) -> list[Camera]:
    """Three cameras at different heights and distances; the last one may be a fisheye lens."""
    places = {"A": (2.6, 1.4, 1.7), "B": (-2.1, 2.2, 1.3), "C": (0.4, -3.1, 2.1)}
    cameras = []
    for i, (name, place) in enumerate(places.items()):
        matrix = np.array([[600.0 + 10 * i, 0, 321.5], [0, 603.0, 238.25], [0, 0, 1]])
        distortions = np.array([-0.2, 0.05, 1e-3, -5e-4, 0.01 * i])
        cameras.append(
            Camera(name, 640, 480, matrix, distortions, False, looking_at(place, (0.0, 0.0, 1.2)))
        )
    if fisheye:
        distortions = np.array([0.02, -0.01, 0.003, -0.001])
        cameras[2] = replace(cameras[2], distortions=distortions, fisheye=True)
    return cameras


WRITTEN = {
    "world-to-camera": lambda one: (one.rotation, one.translation),
    "transposed": lambda one: (one.rotation.T, one.translation),
    "camera-to-world": lambda one: (one.inverse().rotation, one.inverse().translation),
    "centre": lambda one: (one.rotation, one.inverse().translation),
}
"""What a file holds that was written by a convention."""


def foreign(cameras, convention="world-to-camera", metres=1.0, **keywords) -> ForeignCalibration:
    """A file of these cameras, whose unit is so many metres."""
    written = []
    for camera in cameras:
        rotation, translation = WRITTEN[convention](camera.camera_from_world)
        size = camera.width, camera.height
        lens = (camera.matrix, camera.distortions, camera.fisheye)
        written.append(ForeignCamera(camera.name, size, *lens, rotation, translation / metres))
    return ForeignCalibration("test", "file", tuple(written), **keywords)


def assert_same(read, cameras, *, tolerance=1e-9) -> None:
    """The same cameras in the same order."""
    assert [one.name for one in read] == [one.name for one in cameras]
    for one, camera in zip(read, cameras, strict=True):
        for fact in ("width", "height", "fisheye"):
            assert getattr(one, fact) == getattr(camera, fact)
        np.testing.assert_allclose(one.matrix, camera.matrix, atol=tolerance)
        np.testing.assert_allclose(one.distortions, camera.distortions, atol=tolerance)
        ours, theirs = one.camera_from_world, camera.camera_from_world
        np.testing.assert_allclose(ours.rotation, theirs.rotation, atol=tolerance)
        np.testing.assert_allclose(ours.translation, theirs.translation, atol=tolerance)
