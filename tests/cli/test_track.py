"""Runs of ``track`` with what a person gives it: presets, detections, keypoints, another run."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.interop.keypoints.reading import write_table
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.project.project import Project
from stereotrack_core.tracking.presets import UserPreset, preset, write_preset
from tests.conftest import FAST
from tests.same_run import same_run
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import FRAMES, mono_recording, truth


def test_a_file_is_a_preset_to_track_with(run, recording, tmp_path):
    own = tmp_path / "own.toml"
    write_preset(own, UserPreset("few points", "fast", {"data_points": 300, "fit_shape": False}))
    words = ("--preset", "fast", "--set", "data_points=300", "--set", "fit_shape=no")
    for name, arguments in {"file": ("--preset", own), "words": words}.items():
        more = ("-o", tmp_path / f"{name}.npz", "--frames", "0:2", "--init", "tpose")
        run("track", recording, *arguments, *more)
    by_file, by_words = (read_run(tmp_path / f"{name}.npz") for name in ("file", "words"))
    np.testing.assert_array_equal(by_file.x, by_words.x)
    assert by_file.meta["preset"] == "few points", "a path says nothing to a reader"
    changed = preset("fast").replaced(data_points=300, fit_shape=False)
    assert by_file.meta["parameters"] == changed.values()


HEADER = "frame,view,kind,x,y,z,sigma,confidence\n"


def test_a_file_of_detections_takes_part(run, recording, tracked, tmp_path):
    plain = read_run(tracked).landmarks[:3]
    seen = np.flatnonzero(np.isfinite(plain[:, 6, 0]))
    assert len(seen)
    heads = {k: plain[k, 6] + [0.0, 0.04, 0.0] for k in seen}
    rows = [f"{k},,head,{x},{y},{z},0.005,1\n" for k, (x, y, z) in heads.items()]
    rows += [f"{k - 0.5},,head,{x},{y},{z},0.005,1\n" for k, (x, y, z) in heads.items()]
    other = tmp_path / "with-its-own"
    shutil.copytree(recording, other)
    (other / "detections.csv").write_text(HEADER + "".join(rows))
    run("track", other, "-o", tmp_path / "run.npz", *FAST, "--frames", "0:3")
    moved = (read_run(tmp_path / "run.npz").landmarks - plain)[seen, 6, 1]
    assert np.nanmax(moved) > 0.01
    assert not np.nanmin(moved) < 0.0


def test_a_wrong_file_is_told_before_any_work(run, recording, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(recording, other)
    (other / "detections.csv").write_text("frame,kind\n")
    assert "detections.csv" in run("track", other, "-o", tmp_path / "a.npz", status=2).err
    assert not (tmp_path / "a.npz").exists()


@pytest.fixture
def mono(tmp_path):
    """Folder of four mono views, and a file of keypoints."""
    (tmp_path / "mono").mkdir()
    recording = mono_recording(tmp_path / "mono")
    keypoints = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=0.3))
    path = tmp_path / "keypoints.csv"
    write_table(path, keypoints, recording)
    return recording.folder, path


def test_a_file_and_a_project_give_the_same_run(run, mono, tmp_path):
    folder, file = mono
    first, second = tmp_path / "first.npz", tmp_path / "second.npz"
    ended = run("track", folder, "-o", first, "--keypoints", file, "--json")
    assert ended.json["tracked"] == FRAMES
    project = tmp_path / "mono.stereotrack"
    Project.create(project, folder, who="A").close()
    run("import", "predictions", file, "--into", project)
    run("track", folder, "-o", second, "--keypoints", project)
    runs = [read_npz(path) for path in (first, second)]
    assert runs[0].meta["keypoints"] == runs[1].meta["keypoints"]
    assert (runs[0].x == runs[1].x).all()
    again = ("track", folder, "-o", tmp_path / "again.npz", "--like", first)
    for more in ((), ("--keypoints", file)):  # the run holds those that it used
        ended = run(*again, *more)
        assert (read_npz(tmp_path / "again.npz").x == runs[0].x).all()
    write_npz(first, replace(runs[0], keypoints=None))  # as older versions wrote it
    assert "the run used keypoints of simulated" in run(*again, status=2).err


def test_one_of_two_people_is_tracked_by_name(run, mono, tmp_path):
    folder, file = mono
    header, *lines = file.read_text().splitlines()
    both = [header]
    for line in lines:
        cells = line.split(",")
        both.append(",".join((*cells[:6], "patient", cells[7])))
        x = str(float(cells[3]) + 25.0)
        sure = "0.99" if int(cells[0]) % 2 else "0.2"
        both.append(",".join((*cells[:3], x, cells[4], sure, "therapist", cells[7])))
    file.write_text("\n".join(both) + "\n")
    out = ("-o", tmp_path / "run.npz", "--keypoints", file)
    ended = run("track", folder, *out, "--person", "patient", "--json")
    assert ended.json["warnings"] == []
    assert "2 people (patient, therapist): patient is kept in all frames, as stated" in ended.err
    assert "would have changed" in ended.err
    nobody = run("track", folder, *out, "--person", "nurse", status=2)
    assert "no person 'nurse'" in nobody.err
    assert "patient, therapist" in nobody.err
    alone = run("track", folder, "-o", tmp_path / "a.npz", "--layout", "coco17", status=2)
    assert "Give the keypoints with --keypoints" in alone.err


@pytest.fixture(scope="module")
def first(recording, tmp_path_factory):
    """Frames 2 to 5, begun with a given pose, by another seed, gone over backwards."""
    from stereotrack_core.program import main

    path = tmp_path_factory.mktemp("like") / "first.npz"
    chosen = ("--frames", "2:5", "--seed", "7", "--views", "NS", "--smooth")
    settings = ("--preset", "fast", "--set", "iterations=2", "--set", "least_focal=0")
    begin = ("--init", recording / "reference.csv")
    command = ("track", recording, "-o", path, *settings, *chosen, *begin)
    assert main([str(word) for word in command]) == 0
    return path


def test_a_run_is_repeated_to_the_last_bit(run, recording, first, tmp_path):
    again = tmp_path / "again.npz"
    run("track", recording, "--like", first, "-o", again)
    assert same_run(read_run(first), read_run(again))
    meta, new = dict(read_run(first).meta), dict(read_run(again).meta)
    for changing in ("made", "wall_seconds", "recording_folder"):
        meta.pop(changing)
        new.pop(changing)
    assert new == meta


def test_what_is_given_wins(run, recording, first, tmp_path):
    again = tmp_path / "again.npz"
    run("track", recording, "--like", first, "-o", again, "--seed", 8, "--set", "fit_shape=no")
    meta = read_run(again).meta
    assert (meta["seed"], meta["frames"]) == (8, [2, 5])
    assert (meta["parameters"]["iterations"], meta["parameters"]["fit_shape"]) == (2, False)


def test_another_recording_calibration_and_version_are_said(run, recording, first, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(recording, other)
    text = (other / "calibration.toml").read_text()
    number = next(word for word in text.replace(",", " ").split() if word.startswith("200"))
    (other / "calibration.toml").write_text(text.replace(number, "201.0"))
    aged = tmp_path / "aged.npz"
    with np.load(first) as stored:
        arrays = dict(stored)
    meta = json.loads(str(arrays["meta"]))
    meta["versions"]["numpy"] = "1.0"
    np.savez(aged, **{**arrays, "meta": np.array(json.dumps(meta))})
    ended = run("track", other, "--like", aged, "-o", tmp_path / "x.npz", "--frames", "2:3")
    assert "not the recording that" in ended.err
    assert "not the calibration that" in ended.err
    assert "numpy 1.0 then" in ended.err


@pytest.mark.parametrize("less", ["frames", "girdle"])
def test_a_run_that_another_version_made_is_refused(run, recording, first, tmp_path, less):
    with np.load(first) as stored:
        arrays = dict(stored)
    meta = json.loads(str(arrays["meta"]))
    (meta if less in meta else meta["parameters"]).pop(less)
    other = tmp_path / "other.npz"
    np.savez(other, **{**arrays, "meta": np.array(json.dumps(meta))})
    assert read_run(other).meta["preset"] == "fast"
    ended = run("track", recording, "--like", other, "-o", tmp_path / "x.npz", status=2)
    assert "Track the recording again" in ended.err
