import json

import cv2
import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.program import main
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import KINDS, SceneOptions, parsed_disturbances
from tests.simulation.scenes import SMALL, scene

PAIR = ("N_left", "N_right")
GEOMETRY = {"frames": 4, "views": ("N", "O"), "noise": 0.0}


def disturbed(text="", **options):
    return scene(disturbances=parsed_disturbances(text), **(GEOMETRY | options))


@pytest.fixture(scope="module")
def plain():
    return disturbed()


def picture(made, camera, frame=0):
    return made.picture(camera, made.people(frame)[0], frame).astype(float)


def grey(made, camera, frame):
    """Rows of the picture of a surface of brightness 100."""
    light = np.full((120, 160, 1), 100, np.float32)
    return made.disturber.on_sensor(camera, light, frame)[:, :, 0] / 100


def moved(before, after):
    """Shift (x, y) in pixels from one picture to the next."""
    return np.array(cv2.phaseCorrelate(before, after)[0])


def test_gain_and_gamma_change_the_brightness(plain):
    expected = picture(plain, "N_right")
    np.testing.assert_allclose(picture(disturbed("gain=0.7"), "N_right"), 0.7 * expected, atol=1.0)
    bent = picture(disturbed("gamma=0.6"), "N_right")
    np.testing.assert_allclose(bent, 255 * (expected / 255) ** 0.6, atol=6.0)


def test_exposure_and_flicker_change_in_time():
    made = disturbed("exposure=0.3", frames=200)
    left, right = (np.array([grey(made, name, k)[0, 0] for k in range(200)]) for name in PAIR)
    np.testing.assert_allclose([left.min(), left.max()], [0.7, 1.3], atol=0.01)
    np.testing.assert_allclose(left[:100], left[100:], atol=1e-5)
    assert np.abs(left - right).max() > 0.05
    made = disturbed("flicker=0.15")
    left, right = (np.array([grey(made, name, k)[0, 0] for k in range(60)]) for name in PAIR)
    np.testing.assert_array_equal(left, right)
    assert 0.12 < np.abs(left - 1).max() <= 0.1501
    assert np.abs(np.diff(left)).mean() > 0.05


def test_noise_and_blur_are_added_to_those_of_the_sensor(plain):
    expected = picture(plain, "N_left")
    assert 11 < (picture(disturbed("noise=12"), "N_left") - expected).std() < 13
    blurred = picture(disturbed("blur=2"), "N_left")
    gradients = [np.abs(np.diff(p, axis=1)).mean() for p in (blurred, expected)]
    assert gradients[0] < 0.7 * gradients[1]


def test_the_shadow_goes_with_the_person_and_the_shade_wanders(plain):
    for kind, away in (("shadow", []), ("shade", plain.people(0)[0])):
        made = disturbed(f"{kind}=0.4", frames=60)
        empty = made.picture("N_right", [], 0).astype(float)
        assert np.abs(empty - picture(made, "N_right")).max() > 20
        changed = np.abs(made.picture("N_right", away, 59).astype(float) - empty) > 15
        assert changed[100:].any() == (kind == "shade")


def test_a_passer_walks_behind_the_person_who_stays_in_front():
    made = disturbed("passer", frames=60)
    crowd = [made.people(frame)[0] for frame in range(0, 60, 6)]
    assert {len(people) for people in crowd} == {2}
    behind = 0
    for people in crowd:
        empty, one, both = (made.renderers["N_right"].depth(people[:n]) for n in range(3))
        np.testing.assert_array_equal(both[one < empty], one[one < empty])
        behind += np.count_nonzero((both < one) & (both > 5))
    assert behind > 500


def test_a_pair_shakes_together_and_otherwise_in_each_frame(plain):
    made = disturbed("shake")
    pictures = [[(picture(plain, c, k), picture(made, c, k)) for c in PAIR] for k in range(3)]
    shifts = np.array([[moved(*both) for both in pair] for pair in pictures])
    np.testing.assert_allclose(shifts[:, 0], shifts[:, 1], atol=0.2)
    assert 0.3 < np.linalg.norm(shifts, axis=-1).mean() < 3
    assert np.ptp(shifts, axis=0).max() > 0.3


def test_rows_of_the_left_pictures_are_off_with_those_of_the_empty_scene(plain):
    made = disturbed("rows=0.7")
    for name, expected in zip(PAIR, (0.7, 0.0), strict=True):
        shift = moved(picture(plain, name), picture(made, name))
        np.testing.assert_allclose(shift, [0, expected], atol=0.1)
    empty = [s.renderers["N_left"].background().astype(float) for s in (plain, made)]
    np.testing.assert_allclose(moved(*empty), [0, 0.7], atol=0.1)


def test_a_bump_turns_the_first_view_from_half_time_on(plain):
    made = disturbed("bump=2")
    for name in (*PAIR, "O_left", "O_right"):
        np.testing.assert_array_equal(picture(made, name, 1), picture(plain, name, 1))
        shift = moved(picture(plain, name, 2), picture(made, name, 2))
        expected = 100 * np.tan(np.radians(2)) if name in PAIR else 0.0
        assert abs(np.linalg.norm(shift) - expected) < 0.8


def made_recording(folder, text, seed=0, frames=4, views="NO", **options):
    options = SceneOptions(**(SMALL | options))
    disturbances = parsed_disturbances(text)
    made = Simulation("P1", "cross-arms", frames, views, seed, options, disturbances=disturbances)
    simulate(folder, made)
    return folder


def test_the_last_view_is_late_and_strong_compression_makes_small_files(tmp_path):
    quiet = {"noise": 0.0, "lossless": True, "pace": 3.0, "t_pose_first": False}
    folders = [made_recording(tmp_path / str(k), t, **quiet) for k, t in enumerate(("", "late"))]
    first, second = map(open_recording, folders)
    with FrameReader(first) as given, FrameReader(second) as late:
        for frame in range(1, 4):
            before, now = given.frame_set(frame - 1).views, given.frame_set(frame).views
            shown = late.frame_set(frame).views
            np.testing.assert_array_equal(shown["O"].image, before["O"].image)
            np.testing.assert_array_equal(shown["N"].image, now["N"].image)
            assert (now["O"].image != before["O"].image).any()
    sizes = {"views": "O", "frames": 2}
    small = made_recording(tmp_path / "small", "compress=40", **sizes)
    large = made_recording(tmp_path / "large", "compress=20", **sizes)
    assert 3 * (small / "O_left.mp4").stat().st_size < (large / "O_left.mp4").stat().st_size


def test_pictures_depend_on_the_seed_alone_and_empty_scenes_stay(tmp_path):
    every = ",".join(name for name in KINDS if name not in {"rows", "passer"})
    few = {"frames": 2, "views": "N"}
    seeds = {"a": 0, "b": 0, "c": 1}
    one, again, other = (made_recording(tmp_path / k, every, seeds[k], **few) for k in seeds)
    plain = made_recording(tmp_path / "plain", "", **few)
    for file in ("N_left.mp4", "N_right.mp4"):
        assert (one / file).read_bytes() == (again / file).read_bytes()
        assert (one / file).read_bytes() != (other / file).read_bytes()
    for file in ("N_left_background.png", "calibration.toml", "reference.csv"):
        assert (one / file).read_bytes() == (plain / file).read_bytes()


def test_strengths_are_read_or_those_of_the_kind():
    usual = {name: kind.default for name, kind in KINDS.items()}
    assert parsed_disturbances(", ".join(KINDS)) == usual
    assert parsed_disturbances("exposure=0.3") == {"exposure": 0.3}


@pytest.mark.parametrize(
    "wrong",
    ["fog", "gain=0", "noise=-1", "shadow=1.5", "late=1.5", "blur=nan", "gamma=x", "shake,shake=2"],
)
def test_unknown_kinds_and_impossible_strengths_are_refused(tmp_path, capsys, wrong):
    assert main(["simulate", str(tmp_path / "r"), "--disturb", wrong]) == 2
    told = capsys.readouterr().err
    assert "--disturb" in told
    assert all(name in told for name in KINDS)
    assert not (tmp_path / "r").exists()


def test_depth_cameras_are_not_disturbed(tmp_path):
    with pytest.raises(InputError, match="--disturb"):
        made_recording(tmp_path / "r", "gain", kind="depth")


@pytest.mark.slow
def test_fast_keeps_the_arms_in_exposure_and_shadow(tmp_path, capsys):
    film, run = str(tmp_path / "film"), str(tmp_path / "run.npz")
    disturb = ("--disturb", "exposure=0.3,shadow=0.4")
    assert main(["simulate", film, "--person", "P4", "--frames", "60", *disturb]) == 0
    assert main(["track", film, "-o", run, "--preset", "fast"]) == 0
    capsys.readouterr()
    assert main(["evaluate", run, "--json"]) == 0
    errors = json.loads(capsys.readouterr().out)
    assert errors["not_tracked"] == 0
    assert errors["lost_percent"] < 3
    assert errors["measures"]["torso_cross"]["median"] < 5
    assert errors["measures"]["upper_arms"]["median"] < 10
