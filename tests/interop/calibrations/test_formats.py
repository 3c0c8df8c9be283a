"""Files as other tools lay them out are read, and what is written is read again, also by others."""

import json
import tomllib
import xml.etree.ElementTree as ET

import cv2
import numpy as np
import pytest
import tomli_w
from scipy.io import savemat

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import vector_from_rotation
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.deciding import completed, decide
from stereotrack_core.interop.calibrations.evidence import Evidence
from stereotrack_core.interop.calibrations.formats import (
    UNITS_OF_EXPORT,
    read_foreign,
    write_foreign,
)
from tests.interop.calibrations.rigs import assert_same, looking_at, rig

RIG = rig()


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def imported(*paths, size=None):
    """Cameras of files, without any data."""
    return list(decide(completed(read_foreign(paths), size=size), Evidence()).cameras.values())


# ---- what is written is read again


@pytest.mark.parametrize("form", UNITS_OF_EXPORT)
@pytest.mark.parametrize("fisheye", [False, True])
def test_what_is_written_is_read_again(tmp_path, form, fisheye):
    cameras = rig(fisheye=fisheye)
    for name in ("c.yml", "c.xml") if form == "opencv" else ("c.toml",):
        write_foreign(tmp_path / name, cameras, form)
        assert_same(imported(tmp_path / name), cameras)


@pytest.mark.parametrize("form", ["aniposelib", "freemocap"])
def test_aniposelib_by_another_reader(tmp_path, form):
    write_foreign(tmp_path / "c.toml", RIG, form)
    content = tomllib.loads((tmp_path / "c.toml").read_text())
    metres = 0.001 if form == "freemocap" else 1.0
    assert list(content) == ["cam_0", "cam_1", "cam_2", "metadata"]
    for section, camera in zip(content.values(), RIG, strict=False):
        rotation = cv2.Rodrigues(np.array(section["rotation"]))[0]
        point = np.array([0.3, -0.2, 1.1])
        pixel, _ = cv2.projectPoints(
            point / metres, rotation, np.array(section["translation"]),
            np.array(section["matrix"]), np.array(section["distortions"]),
        )  # fmt: skip
        np.testing.assert_allclose(pixel.ravel(), camera.project(point), atol=1e-6)
        assert section["size"] == [640, 480]
        assert "fisheye" not in section


def test_pose2sim_and_caliscope_by_another_reader(tmp_path):
    write_foreign(tmp_path / "p.toml", RIG, "pose2sim")
    content = tomllib.loads((tmp_path / "p.toml").read_text())
    assert list(content) == ["A", "B", "C", "metadata"]
    assert content["A"]["size"] == [640.0, 480.0]
    assert content["A"]["fisheye"] is False
    assert content["metadata"] == {"adjusted": False, "error": 0.0, "units": "m"}
    write_foreign(tmp_path / "c.toml", RIG, "caliscope")
    nested = tomllib.loads((tmp_path / "c.toml").read_text())["cameras"]
    assert [int(key) for key in nested] == [one["cam_id"] for one in nested.values()]


def test_opencv_by_opencv(tmp_path):
    for name in ("c.yml", "c.xml"):
        write_foreign(tmp_path / name, RIG[:2], "opencv", "mm")
        storage = cv2.FileStorage(str(tmp_path / name), cv2.FILE_STORAGE_READ)
        names = storage.getNode("names")
        assert [names.at(i).string() for i in range(names.size())] == ["A", "B"]
        for camera in RIG[:2]:
            place = camera.camera_from_world
            for key, expected in (
                ("K", camera.matrix), ("dist", camera.distortions[None]), ("Rot", place.rotation),
                ("R", vector_from_rotation(place.rotation)[:, None]),
                ("T", 1000 * place.translation[:, None]),
            ):  # fmt: skip
                found = storage.getNode(f"{key}_{camera.name}").mat()
                np.testing.assert_allclose(found, expected, rtol=1e-14)
        both = RIG[1].camera_from_world @ RIG[0].world_from_camera
        np.testing.assert_allclose(storage.getNode("R").mat(), both.rotation, atol=1e-14)
        np.testing.assert_allclose(storage.getNode("T").mat()[:, 0], 1000 * both.translation)
        storage.release()


def test_a_name_that_opencv_does_not_allow(tmp_path):
    odd = [Camera("left camera", 4, 4, np.eye(3), np.zeros(5), False, RigidTransform.identity())]
    with pytest.raises(InputError, match="letters, digits"):
        write_foreign(tmp_path / "c.yml", odd, "opencv")


# ---- as the tools write them


def sections(**changes):
    """Cameras in the layout of aniposelib."""
    return {
        f"cam_{i}": {
            "name": camera.name,
            "size": [640, 480],
            "matrix": camera.matrix.tolist(),
            "distortions": camera.distortions.tolist(),
            "rotation": vector_from_rotation(camera.camera_from_world.rotation).tolist(),
            "translation": camera.camera_from_world.translation.tolist(),
            **changes,
        }
        for i, camera in enumerate(RIG)
    }


def toml(path, content):
    return written(path, tomli_w.dumps(content))


def test_caliscope_with_matrices_without_names_and_beside_other_settings(tmp_path):
    cameras = sections()
    for section, camera in zip(cameras.values(), RIG, strict=True):
        del section["name"]
        section.update(port=3, rotation_count=-1, ignore=False, exposure=-7.0, grid_count=24)
        section["rotation"] = camera.camera_from_world.rotation.tolist()
    cameras["cam_3"] = {"port": 9, "size": [640, 480], "ignore": True}
    settings = {"fps_recording": 24, "capture_volume": {"stage": 2}, "charuco": {"columns": 4}}
    path = toml(tmp_path / "config.toml", {**settings, **cameras})
    found = read_foreign([path])
    assert (found.format, found.unit, found.stated) == ("caliscope", "m", False)
    assert found.notes == ("cam_3 is left out: it is not calibrated",)
    assert [one.name for one in imported(path)] == ["cam_0", "cam_1", "cam_2"]
    for one, camera in zip(imported(path), RIG, strict=True):
        np.testing.assert_allclose(
            one.camera_from_world.rotation, camera.camera_from_world.rotation, atol=1e-12
        )


def test_caliscope_with_nested_cameras(tmp_path):
    nested = {str(i): one for i, one in enumerate(sections(cam_id=0).values())}
    for section in nested.values():
        del section["name"]
    path = toml(tmp_path / "camera_array.toml", {"cameras": nested})
    assert read_foreign([path]).format == "caliscope"
    assert [one.name for one in imported(path)] == ["cam_0", "cam_1", "cam_2"]


def test_pose2sim_and_freemocap_are_told_apart(tmp_path):
    by_name = {one["name"]: one for one in sections(fisheye=False).values()}
    extra = {"metadata": {"adjusted": False, "error": 0.0}}
    pose2sim = read_foreign([toml(tmp_path / "Calib.toml", {**by_name, **extra})])
    assert (pose2sim.format, pose2sim.unit) == ("Pose2Sim", "m")
    board = {"metadata": {"charuco_square_size": 58.0, "path_to_recorded_videos": "C:/videos"}}
    freemocap = read_foreign([toml(tmp_path / "f.toml", {**sections(), **board})])
    assert (freemocap.format, freemocap.unit, freemocap.square) == ("FreeMoCap", "mm", 58.0)
    anipose = read_foreign([toml(tmp_path / "a.toml", {**sections(), **extra})])
    assert (anipose.format, anipose.unit) == ("aniposelib", None)


YAML_MATRIX = """{name}: !!opencv-matrix
   rows: {rows}
   cols: {cols}
   dt: d
   data: [ {data} ]
"""


def opencv(**matrices):
    """YAML as OpenCV 4 writes it, lines broken in the middle of a matrix."""
    parts = ["%YAML:1.0\n---\n"]
    for name, value in matrices.items():
        if isinstance(value, str | int | float):
            parts.append(f"{name}: {value}\n")
            continue
        array = np.atleast_2d(value)
        data = ", ".join(f"{x:.16e}" for x in array.ravel()).replace(", ", ",\n       ", 1)
        rows, cols = array.shape
        parts.append(YAML_MATRIX.format(name=name, rows=rows, cols=cols, data=data))
    return "".join(parts)


def pair():
    left, right = RIG[0], RIG[1]
    return left, right, right.camera_from_world @ left.world_from_camera


@pytest.mark.parametrize(
    ("first", "second"),
    [("M1 D1", "M2 D2"), ("cameraMatrix1 distCoeffs1", "cameraMatrix2 distCoeffs2"),
     ("left_camera_matrix left_distortion", "right_camera_matrix right_distortion"),
     ("K_L D_L", "K_R D_R")],
)  # fmt: skip
def test_a_stereo_pair_of_opencv_in_two_files(tmp_path, first, second):
    left, right, right_from_left = pair()
    lenses = dict(zip(first.split(), (left.matrix, left.distortions), strict=True))
    lenses |= dict(zip(second.split(), (right.matrix, right.distortions), strict=True))
    inside = written(
        tmp_path / "intrinsics.yml", opencv(image_width=640, image_height=480, **lenses)
    )
    outside = opencv(R=right_from_left.rotation, T=right_from_left.translation, R1=np.eye(3))
    paths = inside, written(tmp_path / "extrinsics.yml", outside)
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
    paths = [
        written(tmp_path / "intri.yml", opencv(**lenses) + names),
        written(tmp_path / "extri.yml", opencv(**places) + names),
    ]
    assert_same(imported(*paths, size=(640, 480)), RIG)


KALIBR = """cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 1e-05, 1.76187114e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 0.9999500004, -0.0099998333, 0.001]
  - [0.0, 0.0099998333, 0.9999500004, -0.0002]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.27, 0.7, -1.7,
    1.9]
  distortion_model: equidistant
  intrinsics: [457.587, 456.134, 379.999, 255.238]
  resolution: [752, 480]
cam2:
  T_cn_cnm1:
  - [0.0, 0.0, 1.0, -1.5]
  - [0.0, 1.0, 0.0, 0.0]
  - [-1.0, 0.0, 0.0, 1.5]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0, 0, 0, 0]
  distortion_model: radtan
  intrinsics: [450, 450, 376, 240]
  resolution: [752, 480]
"""


def test_a_chain_of_kalibr(tmp_path):
    found = read_foreign([written(tmp_path / "camchain.yaml", KALIBR)])
    assert (found.format, found.unit) == ("Kalibr", "m")
    first, second, third = found.cameras
    assert (first.fisheye, second.fisheye) == (False, True)
    assert second.distortions.tolist() == [0.27, 0.7, -1.7, 1.9]
    assert np.array_equal(first.rotation, np.eye(3))
    one = RigidTransform(second.rotation, second.translation)
    step = RigidTransform(np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]]), np.array([-1.5, 0, 1.5]))
    both = step @ one
    np.testing.assert_allclose(third.rotation, both.rotation, atol=1e-9)
    np.testing.assert_allclose(third.translation, both.translation, atol=1e-9)


def test_a_model_that_opencv_does_not_have(tmp_path):
    path = written(tmp_path / "camchain.yaml", KALIBR.replace("pinhole", "omni", 1))
    with pytest.raises(InputError, match=r"cam0.*omni-radtan cannot be read"):
        read_foreign([path])


def test_a_stereo_pair_of_ros(tmp_path):
    """Its rectification and projections are OpenCV's own."""
    left, right = RIG[0], RIG[1]
    turned = cv2.Rodrigues(np.array([0.01, -0.03, 0.02]))[0]
    offset = np.array([-0.12, 0.002, 0.004])
    lenses = (left.matrix, left.distortions, right.matrix, right.distortions)
    r1, r2, p1, p2, *_ = cv2.stereoRectify(*lenses, (640, 480), turned, offset[:, None])
    paths = []
    for name, camera, r, p in (("l", left, r1, p1), ("r", right, r2, p2)):
        rows = {"camera_matrix": camera.matrix, "distortion_coefficients": camera.distortions,
                "rectification_matrix": r, "projection_matrix": p}  # fmt: skip
        text = f"image_width: 640\nimage_height: 480\ncamera_name: {name}\n"
        text += "distortion_model: plumb_bob\n"
        for key, value in rows.items():
            array = np.atleast_2d(value)
            text += f"{key}:\n  rows: {array.shape[0]}\n  cols: {array.shape[1]}\n"
            text += f"  data: {array.ravel().tolist()}\n"
        paths.append(written(tmp_path / f"{name}.yaml", text))
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


def qualisys(cameras):
    root = ET.Element("calibration", {"type": "regular"})
    parent = ET.SubElement(root, "cameras")
    for camera in cameras:
        one = ET.SubElement(parent, "camera", {"serial": camera.name, "model": "Miqus Video"})
        ET.SubElement(
            one, "fov_video", {"left": "10", "top": "20", "right": "649", "bottom": "499"}
        )
        axes = camera.camera_from_world.rotation * np.array([[1], [-1], [-1]])
        place = 1000 * camera.position_world
        stated = {f"r{i + 1}{j + 1}": repr(float(axes[i, j])) for i in range(3) for j in range(3)}
        stated |= {key: repr(float(value)) for key, value in zip("xyz", place, strict=True)}
        ET.SubElement(one, "transform", stated)
        k1, k2, p1, p2, k3 = camera.distortions
        lens = {
            "focalLengthU": 64 * camera.matrix[0, 0], "focalLengthV": 64 * camera.matrix[1, 1],
            "centerPointU": 64 * (camera.matrix[0, 2] + 10),
            "centerPointV": 64 * (camera.matrix[1, 2] + 20), "skew": 0.0,
            "radialDistortion1": k1, "radialDistortion2": k2, "radialDistortion3": k3,
            "tangentalDistortion1": p1, "tangentalDistortion2": p2,
        }  # fmt: skip
        ET.SubElement(one, "intrinsic", {key: repr(float(value)) for key, value in lens.items()})
    return ET.tostring(root, encoding="unicode")


def test_qualisys(tmp_path):
    path = written(tmp_path / "Calib.qca.txt", "<?xml version='1.0'?>\n" + qualisys(RIG))
    found = read_foreign([path])
    assert (found.format, found.unit) == ("Qualisys", "mm")
    assert_same(imported(path), RIG)


def matlab(*, new):
    """A pair 120 mm apart as MATLAB has it: pixels from 1, transposed where it multiplies so."""
    left, right = RIG[0], RIG[1]
    turned = looking_at((0, 0, 0), (0.05, 1, 0)).rotation
    turned = turned @ looking_at((0, 0, 0), (0, 1, 0)).rotation.T
    offset = [-120.0, 1.0, 2.0]
    lenses = []
    for camera in (left, right):
        matrix = camera.matrix.copy()
        matrix[:2, 2] += 1.0
        k1, k2, p1, p2, k3 = camera.distortions
        lens = {"K": matrix} if new else {"IntrinsicMatrix": matrix.T}
        lenses.append(
            {"ImageSize": [480, 640], "RadialDistortion": [k1, k2, k3], "WorldUnits": "millimeters",
             "TangentialDistortion": [p1, p2], "Skew": 0, **lens}
        )  # fmt: skip
    both = {"CameraParameters1": lenses[0], "CameraParameters2": lenses[1]}
    if new:
        full = np.eye(4)
        full[:3, :3], full[:3, 3] = turned, offset
        both["PoseCamera2"] = {"Dimensionality": 3, "A": full}
    else:
        both |= {"RotationOfCamera2": turned.T, "TranslationOfCamera2": offset}
    expected = [left, right]
    places = [RigidTransform.identity(), RigidTransform(turned, np.array(offset) / 1000)]
    return both, [
        Camera(name, 640, 480, c.matrix, c.distortions, False, place)
        for name, c, place in zip(("left", "right"), expected, places, strict=True)
    ]


@pytest.mark.parametrize("new", [False, True])
def test_matlab_as_json_and_as_mat(tmp_path, new):
    parameters, expected = matlab(new=new)
    text = json.dumps(parameters, default=lambda array: array.tolist())
    assert_same(imported(written(tmp_path / "stereo.json", text)), expected, tolerance=1e-8)
    savemat(tmp_path / "stereo.mat", {"s": parameters, "other": np.zeros(3)})
    assert_same(imported(tmp_path / "stereo.mat"), expected, tolerance=1e-8)
    assert read_foreign([tmp_path / "stereo.mat"]).unit == "mm"


def test_one_camera_of_matlab(tmp_path):
    one = {
        "FocalLength": [600.0, 603.0],
        "PrincipalPoint": [322.5, 239.25],
        "RadialDistortion": [-0.2, 0.05],
        "TangentialDistortion": [0, 0],
        "ImageSize": [],
    }
    path = written(tmp_path / "cam.json", json.dumps({"cameraParams": one}))
    (camera,) = imported(path, size=(640, 480))
    np.testing.assert_allclose(camera.matrix[:2, 2], [321.5, 238.25])


# ---- what is no calibration, or one that cannot be read


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("x.toml", "[cam_0]\nsize = [640, 480]\n", "contains no camera"),
        ("x.toml", "a = ", "not valid TOML"),
        ("x.yml", "just words", "not a calibration file"),
        ("x.yml", "a: [1, 2\nb: 3\n", r"line \d.*not valid YAML|not valid YAML"),
        ("x.yml", "a: &a [1]\nb: *a\n", "not valid YAML"),
        ("x.yml", "a: 1\n", "contains no camera"),
        ("x.xml", "<svg/>", "neither OpenCV's nor Qualisys'"),
        ("x.xml", "<opencv_storage><a></opencv_storage>", "not valid XML"),
        ("x.xml", '<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "XML entities"),
        ("x.json", "{", "not valid JSON"),
        ("x.mat", "\x89HDF", "MAT file"),
        ("x.yml", "K: [1, 0, 3, 0, 1]\n", "3 x 3"),
        ("x.yml", "K: [500, 0, 3, 0, 500, 3, 7, 7, 1]\n", "last row is not 0, 0, 1"),
        ("x.yml", "K: [0.5, 0, 3, 0, 0.5, 3, 0, 0, 1]\n", "not in pixels"),
        ("x.yml", "K: [.nan, 0, 3, 0, 500, 3, 0, 0, 1]\n", "not finite"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path, name, text, says):
    path = written(tmp_path / name, text)
    with pytest.raises(InputError, match=says) as refusal:
        read_foreign([path])
    assert str(path) in refusal.value.where
    assert refusal.value.remedy


def test_files_of_different_formats(tmp_path):
    write_foreign(tmp_path / "a.toml", RIG, "aniposelib")
    paths = [tmp_path / "a.toml", written(tmp_path / "camchain.yaml", KALIBR)]
    with pytest.raises(InputError, match="different formats"):
        read_foreign(paths)
