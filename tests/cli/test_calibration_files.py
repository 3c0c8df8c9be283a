"""``stereotrack calibrate import`` and ``export`` on a recording whose calibration is foreign."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.interop.calibrations.formats import write_foreign
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.writing import write_png, write_recording_description
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
    write_foreign(tmp_path / "theirs.toml", inverted(rig()), "aniposelib", "mm")
    bare = (tmp_path / "theirs.toml").read_text().replace('units = "mm"', "adjusted = false")
    (tmp_path / "theirs.toml").write_text(bare)
    path = recording / "calibration.toml"
    arguments = ("calibrate", "import", tmp_path / "theirs.toml", "--recording", recording)
    ended = run(*arguments, "-o", tmp_path / "as_documented.toml", "--units", "mm")
    assert "With --convention camera-to-world they would" in ended.err
    assert "world-to-camera: as aniposelib documents it" in ended.out
    arguments = (*arguments, "--convention", "camera-to-world", "-o")
    assert "unit mm: the only possible one" in run(*arguments, path).out
    assert_same(read_calibration(path).values(), rig())
    run("info", recording)
    assert "never written to" in run(*arguments, path, status=2).err
    facts = run(*arguments, tmp_path / "again.toml", "--json").json
    assert (facts["convention"], facts["units"]) == ("camera-to-world", "mm")


def test_a_unit_that_nothing_tells_is_asked_for(run, tmp_path):
    write_foreign(tmp_path / "theirs.toml", rig(), "aniposelib", "cm")
    bare = (tmp_path / "theirs.toml").read_text().replace('units = "cm"', "adjusted = false")
    (tmp_path / "theirs.toml").write_text(bare)
    arguments = ("calibrate", "import", tmp_path / "theirs.toml", "-o", tmp_path / "c.toml")
    ended = run(*arguments, status=2)
    assert "mm: distance of the cameras" in ended.err
    assert "Give it with --units cm|in" in ended.err
    assert not (tmp_path / "c.toml").exists()
    run(*arguments, "--units", "cm")
    assert_same(read_calibration(tmp_path / "c.toml").values(), rig())


@pytest.mark.parametrize(
    ("name", "form", "units"),
    [("c.toml", "aniposelib", "m"), ("c.xml", "opencv", "m"), ("f.toml", "pose2sim", "mm")],
)
def test_export_and_import_again(run, tmp_path, name, form, units):
    cameras = rig(fisheye=True)
    write_calibration(tmp_path / "calibration.toml", {one.name: one for one in cameras})
    chosen = ("--format", form, "--units", units) if form == "pose2sim" else ()
    arguments = ("calibrate", "export", tmp_path / "calibration.toml", "-o", tmp_path / name)
    facts = run(*arguments, *chosen, "--json").json
    assert (facts["format"], facts["units"]) == (form, units)
    again = tmp_path / "again.toml"
    run("calibrate", "import", tmp_path / name, "-o", again)
    assert_same(read_calibration(again).values(), cameras)
