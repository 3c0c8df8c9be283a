"""Trajectories of other programs: of other rates, numberings and axes."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run, read_trajectory, write_run
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from tests.recording.small import STANDING


def waving(frames, fps):
    """Somebody who lowers and raises both arms within two seconds, seen at some frames."""
    angle = np.pi / 4 * np.sin(np.pi * np.asarray(frames) / fps)
    points = np.tile(STANDING, (len(angle), 1, 1))
    for name in LANDMARKS[2:6]:
        side = LANDMARKS.index(f"{name.split('_')[0]}_shoulder")
        arm = STANDING[LANDMARKS.index(name)] - STANDING[side]
        reach = abs(arm[0])
        points[:, LANDMARKS.index(name), 0] = STANDING[side, 0] + arm[0] * np.cos(angle)
        points[:, LANDMARKS.index(name), 2] = STANDING[side, 2] + reach * np.sin(angle)
    return LandmarkTrajectory(np.asarray(frames, dtype=np.int64), points)


def renumbered(path):
    """Let a TRC file count from 1."""
    lines = path.read_text().splitlines()
    lines[5:] = ["\t".join([str(k), *line.split("\t")[1:]]) for k, line in enumerate(lines[5:], 1)]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def moving(tracked, tmp_path):
    """A run of the tiny recording, whose landmarks are those of somebody who waves."""
    stored = read_run(tracked)
    points = waving(stored.frame, 10.0).points
    write_run(tmp_path / "moving.npz", replace(stored, landmarks=points))
    return tmp_path / "moving.npz"


@pytest.fixture
def fast(tmp_path):
    """The same at 100 Hz, for longer than the recording."""
    write_trc(tmp_path / "mocap.trc", waving(range(150), 100.0), 100.0)
    return renumbered(tmp_path / "mocap.trc")


def check_times(facts):
    """All ten frames are compared, and with the right instants: the arms move by 14 deg a frame."""
    assert facts["frames"] == 10
    assert facts["not_tracked"] == 0
    assert facts["measures"]["forearms"]["mean"] < 1e-3


def test_evaluate_takes_a_reference_of_another_rate_by_time(run, moving, fast):
    ended = run("evaluate", moving, "--reference", fast, "--json")
    check_times(ended.json)
    assert "row of frame 1 has the time 0 s, which is frame 0" in ended.err
    assert "it has 100 frames per second, the recording 10. It was resampled by time." in ended.err
    assert "longer than the recording of 10 frames: 5 of its 15 frames lie after it" in ended.err


def test_an_import_becomes_a_reference_at_the_recordings_frames(run, recording, fast, tmp_path):
    project = tmp_path / "p.stereotrack"
    Project.create(project, recording).close()
    ended = run("import", "labels", fast, "--into", project, "--json")
    assert ended.json == {"reference": "mocap", "frames": 10}
    assert "5 of its 15 frames lie after it" in ended.err
    with Project.open(project, read_only=True) as opened:
        kept = load_reference(opened.references, "mocap")
    assert (kept.fps, kept.meta["resampled_from_fps"]) == (10.0, 100.0)
    np.testing.assert_allclose(kept.points, waving(range(10), 10.0).points, atol=1e-9)
    write_trc(tmp_path / "late.trc", waving(range(900, 950), 10.0), 10.0)
    ended = run("import", "labels", tmp_path / "late.trc", "--into", project, status=2)
    assert "contains none of the frames 0 to 9 of the recording" in ended.err


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
    ended = run(*words, status=2)
    assert "y points up as usual in TRC, but the person's trunk points along z" in ended.err
    assert "--axes x,y,z" in ended.err
    assert not list(tmp_path.glob("out*"))
    ended = run(*words, "--axes", "x,y,z")
    if "--json" in words:
        own = run("evaluate", tracked, "--json").json["measures"]["torso_position"]["mean"]
        found = ended.json["measures"]["torso_position"]["mean"]
        assert found == pytest.approx(own, rel=1e-6)


def test_nothing_is_stored_until_the_axes_are_stated(run, recording, theirs, truth, tmp_path):
    path = tmp_path / "a.stereotrack"
    Project.create(path, recording, who="A").close()
    run("import", "labels", theirs, "--into", path, status=2)
    with Project.open(path, read_only=True) as project:
        assert project.references.names() == ()
    ended = run("import", "labels", theirs, "--into", path, "--axes", "x,y,z")
    assert "axes x,y,z (east, north, up) as stated" in ended.err
    with Project.open(path, read_only=True) as project:
        kept = load_reference(project.references, "theirs").points
    np.testing.assert_allclose(kept, truth.points, atol=1e-9, equal_nan=True)


def test_axes_that_begin_with_a_minus_sign(run, theirs, truth, tmp_path):
    out = tmp_path / "out.csv"
    run("export", theirs, "-o", out, "--axes", "-x,-y,z")
    found = read_trajectory(out).points * [-1.0, -1.0, 1.0]
    np.testing.assert_allclose(found, truth.points, atol=1e-5, equal_nan=True)
