"""Files as other tools lay them out are read, and what is written is read again, also by others."""

import tomllib

import cv2
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import vector_from_rotation
from stereotrack_core.interop.calibrations.formats import WRITTEN, read_foreign, write_foreign
from tests.interop.calibrations.layouts import RIG, imported, qualisys, sections, toml, written
from tests.interop.calibrations.rigs import assert_same, rig


@pytest.mark.parametrize("form", WRITTEN)
@pytest.mark.parametrize("fisheye", [False, True])
def test_what_is_written_is_read_again(tmp_path, form, fisheye):
    cameras = rig(fisheye=fisheye)
    for name in ("c.yml", "c.xml") if form == "opencv" else ("c.toml",):
        write_foreign(tmp_path / name, cameras, form)
        assert_same(imported(tmp_path / name), cameras)


@pytest.mark.parametrize(("unit", "metres"), [("m", 1.0), ("mm", 0.001)])
def test_aniposelib_by_another_reader(tmp_path, unit, metres):
    write_foreign(tmp_path / "c.toml", RIG, "aniposelib", unit)
    content = tomllib.loads((tmp_path / "c.toml").read_text())
    assert list(content) == ["cam_0", "cam_1", "cam_2", "metadata"]
    for section, camera in zip(content.values(), RIG, strict=False):
        rotation = cv2.Rodrigues(np.array(section["rotation"]))[0]
        point = np.array([0.3, -0.2, 1.1])
        numbers = [np.array(section[name]) for name in ("translation", "matrix", "distortions")]
        pixel, _ = cv2.projectPoints(point / metres, rotation, *numbers)
        np.testing.assert_allclose(pixel.ravel(), camera.project(point), atol=1e-6)
        assert section["size"] == [640, 480]
        assert "fisheye" not in section


def test_pose2sim_by_another_reader(tmp_path):
    write_foreign(tmp_path / "p.toml", RIG, "pose2sim")
    content = tomllib.loads((tmp_path / "p.toml").read_text())
    assert list(content) == ["A", "B", "C", "metadata"]
    assert content["A"]["size"] == [640.0, 480.0]
    assert content["A"]["fisheye"] is False
    assert content["metadata"] == {"adjusted": False, "error": 0.0, "units": "m"}


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
        rotations = (each.camera_from_world.rotation for each in (one, camera))
        np.testing.assert_allclose(*rotations, atol=1e-12)


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


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("x.toml", "[cam_0]\nsize = [640, 480]\n", "contains no camera"),
        ("x.toml", "a = ", "not valid TOML"),
        ("x.yml", "a: [1, 2\nb: 3\n", r"line \d.*not valid YAML|not valid YAML"),
        ("x.xml", "<opencv_storage><a></opencv_storage>", "not valid XML"),
        ("x.xml", '<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "XML entities"),
        ("x.mat", "\x89HDF", "MAT file"),
        ("x.yml", "K: [500, 0, 3, 0, 500, 3, 7, 7, 1]\n", "last row is not 0, 0, 1"),
        ("x.yml", "K: [0.5, 0, 3, 0, 0.5, 3, 0, 0, 1]\n", "not in pixels"),
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
    paths = [tmp_path / "a.toml", written(tmp_path / "q.txt", qualisys(RIG))]
    with pytest.raises(InputError, match="different formats"):
        read_foreign(paths)
