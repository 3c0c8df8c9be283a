"""Calibrations of upright images for videos that are stored lying: the same pixels are seen."""

import struct

import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.importing.making import as_stored, calibration_notes, make_recording
from tests.recording.importing.clips import HEIGHT, WIDTH, chosen, clip

POINTS = np.random.default_rng(1).uniform((-0.5, -0.5, 1.5), (0.5, 0.5, 4.0), (50, 3))


def upright(fisheye=False):
    """A camera of images that are higher than wide."""
    distortions = [-0.2, 0.05, 0.01, -0.002] if fisheye else [-0.2, 0.05, 0.003, -0.004, 0.01]
    matrix = np.array([[60.0, 0, 20.0], [0, 62.0, 35.0], [0, 0, 1]])
    return Camera("P", HEIGHT, WIDTH, matrix, np.array(distortions), fisheye,
                  RigidTransform.identity())  # fmt: skip


def shown(pixels, turned, width, height):
    """Where pixels of the stored image are seen when it is turned clockwise."""
    for _ in range(turned // 90):
        pixels = np.stack([height - 1 - pixels[:, 1], pixels[:, 0]], axis=1)
        width, height = height, width
    return pixels


@pytest.mark.parametrize("fisheye", [False, True])
@pytest.mark.parametrize("turned", [90, 270])
def test_what_a_turned_camera_sees_is_what_the_upright_one_sees(turned, fisheye):
    camera = upright(fisheye)
    stored = as_stored(camera, turned)
    assert (stored.width, stored.height) == (WIDTH, HEIGHT)
    seen = shown(stored.project(POINTS), turned, WIDTH, HEIGHT)
    assert np.allclose(seen, camera.project(POINTS), atol=1e-9)


def test_a_telephone_with_a_calibration_of_its_upright_images(tmp_path):
    path = clip(tmp_path / "in" / "P.mp4", frames=2)
    data = bytearray(path.read_bytes())
    place = data.find(b"tkhd") + 44
    quarter = (0, 0x10000, 0, -0x10000, 0, 0, HEIGHT << 16, 0, 0x40000000)
    data[place : place + 36] = struct.pack(">9i", *quarter)
    path.write_bytes(bytes(data))
    write_calibration(tmp_path / "rig.toml", {"P": upright()})
    choices = chosen(tmp_path / "in", calibration=tmp_path / "rig.toml")
    assert "the calibration of P is of upright images" in calibration_notes(choices)[0]
    recording = make_recording(choices, tmp_path / "out")
    (view,) = recording.views
    turned = view.display_rotation
    assert turned == 90
    camera = read_calibration(tmp_path / "out" / "calibration.toml")["P"]
    seen = shown(camera.project(POINTS), turned, WIDTH, HEIGHT)
    assert np.allclose(seen, upright().project(POINTS), atol=1e-6)
