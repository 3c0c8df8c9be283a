"""Commands compare trajectories of other rates and numberings by their times."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.interop.c3d import write_c3d
from stereotrack_core.interop.run_file import read_run, read_trajectory, write_run
from stereotrack_core.interop.trc import write_trc
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory, write_landmarks

pytestmark = pytest.mark.xdist_group("cli")

_STANDING = np.array(
    [[-0.2, 0, 1.4], [0.2, 0, 1.4], [-0.45, 0, 1.4], [0.45, 0, 1.4], [-0.7, 0, 1.4],
     [0.7, 0, 1.4], [0, 0, 1.65], [-0.1, 0, 0.9], [0.1, 0, 0.9]]
)  # fmt: skip


def waving(frames, fps):
    """Somebody who lowers and raises both arms within two seconds, seen at some frames."""
    angle = np.pi / 4 * np.sin(np.pi * np.asarray(frames) / fps)
    points = np.tile(_STANDING, (len(angle), 1, 1))
    for name in LANDMARKS[2:6]:
        side = LANDMARKS.index(f"{name.split('_')[0]}_shoulder")
        arm = _STANDING[LANDMARKS.index(name)] - _STANDING[side]
        reach = abs(arm[0])
        points[:, LANDMARKS.index(name), 0] = _STANDING[side, 0] + arm[0] * np.cos(angle)
        points[:, LANDMARKS.index(name), 2] = _STANDING[side, 2] + reach * np.sin(angle)
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


@pytest.mark.parametrize("kind", ["trc", "c3d", "csv", "npz"])
def test_trajectories_of_every_kind_keep_their_rate(run, moving, tmp_path, kind):
    path, truth = tmp_path / f"mocap.{kind}", waving(range(0, 100, 5), 100.0)
    truth = LandmarkTrajectory(truth.frame // 5, truth.points)  # 20 Hz
    if kind == "npz":
        write_trc(tmp_path / "a.trc", truth, 20.0)
        project = tmp_path / "p.stereotrack"
        Project.create(project, Path(read_run(moving).meta["recording_folder"])).close()
        assert run("import", "labels", tmp_path / "a.trc", "--into", project).status == 0
        assert run("export", project, "--format", "npz", "--reference", "-o", path).status == 0
    elif kind == "csv":
        write_landmarks(path, truth)
        rows = path.read_text().splitlines()
        rows = [f"{row},{int(row.split(',')[0]) / 20}" for row in rows[1:]]
        path.write_text("\n".join(["frame,landmark,x,y,z,time", *rows]))
    else:
        {"trc": write_trc, "c3d": write_c3d}[kind](path, truth, 20.0)
    check_times(run("evaluate", moving, "--reference", path, "--json").json)
    assert read_trajectory(path).fps == (10.0 if kind == "npz" else 20.0)


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
    ended = run("import", "labels", tmp_path / "late.trc", "--into", project)
    assert ended.status == 2
    assert "contains none of the frames 0 to 9 of the recording" in ended.err
