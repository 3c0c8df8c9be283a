"""The commands on a tiny rendered recording, from its making to its errors."""

import json
import os
import shutil
import signal
from contextlib import contextmanager
from functools import partial

import pytest

from stereotrack_core.cli import demo, track_plan
from stereotrack_core.interop.run_file import RUN_SUFFIXES, read_run, read_trajectory
from stereotrack_core.tracking.run_spec import RunSpec
from tests.conftest import FAST, QUICK

MEASURES = {
    *("torso_position", "torso_long", "torso_cross", "upper_arms", "forearms"),
    *("left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm"),
}


def test_simulate_says_what_it_made(run, tmp_path):
    small = ("--set", "width=96", "--set", "height=64", "--set", "focal=60")
    ended = run("simulate", tmp_path / "a", "--frames", 2, "--views", "N", *small, "--json")
    assert ended.json["frames"] == 2
    assert (tmp_path / "a" / "recording.toml").is_file()
    assert run("simulate", tmp_path / "a", "--frames", 2, status=2).out == ""
    for wrong in (("--person", "P9"), ("--set", "clothes=silk"), ("--frames", "0")):
        ended = run("simulate", tmp_path / "b", *wrong, status=2)
        assert not (tmp_path / "b").exists()


@pytest.mark.parametrize("suffix", RUN_SUFFIXES)
def test_track_writes_every_format(run, recording, tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    ended = run("track", recording, "-o", path, "--frames", "2:4", *FAST, "--json")
    assert ended.err == ""
    assert ended.json["frames"] == 2
    assert ended.json["run"] == str(path)
    assert path.is_file()
    if suffix != ".bvh":
        assert read_trajectory(path).frame.tolist() == [2, 3]


def test_track_goes_back_over_the_run(run, recording, tracked, tmp_path):
    path = tmp_path / "smooth.npz"
    options = (*FAST, "--frames", ":3", "--smooth", "--json")
    facts = run("track", recording, "-o", path, *options).json
    assert facts["smoothed"]
    assert "smooth" in facts["median_stage_ms"]
    plain, smooth = read_run(tracked), read_run(path)
    assert (plain.meta["smoothed"], smooth.meta["smoothed"]) == (False, True)
    assert (smooth.x[:2] != plain.x[:2]).any(axis=1).all()
    run("evaluate", path, "--json")


@pytest.fixture(scope="module")
def seen(tracked):
    """A later frame in which the run has the person: not all do, in pictures as small as these."""
    stored = read_run(tracked)
    return int(stored.frame[:9][stored.tracked[:9]][-1])


def test_track_goes_on_from_a_file(run, recording, tracked, seen, tmp_path):
    stretch = (*QUICK, "--frames", f"{seen}:{seen + 2}")
    for init in (tracked, recording / "reference.csv"):
        path = tmp_path / "later.npz"
        run("track", recording, "-o", path, "--init", init, *stretch)
        assert read_run(path).meta["init"] == "pose"
    beyond = tmp_path / "short.npz"
    run("track", recording, "-o", beyond, *FAST, "--frames", ":2")
    ended = run("track", recording, "-o", tmp_path / "x.npz", "--init", beyond, *stretch, status=2)
    assert f"frame {seen}" in ended.err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "run.pkl"], "suffix"),
        (["-o", "absent/run.npz"], "no such folder"),
        (["-o", "{recording}/run.npz"], "never written to"),
        (["--init", "nowhere.npz"], "no such file"),
        (["--preset", "luck"], "thesis"),
        (["--set", "luck=1"], "luck"),
        (["--frames", "5:50"], "0:10"),
        (["--views", "NX"], "NX"),
    ],
)
def test_track_refuses_wrong_input_before_working(
    run, recording, tmp_path, monkeypatch, options, words
):
    monkeypatch.chdir(tmp_path)
    options = [text.format(recording=recording) for text in options]
    output = () if "-o" in options else ("-o", "run.npz")
    ended = run("track", recording, *output, *options, status=2)
    assert ended.out == ""
    assert words in ended.err
    assert ended.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_track_that_is_stopped_keeps_what_it_has(run, recording, tmp_path, monkeypatch):
    @contextmanager
    def interrupting(what, total):
        assert total == 10
        yield lambda done, _now: os.kill(os.getpid(), signal.SIGINT) if done == 3 else None

    monkeypatch.setattr(track_plan, "progress", interrupting)
    path = tmp_path / "run.npz"
    ended = run("track", recording, "-o", path, *FAST, "--json", status=1)
    assert "3 of 10" in ended.err
    assert ended.json["stopped"] is True
    assert read_run(path).frame.tolist() == [0, 1, 2]


def test_evaluate_prints_the_measures(run, recording, tracked):
    ended = run("evaluate", tracked, "--segments")
    assert ended.err == ""
    for words in ("torso position [mm]", "forearms [deg]", "left forearm", "lost", "t-pose"):
        assert words in ended.out
    facts = run("evaluate", tracked, "--segments", "--json").json
    assert set(facts["measures"]) == MEASURES
    assert facts["frames"] == 10
    assert facts["frames_per_second"] > 0
    assert facts["lost_limbs"]["judged"] == 4 * (facts["frames"] - facts["not_tracked"])
    assert facts["segments"][0]["name"] == "t-pose"
    forearms = facts["measures"]["forearms"]
    assert forearms["unit"] == "deg"
    assert forearms["median"] <= forearms["p95"]


def test_evaluate_without_truth(run, recording, tmp_path):
    reference = recording / "reference.csv"
    for arguments, words in (
        ([reference], "--reference"),
        ([tmp_path / "none.npz"], "no such file"),
        ([tmp_path / "none.xyz"], "suffix"),
        ([reference, "--reference", reference, "--frames", "50:60"], "none of the frames"),
        ([reference, "--reference", reference, "--frames", "x"], "--frames"),
    ):
        ended = run("evaluate", *arguments, status=2)
        assert ended.out == ""
        assert words in ended.err
    alone = tmp_path / "alone.csv"
    shutil.copy(reference, alone)
    ended = run("evaluate", reference, "--reference", alone, "--segments", status=2)
    assert "segments.csv" in ended.err


def test_cloud(run, recording, tmp_path):
    path = tmp_path / "cloud.ply"
    ended = run("cloud", recording, "--frame", 3, "-o", path, "--json")
    assert ended.json["points"] > 100
    assert sum(ended.json["points_of_view"].values()) == ended.json["points"]
    assert path.read_bytes().startswith(b"ply\nformat binary_little_endian 1.0\n")
    north = run("cloud", recording, "--frame", 3, "-o", path, "--views", "N")
    assert "N" in north.out
    assert "S " not in north.out
    for wrong in (("--frame", 99, "-o", path), ("--frame", 0, "-o", tmp_path / "cloud.obj")):
        assert run("cloud", recording, *wrong, status=2).out == ""


def test_info(run, recording, tmp_path):
    ended = run("info", recording)
    assert "10 at 10 Hz" in ended.out
    assert "stereo" in ended.out
    facts = run("info", recording, "--json").json
    assert facts["content"]["frames"] == 10
    assert [view["name"] for view in facts["content"]["views"]] == ["N", "S"]
    assert not [f for f in facts["findings"] if f["severity"] == "error"]
    space = facts["content"]["working_space"]
    assert (space["up_axis"], space["low_m"]) == ("z", [-1.8, -1.8, 0.0])
    assert set(space["disparities_px"]) == set(space["searched_m"]) == {"N", "S"}
    assert "x -1.80 to 1.80" in ended.out
    broken = tmp_path / "broken"
    shutil.copytree(recording, broken)
    text = (broken / "recording.toml").read_text()
    (broken / "recording.toml").write_text(text.replace("fps = ", "speed = "))
    ended = run("info", broken, "--json", status=2)
    assert "fps" in json.dumps(ended.json["findings"])
    assert "in" in ended.err
    run("info", tmp_path / "none", status=2)


def test_demo_headless(run, recording, tmp_path, monkeypatch):
    shutil.copytree(recording, tmp_path / "demo" / "recording")
    monkeypatch.setattr(demo, "RunSpec", partial(RunSpec, init="tpose"))
    ended = run("demo", tmp_path / "demo", "--headless", *QUICK)
    assert "forearms [deg]" in ended.out
    assert "t-pose" in ended.out
    assert str(tmp_path / "demo" / "run.npz") in ended.err
    assert read_run(tmp_path / "demo" / "run.npz").frame.size == 10
    facts = run("demo", tmp_path / "demo", "--headless", *QUICK, "--json").json
    assert set(facts["measures"]) == MEASURES
    (tmp_path / "file").write_text("")
    run("demo", tmp_path / "file", "--headless", status=2)
