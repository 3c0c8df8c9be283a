"""A run is repeated from its file alone, and what is different from then is said."""

import json
import shutil

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from tests.same_run import same_run


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
