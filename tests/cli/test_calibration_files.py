"""``stereotrack calibrate import`` and ``export`` on a recording whose calibration is foreign."""

import json
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.formats import write_foreign
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.interop.calibrations.layouts import matlab
from tests.interop.calibrations.rigs import assert_same, rig


@pytest.fixture
def recording(tmp_path):
    """Three mono views; its calibration is still to be imported."""
    folder = tmp_path / "walk"
    cameras = {camera.name: camera for camera in rig()}
    views = []
    for name in cameras:
        (folder / name).mkdir(parents=True)
        for k in range(2):
            write_png(folder / name / f"{k}.png", np.full((480, 640), 90 + k, np.uint8))
        views.append(View(f"view {name}", "mono", Stream(name, f"{name}/%d.png")))
    write_recording_description(Recording(folder, "walk", 10.0, tuple(views), cameras))
    (folder / "calibration.toml").unlink()
    return folder


def inverted(cameras):
    return [replace(one, camera_from_world=one.world_from_camera) for one in cameras]


def test_an_inverted_calibration_is_doubted_and_read_as_stated(run, recording, tmp_path):
    write_foreign(tmp_path / "theirs.toml", inverted(rig()), "freemocap")
    bare = (tmp_path / "theirs.toml").read_text().replace('units = "mm"', "adjusted = false")
    (tmp_path / "theirs.toml").write_text(bare)
    path = recording / "calibration.toml"
    arguments = ("calibrate", "import", tmp_path / "theirs.toml", "--recording", recording)
    ended = run(*arguments, "-o", tmp_path / "as_documented.toml", "--units", "mm")
    assert ended.status == 0, ended.err
    assert "With --convention camera-to-world they would" in ended.err
    assert "world-to-camera: as aniposelib documents it" in ended.out
    arguments = (*arguments, "--convention", "camera-to-world", "-o")
    ended = run(*arguments, path)
    assert ended.status == 0, ended.err
    assert "unit mm: the only possible one" in ended.out
    assert_same(read_calibration(path).values(), rig())
    assert run("info", recording).status == 0
    assert "never written to" in run(*arguments, path).err
    facts = run(*arguments, tmp_path / "again.toml", "--json").json
    assert (facts["convention"], facts["units"]) == ("camera-to-world", "mm")


def test_a_file_with_fewer_cameras_than_the_recording(run, recording, tmp_path):
    write_foreign(tmp_path / "theirs.toml", rig()[:2], "pose2sim")
    path = tmp_path / "calibration.toml"
    arguments = ("calibrate", "import", tmp_path / "theirs.toml", "-o", path)
    ended = run(*arguments, "--recording", recording)
    assert ended.status == 0, ended.err
    assert "Note: the file lacks C of the recording." in ended.err
    other = [replace(one, width=600) for one in rig()]
    write_foreign(tmp_path / "theirs.toml", other, "pose2sim")
    ended = run(*arguments, "--recording", recording)
    assert "is for images of 600 x 480 pixels, those of the recording have 640" in ended.err


def test_a_unit_that_nothing_tells_is_asked_for(run, tmp_path):
    write_foreign(tmp_path / "theirs.toml", rig(), "aniposelib", "cm")
    bare = (tmp_path / "theirs.toml").read_text().replace('units = "cm"', "adjusted = false")
    (tmp_path / "theirs.toml").write_text(bare)
    arguments = ("calibrate", "import", tmp_path / "theirs.toml", "-o", tmp_path / "c.toml")
    ended = run(*arguments)
    assert ended.status == 2
    assert "mm: distance of the cameras" in ended.err
    assert "Give it with --units cm|in" in ended.err
    assert not (tmp_path / "c.toml").exists()
    assert run(*arguments, "--units", "cm").status == 0
    assert_same(read_calibration(tmp_path / "c.toml").values(), rig())


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (("--names", "X,Y,Z"), "none"),
        (("--size", "640"), "is not an image size"),
        (("-o", "x.yml"), "must end in .toml"),
    ],
)
def test_options(run, tmp_path, changes, says):
    write_foreign(tmp_path / "theirs.toml", rig(), "pose2sim")
    path = tmp_path / "c.toml"
    ended = run("calibrate", "import", tmp_path / "theirs.toml", "-o", path, *changes)
    if says == "none":
        assert list(read_calibration(path)) == ["X", "Y", "Z"]
    else:
        assert ended.status == 2
        assert says in ended.err


def test_names_that_the_recording_does_not_have(run, recording, tmp_path):
    theirs = [replace(one, name=f"cam {one.name}") for one in rig()]
    write_foreign(tmp_path / "theirs.toml", theirs, "pose2sim")
    arguments = ("calibrate", "import", tmp_path / "theirs.toml", "-o", tmp_path / "c.toml")
    ended = run(*arguments, "--recording", recording)
    assert ended.status == 2
    assert "named cam A, cam B, cam C, but those of the recording A, B, C" in ended.err
    ended = run(*arguments, "--recording", recording, "--names", "A,B,C")
    assert ended.status == 0


def test_the_world_of_a_camera_is_one_finding(run, recording, tmp_path):
    cameras = rig()
    own = [
        replace(one, camera_from_world=one.camera_from_world @ cameras[0].world_from_camera)
        for one in cameras
    ]
    write_calibration(recording / "calibration.toml", {one.name: one for one in own})
    findings = run("info", recording, "--json").json["findings"]
    assert [one["severity"] for one in findings] == ["note"], "it is tracked as it is"
    assert "the world is the frame of camera A" in findings[0]["what"]
    assert "stereotrack calibrate align" in findings[0]["remedy"]
    ended = run("calibrate", "import", recording / "calibration.toml", "-o", tmp_path / "c.toml")
    assert ended.status == 0
    assert "Note: the world is the frame of camera A" in ended.err
    aside = RigidTransform(np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]]), np.zeros(3))
    turned = replace(own[2], camera_from_world=aside @ own[2].camera_from_world)
    write_calibration(recording / "calibration.toml", {one.name: one for one in (*own[:2], turned)})
    findings = run("info", recording, "--json").json["findings"]
    assert len(findings) == 2
    assert "view C does not look towards" in findings[0]["what"]


def test_a_foreign_file_named_in_the_recording_says_how_to_import_it(run, recording):
    path = recording / "recording.toml"
    path.write_text(path.read_text().replace("calibration.toml", "camchain.yaml"))
    (recording / "camchain.yaml").write_text("cam0:\n  camera_model: pinhole\n")
    ended = run("info", recording)
    assert ended.status == 2
    assert "calibrate import`" in ended.out


@pytest.mark.parametrize(
    ("name", "form", "units"),
    [("c.toml", "aniposelib", "m"), ("c.xml", "opencv", "m"), ("f.toml", "freemocap", "mm")],
)
def test_export_and_import_again(run, tmp_path, name, form, units):
    cameras = rig(fisheye=True)
    write_calibration(tmp_path / "calibration.toml", {one.name: one for one in cameras})
    chosen = ("--format", form) if form == "freemocap" else ()
    arguments = ("calibrate", "export", tmp_path / "calibration.toml", "-o", tmp_path / name)
    facts = run(*arguments, *chosen, "--json").json
    assert (facts["format"], facts["units"]) == (form, units)
    again = tmp_path / "again.toml"
    assert run("calibrate", "import", tmp_path / name, "-o", again).status == 0
    assert_same(read_calibration(again).values(), cameras)


def test_export_needs_a_name_that_fits(run, tmp_path):
    write_calibration(tmp_path / "calibration.toml", {one.name: one for one in rig()})
    arguments = ("calibrate", "export", tmp_path / "calibration.toml", "-o")
    assert "must end in .yml" in run(*arguments, tmp_path / "c.toml", "--format", "opencv").err
    assert "the calibration that is read" in run(*arguments, tmp_path / "calibration.toml").err


def test_a_stereo_pair_gets_the_names_of_the_only_stereo_view(run, tmp_path):
    pair, expected = matlab(new=True)
    folder = tmp_path / "pair"
    named = {one.name: replace(one, name=f"N_{one.name}") for one in expected}
    for camera in named.values():
        (folder / camera.name).mkdir(parents=True)
        write_png(folder / camera.name / "0.png", np.zeros((480, 640), np.uint8))
    left, right = (Stream(one.name, f"{one.name}/%d.png") for one in named.values())
    views = (View("N", "stereo", right, left=left),)
    cameras = {one.name: one for one in named.values()}
    write_recording_description(Recording(folder, "pair", 10.0, views, cameras))
    (tmp_path / "stereo.json").write_text(json.dumps(pair, default=lambda array: array.tolist()))
    path = tmp_path / "c.toml"
    ended = run("calibrate", "import", tmp_path / "stereo.json", "-o", path, "--recording", folder)
    assert ended.status == 0, ended.err
    assert_same(read_calibration(path).values(), list(named.values()), tolerance=1e-8)
