"""Runs in files: what is read is what was written, and damaged files get a sentence."""

import dataclasses
import json
import shutil

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import is_reference, read_reference, write_reference
from stereotrack_core.interop.run_file import read_run, read_trajectory, run_suffix, write_run
from stereotrack_core.interop.run_npz import run_bytes, run_of_bytes
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.stored import fps_of_run


def assert_same_run(a, b):
    for field in dataclasses.fields(a):
        left, right = getattr(a, field.name), getattr(b, field.name)
        if isinstance(left, np.ndarray):
            assert left.dtype == right.dtype, field.name
            np.testing.assert_array_equal(left, right, err_msg=field.name)
        else:
            assert left == right, field.name


@pytest.mark.parametrize("frame", [range(3, 12), [0, 4, 5, 9], range(0)])
def test_npz_round_trip(tmp_path, random, make_run, frame):
    run = make_run(random, frame)
    write_run(tmp_path / "run.npz", run)
    assert_same_run(read_run(tmp_path / "run.npz"), run)


def test_npz_holds_what_the_format_says(tmp_path, random, make_run):
    write_run(tmp_path / "run.npz", make_run(random))
    with np.load(tmp_path / "run.npz", allow_pickle=False) as stored:
        assert set(stored.files) == {
            *("frame", "landmarks", "landmark_names", "x", "P", "state_names", "tracked"),
            *("coverage", "residual", "innovation", "limb_sigma_deg", "limb_lost"),
            *("seconds", "stage_names", "meta"),
        }
        assert stored["landmark_names"][0] == "left_shoulder"
        assert json.loads(str(stored["meta"]))["preset"] == "accurate"


KEYPOINTS = keypoints_of(
    (frame, camera, name, 10.25 + frame, 1.0 / 3.0, 0.7, "blazepose", 0)
    for frame in (1, 3, 4)
    for camera in ("N", "S")
    for name in ("nose", "left_wrist")
)


@pytest.mark.parametrize("keypoints", [KEYPOINTS, KEYPOINTS[:0]])
def test_keypoints_that_a_run_used_come_back_bit_by_bit(tmp_path, random, make_run, keypoints):
    run, path = dataclasses.replace(make_run(random), keypoints=keypoints), tmp_path / "run.npz"
    write_run(path, run)
    for found in (read_run(path), run_of_bytes(run_bytes(run), "project")):
        assert found.keypoints.fingerprint() == keypoints.fingerprint()
    assert read_run(path).seen(3) is None, "they were given to it"
    seen = dataclasses.replace(run, meta={**run.meta, "detector": "blazepose"})
    assert len(seen.seen(3)) == len(keypoints.of_frame(3))


def test_a_file_of_another_format_is_refused(tmp_path, random, make_run):
    path = tmp_path / "run.npz"
    write_run(path, make_run(random))
    with np.load(path, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    meta = json.loads(str(arrays.pop("meta")))
    assert meta["format"] == 1
    np.savez(path, meta=np.array(json.dumps({**meta, "format": 2})), **arrays)
    with pytest.raises(InputError, match="a run file of format 2, and this program reads format 1"):
        read_run(path)


def test_recording_folder_moves_with_the_run(tmp_path, random, make_run):
    here = tmp_path / "here"
    (here / "recording").mkdir(parents=True)
    run = make_run(random, recording_folder=str(here / "recording"))
    write_run(here / "run.npz", run)
    assert_same_run(read_run(here / "run.npz"), run)
    shutil.copytree(here, tmp_path / "there")
    moved = read_run(tmp_path / "there" / "run.npz")
    assert moved.meta["recording_folder"] == str(tmp_path / "there" / "recording")
    shutil.move(here / "run.npz", tmp_path / "run.npz")
    alone = read_run(tmp_path / "run.npz")
    assert alone.meta["recording_folder"] == str(here / "recording")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("camera", 2, "camera of the keypoints has no name"),
        ("confidence", 1.5, "impossible numbers"),
        ("frame", 9, "order"),
    ],
)
def test_keypoints_that_cannot_be_are_refused(tmp_path, random, make_run, name, value, words):
    path = tmp_path / "run.npz"
    write_run(path, dataclasses.replace(make_run(random), keypoints=KEYPOINTS))
    arrays = dict(np.load(path))
    arrays[f"keypoint_{name}"][0] = value
    np.savez(path, **arrays)
    with pytest.raises(InputError, match=words):
        read_run(path)


def test_suffixes(tmp_path, random, make_run):
    run = make_run(random)
    assert run_suffix(tmp_path / "a.NPZ") == ".npz"
    for name in ("run.pkl", "run"):
        with pytest.raises(InputError, match="suffix"):
            write_run(tmp_path / name, run)
    with pytest.raises(InputError, match="no such file"):
        read_run(tmp_path / "run.csv")
    (tmp_path / "run.csv").touch()
    with pytest.raises(InputError, match="complete run"):
        read_run(tmp_path / "run.csv")
    with pytest.raises(InputError, match="suffix"):
        read_trajectory(tmp_path / "run.bvh")
    with pytest.raises(InputError, match="folder"):
        write_run(tmp_path / "absent" / "run.npz", run)
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(InputError, match="folder"):
        write_run(tmp_path / "folder.npz", run)


@pytest.mark.parametrize("fps", [None, -1])
def test_formats_with_time_need_the_frame_rate(tmp_path, random, make_run, fps):
    run = make_run(random, fps=fps)
    for suffix in (".trc", ".c3d", ".bvh"):
        with pytest.raises(InputError, match="frame rate"):
            write_run(tmp_path / f"run{suffix}", run)
    assert not list(tmp_path.iterdir())
    assert fps_of_run(make_run(random, fps=25)) == 25.0


@pytest.mark.parametrize(
    ("suffix", "tolerance"), [(".npz", 0.0), (".csv", 6e-7), (".trc", 1e-15), (".c3d", 2e-7)]
)
def test_landmarks_come_back_from_every_format(tmp_path, random, make_run, suffix, tolerance):
    run = make_run(random)
    path = tmp_path / f"run{suffix}"
    write_run(path, run)
    found = read_trajectory(path)
    np.testing.assert_array_equal(found.frame, run.frame)
    assert found.fps == (None if suffix == ".csv" else 10.0)
    np.testing.assert_allclose(found.points, run.landmarks, rtol=0, atol=tolerance)
    assert np.isnan(found.points[1]).all()


def reference(frames=5, *, full=True):
    rng = np.random.default_rng(3)
    points = rng.normal(size=(frames, 9, 3))
    points[1, 2] = np.nan
    extra = {}
    if full:
        extra = {
            "covariance": 1e-4 * rng.normal(size=(frames, 9, 3, 3)),
            "limb_sigma_deg": rng.uniform(1, 5, (frames, 6)),
            "filled": rng.uniform(size=frames) > 0.5,
        }
    return Reference(np.arange(3, 3 + frames), points, meta={"annotators": ["Ä"]}, **extra)


@pytest.mark.parametrize("full", [True, False])
def test_round_trip(tmp_path, full):
    path, written = tmp_path / "r.npz", reference(full=full)
    write_reference(path, written)
    read = read_reference(path)
    for name in ("frame", "points", "covariance", "limb_sigma_deg", "filled"):
        one, two = getattr(written, name), getattr(read, name)
        assert (one is None and two is None) or np.array_equal(one, two, equal_nan=True)
    assert (read.landmark_names, read.meta) == (LANDMARKS, {"annotators": ["Ä"]})
    assert is_reference(path)
    assert np.array_equal(read_trajectory(path).points, written.points, equal_nan=True)
