"""Files of other tools as these lay them out."""

import json

import cv2
import numpy as np
import pytest
from scipy.io import savemat

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import vector_from_rotation
from stereotrack_core.interop.calibrations.deciding import completed, decide
from stereotrack_core.interop.calibrations.formats import read_foreign
from tests.interop.calibrations.layouts import (
    RIG,
    ZED,
    imported,
    matlab,
    opencv,
    pair,
    qualisys,
    ros,
    written,
)
from tests.interop.calibrations.rigs import assert_same


@pytest.mark.parametrize(
    ("first", "second"),
    [("M1 D1", "M2 D2"),
     ("left_camera_matrix left_distortion", "right_camera_matrix right_distortion")],
)  # fmt: skip
def test_a_stereo_pair_of_opencv_in_two_files(tmp_path, first, second):
    left, right, right_from_left = pair()
    lenses = dict(zip(first.split(), (left.matrix, left.distortions), strict=True))
    lenses |= dict(zip(second.split(), (right.matrix, right.distortions), strict=True))
    inside = opencv(image_width=640, image_height=480, **lenses)
    outside = opencv(R=right_from_left.rotation, T=right_from_left.translation, R1=np.eye(3))
    files = {"intrinsics.yml": inside, "extrinsics.yml": outside}
    paths = [written(tmp_path / name, text) for name, text in files.items()]
    found = read_foreign(paths)
    assert [one.name for one in found.cameras] == ["left", "right"]
    np.testing.assert_allclose(found.cameras[0].matrix, left.matrix)
    np.testing.assert_allclose(found.cameras[1].distortions, right.distortions)
    np.testing.assert_allclose(found.cameras[1].rotation, right_from_left.rotation, atol=1e-12)
    np.testing.assert_allclose(found.cameras[1].translation, right_from_left.translation)
    with pytest.raises(InputError, match="no R and T between them"):
        read_foreign(paths[:1])


def test_a_single_camera_of_opencv(tmp_path):
    lens = {"Camera_Matrix": RIG[0].matrix, "Distortion_Coefficients": RIG[0].distortions}
    path = written(tmp_path / "front.yml", opencv(image_Width=640, image_Height=480, **lens))
    (camera,) = imported(path)
    assert camera.name == "front"
    np.testing.assert_allclose(camera.matrix, RIG[0].matrix)
    assert np.array_equal(camera.position_world, np.zeros(3))
    bare = written(tmp_path / "bare.yml", opencv(**lens))
    with pytest.raises(InputError, match="does not state the image size of bare"):
        imported(bare)
    assert imported(bare, size=(640, 480))[0].width == 640


def test_jarvis_with_everything_transposed(tmp_path):
    paths = [
        written(
            tmp_path / f"{camera.name}.yaml",
            opencv(
                intrinsicMatrix=camera.matrix.T, distortionCoefficients=camera.distortions,
                R=camera.camera_from_world.rotation.T,
                T=1000 * camera.camera_from_world.translation,
            ),
        )
        for camera in RIG
    ]  # fmt: skip
    assert_same(imported(*paths, size=(640, 480)), RIG)


def test_easymocap_in_two_files(tmp_path):
    names = 'names:\n   - "A"\n   - "B"\n   - "C"\n'
    lenses = {f"K_{c.name}": c.matrix for c in RIG} | {f"dist_{c.name}": c.distortions for c in RIG}
    places = {}
    for camera in RIG:
        place = camera.camera_from_world
        places[f"R_{camera.name}"] = vector_from_rotation(place.rotation)[:, None]
        places[f"Rot_{camera.name}"] = place.rotation
        places[f"T_{camera.name}"] = place.translation[:, None]
    files = {"intri.yml": lenses, "extri.yml": places}
    paths = [written(tmp_path / name, opencv(**file) + names) for name, file in files.items()]
    assert_same(imported(*paths, size=(640, 480)), RIG)


def test_a_stereo_pair_of_ros(tmp_path):
    """Its rectification and projections are OpenCV's own."""
    left, right = RIG[0], RIG[1]
    turned = cv2.Rodrigues(np.array([0.01, -0.03, 0.02]))[0]
    offset = np.array([-0.12, 0.002, 0.004])
    lenses = (left.matrix, left.distortions, right.matrix, right.distortions)
    r1, r2, p1, p2, *_ = cv2.stereoRectify(*lenses, (640, 480), turned, offset[:, None])
    texts = {"l": ros("l", left, r1, p1), "r": ros("r", right, r2, p2)}
    paths = [written(tmp_path / f"{name}.yaml", text) for name, text in texts.items()]
    one, other = imported(*paths)
    assert (one.name, other.name) == ("l", "r")
    both = other.camera_from_world @ one.world_from_camera
    np.testing.assert_allclose(both.rotation, turned, atol=1e-9)
    np.testing.assert_allclose(both.translation, offset, atol=1e-9)


def test_a_message_of_ros(tmp_path):
    text = (
        "header:\n  frame_id: front\nheight: 480\nwidth: 640\ndistortion_model: plumb_bob\n"
        "d:\n- -0.2\n- 0.05\n- 0.001\n- -0.0005\n- 0.0\n"
        f"k: {RIG[0].matrix.ravel().tolist()}\nr: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
        "p: [600, 0, 320, 0, 0, 600, 240, 0, 0, 0, 1, 0]\nbinning_x: 0\n---\n"
    )
    (camera,) = imported(written(tmp_path / "echo.yaml", text))
    assert camera.name == "front"
    np.testing.assert_allclose(camera.matrix, RIG[0].matrix)


def test_qualisys(tmp_path):
    path = written(tmp_path / "Calib.qca.txt", "<?xml version='1.0'?>\n" + qualisys(RIG))
    found = read_foreign([path])
    assert (found.format, found.unit) == ("Qualisys", "mm")
    assert_same(imported(path), RIG)


@pytest.mark.parametrize("new", [False, True])
def test_matlab_as_json_and_as_mat(tmp_path, new):
    parameters, expected = matlab(new=new)
    text = json.dumps(parameters, default=lambda array: array.tolist())
    assert_same(imported(written(tmp_path / "stereo.json", text)), expected, tolerance=1e-8)
    savemat(tmp_path / "stereo.mat", {"s": parameters, "other": np.zeros(3)})
    assert_same(imported(tmp_path / "stereo.mat"), expected, tolerance=1e-8)
    assert read_foreign([tmp_path / "stereo.mat"]).unit == "mm"


def test_a_zed_has_a_pair_for_each_resolution(tmp_path):
    """As Stereolabs' tool writes the result of OpenCV: Baseline is -T[0], and T is in mm."""
    found = read_foreign([written(tmp_path / "SN12345.conf", ZED)])
    decided = decide(completed(found, size=(1280, 720)))
    left, right = decided.cameras["left"], decided.cameras["right"]
    assert (left.width, left.height) == (1280, 720)
    assert left.matrix[:2, 2].tolist() == [640.5, 360.25]
    assert left.distortions.tolist() == [-0.17, 0.02, 0.0001, -0.0002, -0.003]
    assert right.distortions.tolist() == [0.5, -0.1, 0, 0, 0.01, 0.8, -0.06, 0.02]
    np.testing.assert_allclose(right.camera_from_world.translation, [-0.1199, 5e-5, -4e-4])
    turn = vector_from_rotation(right.camera_from_world.rotation)
    np.testing.assert_allclose(turn, [0.002, 0.007, -0.001], atol=1e-12)
    assert right.position_world[0] == pytest.approx(0.1199, abs=1e-4), "to the right"
    assert completed(found, size=(672, 376)).cameras[0].matrix[0, 0] == 350
    with pytest.raises(InputError, match=r"cameras for images of 1280x720, 672x376"):
        completed(found)
