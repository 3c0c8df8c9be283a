"""What is open in a stranger's calibration is found out from the data, or asked for."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.deciding import Undecided, completed, decide
from stereotrack_core.interop.calibrations.foreign import ForeignCalibration, ForeignCamera
from stereotrack_core.recording.description import Recording
from tests.interop.calibrations.rigs import assert_same, foreign, looking_at, rig


def test_how_far_cameras_usually_stand_does_not_overrule_a_documented_unit():
    hall = [
        replace(one, camera_from_world=RigidTransform(
            one.camera_from_world.rotation, 8 * one.camera_from_world.translation))
        for one in rig()
    ]  # fmt: skip
    decided = decide(replace(foreign(hall, unit="m"), documented=True))
    assert decided.unit == "m"
    assert "the lengths are unusual in m" in decided.notes[0]
    assert_same(decided.cameras.values(), hall)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("m", 1.0)])
def test_the_distance_of_the_cameras_tells_the_unit(unit, metres):
    cameras = rig()
    decided = decide(foreign(cameras, metres=metres))
    assert decided.unit == unit
    assert "the only possible one (distance of the cameras" in decided.reasons[1]
    assert_same(decided.cameras.values(), cameras)


def test_centimetres_and_inches_are_asked_about():
    with pytest.raises(Undecided, match="the unit of length is not stated") as refusal:
        decide(foreign(rig(), metres=0.01))
    assert refusal.value.remedy == "Give it with --units cm|in."
    assert decide(foreign(rig(), metres=0.01), unit="cm").unit == "cm"
    assert decide(foreign(rig(), metres=0.01, square=5.4)).unit == "cm", "by the board"


def test_a_unit_that_a_format_usually_has_gives_way_and_says_so():
    decided = decide(foreign(rig(), metres=0.001, unit="m"))
    assert decided.unit == "mm"
    assert "test usually writes m" in decided.reasons[1]


def test_a_unit_that_is_stated_is_never_replaced():
    with pytest.raises(Undecided, match="not possible in m"):
        decide(foreign(rig(), metres=0.001, unit="m", stated=True))


def stereo_pair():
    """A pair whose second camera is turned and moved, the first one being the world."""
    matrix = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
    turned = looking_at((0.0, 0.0, 0.0), (0.05, 1.0, 0.02)).rotation
    turned = turned @ looking_at((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)).rotation.T
    right = RigidTransform(turned, np.array([-0.12, 0.002, 0.001]))
    places = {"left": RigidTransform.identity(), "right": right}
    flat = np.zeros(5)
    return [Camera(name, 640, 480, matrix, flat, False, at) for name, at in places.items()]


def test_a_stereo_pair_in_the_frame_of_its_left_camera():
    pair = stereo_pair()
    decided = decide(foreign(pair, metres=0.001), (("left", "right"),))
    assert decided.unit == "mm"
    assert_same(decided.cameras.values(), pair)
    assert "the world is the frame of camera left" in decided.notes[0]
    assert "stereotrack calibrate align" in decided.notes[0]


def test_a_camera_without_a_place_stands_at_the_origin():
    one = foreign(rig()[:1]).cameras[0]
    bare = ForeignCamera(one.name, one.size, one.matrix, one.distortions)
    decided = decide(ForeignCalibration("test", "file", (bare,)))
    assert np.array_equal(decided.cameras["A"].position_world, np.zeros(3))
    assert "does not say where the cameras are" in decided.notes[0]


def test_names_and_sizes_come_from_the_person():
    found = foreign(rig())
    bare = ForeignCalibration(
        "test", "file",
        tuple(ForeignCamera("", None, c.matrix, c.distortions, False, c.rotation, c.translation)
              for c in found.cameras),
    )  # fmt: skip
    with pytest.raises(InputError, match="does not state the image size of cam_0"):
        completed(bare)
    with pytest.raises(InputError, match="the file has 3 cameras"):
        completed(bare, names=["A", "B"], size=(640, 480))
    done = completed(bare, names=["A", "B", "C"], size=(640, 480))
    assert_same(decide(done, unit="m").cameras.values(), rig())


@pytest.mark.parametrize(
    ("size", "shown", "accepted"),
    [
        ((1088, 1920), (1080, 1920), True),
        ((1920, 1088), (1920, 1080), True),
        ((1096, 1920), (1080, 1920), False),
        ((1080, 1920), (1088, 1920), False),
    ],
)
def test_a_calibration_of_padded_images_is_cropped(size, shown, accepted):
    stored = [replace(one, width=size[0], height=size[1]) for one in rig()]
    wanted = {one.name: replace(one, width=shown[0], height=shown[1]) for one in rig()}
    recording = Recording(Path(), "walk", 25.0, (), wanted)
    if not accepted:
        with pytest.raises(InputError, match="those of the recording have"):
            completed(foreign(stored), recording)
        return
    done = completed(foreign(stored, unit="m"), recording)
    assert "padded to multiples of 16" in done.notes[0]
    assert_same(decide(done).cameras.values(), wanted.values())
