"""Recordings of real people that this project did not make; skipped where they are absent."""

import pytest

from stereotrack_core.interop.run_file import read_run

SINGLE = ("rgbd-person-00",)
SEQUENCES = tuple(
    f"arms-cross-depth-{s}-{m}" for s in ("s1", "s2") for m in ("cross", "squat", "wave")
)
OTHERS = ("seated-4cam", "seated-4cam-rotated", "beam-4cam")


@pytest.mark.parametrize("name", SINGLE)
def test_a_single_frame_of_four_depth_views_is_tracked(name, shared_recording, tmp_path, run):
    folder, place = shared_recording(name), tmp_path / "run.npz"
    assert run("info", folder, "--json").json["findings"] == []
    assert run("track", folder, "-o", place, "--preset", "fast").status == 0
    stored = read_run(place)
    assert stored.tracked.tolist() == [True]
    assert stored.unexplained_fraction[0] < 0.2
    cloud = run("cloud", folder, "--frame", 0, "-o", tmp_path / "cloud.ply", "--json").json
    assert set(cloud["points_of_view"]) == {"N", "O", "S", "W"}
    assert min(cloud["points_of_view"].values()) > 100


@pytest.mark.parametrize("name", OTHERS)
def test_views_without_depth_are_refused_with_a_sentence(name, shared_recording, tmp_path, run):
    folder = shared_recording(name)
    assert "nothing to track" in run("track", folder, "-o", tmp_path / "run.npz").sentence


@pytest.mark.slow
@pytest.mark.parametrize("name", SEQUENCES)
def test_depth_sequences_are_tracked_throughout(name, shared_recording, tmp_path, run):
    folder, place = shared_recording(name), tmp_path / "run.npz"
    assert run("info", folder, "--deep", "--json").json["findings"] == []
    assert run("track", folder, "-o", place).status == 0
    stored = read_run(place)
    assert stored.tracked.all()
    assert stored.unexplained_fraction.mean() < 0.2
    scored = run("evaluate", place, "--json").json
    assert scored["measures"]["torso_position"]["mean"] < 120.0
    assert scored["measures"]["torso_long"]["mean"] < 15.0
