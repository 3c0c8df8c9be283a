"""Points that several cameras see are found beside a recording, whatever its calibration says."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.calibrations.deciding import Undecided, decide
from stereotrack_core.interop.calibrations.evidence import (
    Evidence,
    SeenPoints,
    evidence_of,
    joins_all,
    recording_without_calibration,
)
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.interop.calibrations.rigs import assert_same, foreign, rig, seen_person

DISPARITY = 24


@pytest.fixture(scope="module")
def stereo(tmp_path_factory):
    """A stereo view of a wall with a pattern, and its cameras; the calibration is no file."""
    folder = tmp_path_factory.mktemp("stereo")
    noise = np.random.default_rng(2).integers(0, 255, (60, 90)).astype(np.uint8)
    wall = cv2.resize(noise, (360, 240), interpolation=cv2.INTER_CUBIC)
    matrix = np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]])
    right_from_left = RigidTransform(np.eye(3), np.array([-0.12, 0, 0]))
    cameras = {
        name: Camera(name, 320, 240, matrix, np.zeros(5), False, place)
        for name, place in (("L", RigidTransform.identity()), ("R", right_from_left))
    }
    for name, first in (("L", 0), ("R", DISPARITY)):
        (folder / name).mkdir()
        write_png(folder / name / "0.png", np.ascontiguousarray(wall[:, first : first + 320]))
    views = (View("N", "stereo", Stream("R", "R/%d.png"), left=Stream("L", "L/%d.png")),)
    write_recording_description(Recording(folder, "wall", 10.0, views, cameras))
    (folder / "calibration.toml").write_text("nothing")
    return folder, list(cameras.values())


def test_details_of_a_stereo_view_need_no_calibration(stereo):
    folder, cameras = stereo
    found = evidence_of(recording_without_calibration(folder))
    assert found.pairs == (("L", "R"),)
    (seen,) = found.seen
    assert seen.cameras == ("L", "R")
    assert seen.pixels.shape[1] > 100
    shift = seen.pixels[0] - seen.pixels[1]
    assert np.median(np.abs(shift - [DISPARITY, 0]), axis=0).max() < 1.0
    decided = decide(foreign(cameras, metres=0.001), found)
    assert_same(decided.cameras.values(), cameras)
    assert decided.unit == "mm"
    with pytest.raises(Undecided, match=r"the points contradict .* camera-to-world or centre"):
        decide(foreign(cameras, "camera-to-world", unit="m"), found)


def test_points_of_pairs_do_not_hold_the_pairs_together():
    cameras = [*rig(), replace(rig()[0], name="D")]
    seen = seen_person(cameras)
    both = [SeenPoints("x", seen.cameras[i : i + 2], seen.pixels[i : i + 2]) for i in (0, 2)]
    assert joins_all(Evidence((seen,)), "ABCD")
    assert not joins_all(Evidence(tuple(both)), "ABCD")
    bridge = SeenPoints("x", ("B", "C"), seen.pixels[1:3])
    assert joins_all(Evidence((*both, bridge)), "ABCD")


def test_a_recording_without_views_and_clicks_that_hold_nothing(stereo, tmp_path):
    (tmp_path / "recording.toml").write_text("format = 1\n")
    with pytest.raises(InputError):
        recording_without_calibration(tmp_path)
    (tmp_path / "c.csv").write_text("frame,view,landmark,x,y\n0,Q,head,1,1\n")
    with pytest.raises(InputError, match="no clicks in two cameras"):
        evidence_of(recording_without_calibration(stereo[0]), tmp_path / "c.csv")
