"""Detections given to ``track``."""

import shutil

import numpy as np

from stereotrack_core.interop.run_file import read_run
from tests.conftest import FAST

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
