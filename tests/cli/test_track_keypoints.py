"""``stereotrack track --keypoints``: mono views, from a detector's file and from a project."""

from __future__ import annotations

import pytest

from stereotrack_core.interop.keypoints.table import write_table
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.project.project import Project
from stereotrack_core.simulation.keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import FRAMES, mono_recording, truth

pytestmark = pytest.mark.xdist_group("cli")


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
    assert ended.status == 0, ended.err
    assert ended.json["tracked"] == FRAMES
    project = tmp_path / "mono.stereotrack"
    Project.create(project, folder, who="A").close()
    assert run("import", "predictions", file, "--into", project).status == 0
    assert run("track", folder, "-o", second, "--keypoints", project).status == 0
    runs = [read_npz(path) for path in (first, second)]
    assert runs[0].meta["keypoints"] == runs[1].meta["keypoints"]
    assert (runs[0].x == runs[1].x).all()
    again = ("track", folder, "-o", tmp_path / "again.npz", "--like", first)
    assert "the run used keypoints of simulated" in run(*again).err
    ended = run(*again, "--keypoints", file)
    assert ended.status == 0, ended.err


def test_what_cannot_be_followed_is_said(run, mono, tmp_path):
    folder, file = mono
    out = ("-o", tmp_path / "run.npz")
    assert "stereotrack track --keypoints" in run("track", folder, *out).err
    thesis = run("track", folder, *out, "--keypoints", file, "--preset", "thesis")
    assert thesis.status == 2
    assert "this preset does not use keypoints" in thesis.err
