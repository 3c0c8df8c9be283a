"""Axes of a trajectory of another program, wherever a command reads one."""

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.recording.landmarks import LandmarkTrajectory

pytestmark = pytest.mark.xdist_group("cli")


@pytest.fixture
def truth(recording):
    return read_trajectory(recording / "reference.csv")


@pytest.fixture
def theirs(truth, tmp_path):
    """The recording's reference as TRC, written with z up where the format has y."""
    path = tmp_path / "theirs.trc"
    write_trc(path, LandmarkTrajectory(truth.frame, truth.points[..., [2, 0, 1]]), 10.0)
    return path


@pytest.mark.parametrize(
    "words",
    [
        ("evaluate", "{run}", "--reference", "{theirs}", "--json"),
        ("evaluate", "{run}", "--against", "{theirs}"),
        ("export", "{theirs}", "-o", "{out}.csv"),
        ("track", "{recording}", "--init", "{theirs}", "--frames", "0:1", "-o", "{out}.npz"),
    ],
    ids=lambda words: " ".join(words[:3]),
)
def test_axes_that_the_person_contradicts_are_asked_for(
    run, recording, tracked, theirs, tmp_path, words
):
    places = {"run": tracked, "theirs": theirs, "recording": recording, "out": tmp_path / "out"}
    words = [word.format(**places) for word in words]
    ended = run(*words)
    assert ended.status == 2
    assert "y points up as usual in TRC, but the person's trunk points along z" in ended.err
    assert "--axes x,y,z" in ended.err
    assert not list(tmp_path.glob("out*"))
    ended = run(*words, "--axes", "x,y,z")
    assert ended.status == 0, ended.err
    if "--json" in words:
        own = run("evaluate", tracked, "--json").json["measures"]["torso_position"]["mean"]
        found = ended.json["measures"]["torso_position"]["mean"]
        assert found == pytest.approx(own, rel=1e-6)


def test_nothing_is_stored_until_the_axes_are_stated(run, recording, theirs, truth, tmp_path):
    path = tmp_path / "a.stereotrack"
    Project.create(path, recording, who="A").close()
    assert run("import", "labels", theirs, "--into", path).status == 2
    with Project.open(path, read_only=True) as project:
        assert project.references.names() == ()
    ended = run("import", "labels", theirs, "--into", path, "--axes", "x,y,z")
    assert ended.status == 0
    assert "axes x,y,z (east, north, up) as stated" in ended.err
    with Project.open(path, read_only=True) as project:
        kept = load_reference(project.references, "theirs").points
    np.testing.assert_allclose(kept, truth.points, atol=1e-9, equal_nan=True)


def test_axes_that_begin_with_a_minus_sign(run, theirs, truth, tmp_path):
    out = tmp_path / "out.csv"
    assert run("export", theirs, "-o", out, "--axes", "-x,-y,z").status == 0
    found = read_trajectory(out).points * [-1.0, -1.0, 1.0]
    np.testing.assert_allclose(found, truth.points, atol=1e-5, equal_nan=True)
