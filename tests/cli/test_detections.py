"""Detections given to ``track``."""

import shutil

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.program import main

pytestmark = pytest.mark.xdist_group("cli")
HEADER = "frame,view,kind,x,y,z,sigma,confidence\n"


GIVEN = ("--preset", "fast", "--init", "tpose", "--set", "fit_shape=no", "--frames", "0:3")


@pytest.fixture(scope="module")
def plain(recording, tmp_path_factory):
    """Landmarks of three frames without detections."""
    output = tmp_path_factory.mktemp("plain") / "run.npz"
    assert main(["track", str(recording), "-o", str(output), *GIVEN]) == 0
    return read_run(output).landmarks


@pytest.fixture
def track(run, tmp_path):
    """Function from a recording and options to the landmarks of three frames."""

    def tracked(folder, *options):
        output = tmp_path / "run.npz"
        run("track", folder, "-o", output, *GIVEN, *options)
        return read_run(output).landmarks

    return tracked


def test_a_file_of_detections_takes_part(track, plain, recording, tmp_path):
    seen = np.flatnonzero(np.isfinite(plain[:, 6, 0]))
    assert len(seen)
    heads = {k: plain[k, 6] + [0.0, 0.04, 0.0] for k in seen}
    rows = [f"{k},,head,{x},{y},{z},0.005,1\n" for k, (x, y, z) in heads.items()]
    rows += [f"{k - 0.5},,head,{x},{y},{z},0.005,1\n" for k, (x, y, z) in heads.items()]
    other = tmp_path / "with-its-own"
    shutil.copytree(recording, other)
    (other / "detections.csv").write_text(HEADER + "".join(rows))
    moved = (track(other) - plain)[seen, 6, 1]
    assert np.nanmax(moved) > 0.01
    assert not np.nanmin(moved) < 0.0


def test_a_wrong_file_is_told_before_any_work(run, recording, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(recording, other)
    (other / "detections.csv").write_text("frame,kind\n")
    assert "detections.csv" in run("track", other, "-o", tmp_path / "a.npz", status=2).err
    assert not (tmp_path / "a.npz").exists()
