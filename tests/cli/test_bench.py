"""The benchmarks as a command; their figures are checked where they are measured."""

import json
import subprocess
from functools import partial

import pytest

from stereotrack_core.cli import bench
from stereotrack_core.experiments.benchmark import speed
from stereotrack_core.program import main
from stereotrack_core.tracking.run_spec import RunSpec
from tests.cli.conftest import WINDOW

pytestmark = pytest.mark.xdist_group("cli")


@pytest.fixture
def from_t_pose(monkeypatch):
    """Begin runs that are timed with the T pose, and time them soon: nothing is looked for."""
    monkeypatch.setattr(speed, "RunSpec", partial(RunSpec, init="tpose"))
    monkeypatch.setattr(speed, "FIT_FRAMES", 1)


@pytest.fixture
def few_sizes(monkeypatch):
    whole = speed.correction_speed
    monkeypatch.setattr(bench, "correction_speed", lambda **kw: whole((8, 32), budget=0.01))


def test_correction_alone(run, few_sizes):
    ended = run("bench", "--only", "correction", "--json")
    assert ended.status == 0
    assert [size["m"] for size in ended.json["correction"]["sizes"]] == [8, 32]
    assert "chain" not in ended.json
    assert "correction" in ended.err
    assert "m^" in run("bench", "--only", "correction").out


def test_chain_alone(run, recording, monkeypatch, from_t_pose):
    whole, small = bench.chain_speed, {"search_proposals": 30, "data_points": 400}

    def chain_speed(recording, presets, **how):
        less = {name: one.replaced(**small, fit_shape=False) for name, one in presets.items()}
        return whole(recording, less, **how)

    monkeypatch.setattr(bench, "chain_speed", chain_speed)
    ended = run("bench", recording, "--only", "chain", "--frames", 2, "--rounds", 1, "--json")
    assert ended.status == 0
    assert [row["preset"] for row in ended.json["chain"]] == ["fast", "accurate", "thesis"]
    for row in ended.json["chain"]:
        assert row["ratio"] == pytest.approx(row["seconds"] / row["matching_seconds"])


def test_what_is_no_recording_is_said_before_anything_is_measured(run, tmp_path):
    ended = run("bench", tmp_path)
    assert ended.status == 2
    assert ended.err.startswith("stereotrack: ")


def window(monkeypatch, stdout="", *, fails=False):
    def measured(command, **_):
        assert "run_module('app.bench', " in command[2]
        if fails:
            raise subprocess.CalledProcessError(1, command, "", "no screen\n")
        return subprocess.CompletedProcess(command, 0, stdout, "")

    monkeypatch.setattr(bench.subprocess, "run", measured)


def test_window_figures_are_read(run, recording, monkeypatch):
    window(monkeypatch, json.dumps({"frame_step_ms": 31.25}))
    ended = run("bench", recording, "--only", "window", "--json", window=WINDOW)
    assert ended.json["window"] == {"frame_step_ms": 31.25}
    assert "frame step ms" in run("bench", recording, "--only", "window", window=WINDOW).out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fails": True}, "no screen"),
        ({"stdout": "hello"}, "could not be timed"),
    ],
)
def test_window_that_cannot_be_measured(run, recording, monkeypatch, options, words):
    window(monkeypatch, **options)
    ended = run("bench", recording, "--only", "window", "--json", window=WINDOW)
    assert ended.status == 0
    assert ended.json["window"] is None
    assert words in ended.err


def test_window_without_the_workbench(recording, capsys):
    assert main(["bench", str(recording), "--only", "window", "--json"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["window"] is None
    assert "not installed" in printed.err


@pytest.mark.parametrize("load", [0.0, 3.0])
def test_busy_machine_is_told(run, few_sizes, monkeypatch, load):
    monkeypatch.setattr(bench, "_load_per_core", lambda: load)
    ended = run("bench", "--only", "correction", "--json")
    assert ended.json["load_per_core"] == load
    assert ("busy" in ended.err) == (load > 1)
