"""``stereotrack calibrate``: pictures to calibration.toml, and sentences for what cannot work."""

import cv2
import numpy as np
import pytest

from stereotrack_core.calibrate.align import aligned
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.lens import RADIAL, Lens
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory, write_landmarks
from stereotrack_core.simulation.rig import Sensor
from tests.calibrate.board_pictures import BoardRenderer, board_in_view

SIZE = (320, 240)
BOARD = Board(7, 4, 0.06)
LENS = Lens(RADIAL, np.array([300.0, 301, 160, 119, -0.1, 0.02, 0, 0, 0, 0, 0, 0]))
NAMED = ("--board", "7x4", "--square", "0.06")


def cameras():
    """A stereo camera."""
    places = {"N_left": (0.06, 0, 0), "N_right": (-0.06, 0, 0)}
    placed = {name: RigidTransform(np.eye(3), np.array(place)) for name, place in places.items()}
    return {name: LENS.camera(name, SIZE, place) for name, place in placed.items()}


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """A folder of pictures per camera."""
    return write_pictures(tmp_path_factory.mktemp("boards"), 12)


@pytest.fixture(scope="module")
def few_pictures(tmp_path_factory):
    """The first of these."""
    return write_pictures(tmp_path_factory.mktemp("boards"), 5)


def write_pictures(folder, count):
    rng = np.random.default_rng(4)
    middle = LENS.camera("middle", SIZE, RigidTransform.identity())
    boards = [board_in_view(middle, BOARD, rng, (0.9, 1.4)) for _ in range(count)]
    for number, (name, camera) in enumerate(cameras().items()):
        (folder / name).mkdir()
        sensor = Sensor(np.ones((1, 3)), 1.0, 0.6, 2.0, (1, number))
        renderer = BoardRenderer(camera, BOARD, sensor)
        for k, board in enumerate(boards):
            cv2.imwrite(str(folder / name / f"{k}.png"), renderer.picture(board, k))
    return folder


@pytest.fixture(scope="module")
def calibration(tmp_path_factory):
    """The true calibration, in a world that is not upright."""
    path = tmp_path_factory.mktemp("calibration") / "old.toml"
    turn = RigidTransform(rotation_from_vector(np.array([1.2, 0.3, -0.4])), np.ones(3))
    write_calibration(path, aligned(cameras(), turn))
    return path


@pytest.mark.slow
def test_intrinsics(run, pictures, tmp_path):
    out = tmp_path / "lens.toml"
    images = f"{pictures}/N_left/*.png"
    ended = run("calibrate", "intrinsics", "--images", images, *NAMED, "-o", out, "--json")
    told = ended.json
    assert told["rms_px"] < 0.15
    assert told["held_out_px"] < 0.2
    assert told["focal_px"][0] == pytest.approx(300, rel=0.01)
    assert len(told["pictures"]) + len(told["left_out"]) == 12
    assert [len(row) for row in told["covered_cells"]] == [8] * 6
    found = read_calibration(out)["camera"]
    assert found.focal == pytest.approx(np.mean(told["focal_px"]))
    table = run("calibrate", "intrinsics", "--images", images, *NAMED, "-o", out)
    assert "held out" in table.out
    assert "coefficients" in table.out


@pytest.mark.slow
def test_stereo_and_world_agree(run, pictures, tmp_path):
    out, other = tmp_path / "stereo.toml", tmp_path / "world.toml"
    sides = ("--left", pictures / "N_left", "--right", pictures / "N_right")
    ended = run("calibrate", "stereo", *sides, *NAMED, "-o", out, "--model", "radial", "--json")
    assert ended.json["pair"]["baseline_m"] == pytest.approx(0.12, abs=0.002)
    assert ended.json["rms_px"] < 0.2
    assert ended.json["scale"]["ratio"] == pytest.approx(1, abs=0.01)
    assert {one["camera"] for one in ended.json["cameras"]} == {"N_left", "N_right"}
    world = run("calibrate", "world", pictures, *NAMED, "-o", other, "--model", "radial")
    assert "All together" in world.out
    both = [read_calibration(path) for path in (out, other)]
    for name in ("N_left", "N_right"):
        np.testing.assert_allclose(both[0][name].matrix, both[1][name].matrix, rtol=1e-6)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--square", "0.06"), "name one board"),
        (("--board", "7x4", "--square", "60"), "0.06 for 60 mm"),
        (("--board", "13x10", "--square", "0.06"), "Film it again"),
    ],
)
def test_what_cannot_work_ends_with_a_sentence(run, few_pictures, tmp_path, options, words):
    out = tmp_path / "lens.toml"
    images = ("--images", f"{few_pictures}/N_left/*.png")
    ended = run("calibrate", "intrinsics", *images, *options, "-o", out, status=2)
    assert words in ended.err
    assert ended.err.count("\n") == 1
    assert not out.exists()


def test_align_by_a_person(run, calibration, tmp_path):
    points = np.full((4, 9, 3), np.nan)
    for name, x, z in (("shoulder", 0.2, 1.5), ("hip", 0.1, 1.0)):
        points[:, LANDMARKS.index(f"left_{name}")] = (-x, 0, z)
        points[:, LANDMARKS.index(f"right_{name}")] = (x, 0, z)
    turn = RigidTransform(rotation_from_vector(np.array([1.2, 0.3, -0.4])), np.ones(3))
    person = tmp_path / "person.csv"
    write_landmarks(person, LandmarkTrajectory(np.arange(4), turn.apply(points)))
    out = tmp_path / "new.toml"
    ended = run("calibrate", "align", calibration, "--person", person, "-o", out, "--json")
    assert ended.json["source"] == "person"
    place = read_calibration(out)["N_left"].position_world
    np.testing.assert_allclose(place, cameras()["N_left"].position_world, atol=0.1)


def test_align_by_points_and_by_a_board(run, calibration, few_pictures, tmp_path):
    out, clicks = tmp_path / "new.toml", tmp_path / "points.csv"
    old = read_calibration(calibration)
    turn = RigidTransform(rotation_from_vector(np.array([1.2, 0.3, -0.4])), np.ones(3))
    lines = ["point,camera,x,y"]
    for name, point in (("origin", (0, 0, 2)), ("north", (0.5, 0, 2)), ("floor", (0, 0.4, 2.1))):
        for camera in old.values():
            x, y = camera.project(turn.apply(np.array(point, dtype=float)))
            lines.append(f"{name},{camera.name},{x:.3f},{y:.3f}")
    clicks.write_text("\n".join(lines))
    ended = run("calibrate", "align", calibration, "--points", clicks, "-o", out, "--json")
    assert read_calibration(out)["N_left"].position_world[2] > 1
    clicks.write_text("\n".join(lines[:4]))
    refused = run("calibrate", "align", calibration, "--points", clicks, "-o", out, status=2)
    assert "in at least two cameras" in refused.err
    board = ("--board-on-floor", few_pictures, *NAMED)
    ended = run("calibrate", "align", calibration, *board, "-o", out, "--json")
    assert ended.json["rms_px"] < 0.3
    assert ended.json["scale"]["ratio"] == pytest.approx(1, abs=0.02)


def test_align_by_the_floor_of_a_recording(run, recording, tmp_path):
    true = read_calibration(recording / "calibration.toml")
    old, out = tmp_path / "old.toml", tmp_path / "new.toml"
    turn = RigidTransform(rotation_from_vector(np.array([0.2, -0.1, 0.4])), np.ones(3))
    write_calibration(old, aligned(true, turn))
    run("calibrate", "align", old, "--floor", recording, "-o", out, "--json")
    for name, camera in read_calibration(out).items():
        up = camera.camera_from_world.rotation[:, 2] @ true[name].camera_from_world.rotation[:, 2]
        assert up > np.cos(np.radians(2))
        height = true[name].position_world[2]
        assert camera.position_world[2] == pytest.approx(height, abs=0.08)
