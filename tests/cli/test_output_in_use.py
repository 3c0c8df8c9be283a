"""Long work whose output another process is writing is refused before it begins."""

import os

import pytest

from stereotrack_core import locks
from stereotrack_core.locks import FileLock

CALIBRATE = ("calibrate", "intrinsics", "--images", "a*.png", "--camera", "a")


@pytest.fixture(autouse=True)
def _no_patience(monkeypatch):
    monkeypatch.setattr(locks, "_TRY_SECONDS", 0.0)


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("track", "RECORDING"), "run.npz"),
        (("detect", "RECORDING", "--model", "no model.onnx"), "keypoints.csv"),
        ((*CALIBRATE, "--board", "7x5", "--square", "0.03"), "lens.toml"),
    ],
)
def test_the_second_process_is_refused_before_it_works(run, recording, tmp_path, words, name):
    output = tmp_path / name
    lock = FileLock(output)
    said = [recording if word == "RECORDING" else word for word in words]
    ended = run(*said, "-o", output, status=2)
    lock.release()
    assert f"being written by process {os.getpid()} on " in ended.err
    assert "choose another output" in ended.err
    assert not list(tmp_path.iterdir())
