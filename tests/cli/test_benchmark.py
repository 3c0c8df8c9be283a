"""The benchmark as a command."""

import csv
import dataclasses
import shutil

import pytest

from stereotrack_core.cli import benchmark
from stereotrack_core.cli.benchmark import in_full, readable
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.experiments.benchmark import growth, speed
from stereotrack_core.experiments.benchmark.accuracy import ABLATIONS, MEASURES, Row
from stereotrack_core.recording.folder import open_recordings
from stereotrack_core.tracking.run_spec import RunSpec

pytestmark = pytest.mark.xdist_group("cli")
SMALL = ("--set", "search_proposals=30", "--set", "data_points=400")
QUICK = ("--frames", "0:3", "--init", "tpose", *SMALL)


@pytest.fixture(autouse=True)
def from_t_pose(monkeypatch):
    """Begin runs that are timed with the T pose, and time them soon: nothing is looked for."""
    monkeypatch.setattr(speed, "FIT_FRAMES", 1)
    for module in (growth, speed):
        monkeypatch.setattr(module, "RunSpec", begun_in_t_pose)


def begun_in_t_pose(settings, **more):
    return RunSpec(settings, **{**more, "init": "tpose"})


def test_presets_are_compared(run, recording, tmp_path):
    table = tmp_path / "table.csv"
    ended = run(
        *("benchmark", recording, "--presets", "fast,limb-icp", "--seeds", "0,2", "--json"),
        *(*QUICK, "--set", "fit_shape=no", "--speed-frames", 2, "-o", table),
    )
    assert ended.status == 0, ended.err
    rows = ended.json["rows"]
    assert [row["preset"] for row in rows] == ["fast", "limb-icp"]
    for row in rows:
        assert (row["seeds"], row["frames"]) == (2, 3)
        assert 0 < row["mean"]["torso_position"] < 500  # what a frame counts that is not tracked
        assert row["standard_deviation"]["torso_position"] >= 0
        assert row["speed"]["ratio"] > 0
        assert row["speed"]["frames_per_second"] > 0
    assert [score["seed"] for score in ended.json["scores"]] == [0, 2, 0, 2]
    written = list(csv.DictReader(table.read_text().splitlines()))
    for row, stored in zip(rows, written, strict=True):
        assert float(stored["forearms"]) == row["mean"]["forearms"]
        assert float(stored["ratio_to_stereobm"]) == row["speed"]["ratio"]


def test_an_ablation_takes_parts_away(run, recording, tmp_path, monkeypatch):
    few = (ABLATIONS[0], dataclasses.replace(ABLATIONS[-1], name="last"))
    monkeypatch.setattr(benchmark, "ABLATIONS", few)
    table = tmp_path / "table.md"
    ended = run(
        *("benchmark", recording, "--ablation", "--seeds", "1", "--speed-frames", 0),
        *(*QUICK, "--set", "fit_shape=no", "-o", table),
    )
    assert ended.status == 0, ended.err
    assert "Ablation" in ended.out
    lines = table.read_text().splitlines()
    assert [line.split("|")[2].strip() for line in lines[2:5]] == ["accurate", few[0].name, "last"]
    assert "StereoBM" not in lines[0]
    assert "±" not in ended.out


def once(work):
    """The same function, which works the first time and gives that again whatever it is asked."""
    found = []

    def remembered(*given, **more):
        if not found:
            found.append(work(*given, **more))
        return found[0]

    return remembered


def test_growth_is_told_for_points_and_views(run, recording, monkeypatch):
    for name in ("cost_of_points", "cost_of_views"):
        monkeypatch.setattr(benchmark, name, once(getattr(benchmark, name)))
    arguments = ("benchmark", recording, "--growth", *SMALL, "--presets", "fast")
    ended = run(*arguments)
    assert ended.status == 0, ended.err
    assert "grows as points^" in ended.out
    assert "grows as views^" in ended.out
    told = run(*arguments, "--json").json
    assert [(one["recording"], one["preset"]) for one in told] == [(recording.name, "fast")]
    assert [cost["size"] for cost in told[0]["views"]] == [1, 2]
    assert all(cost["milliseconds"] > 0 for cost in [*told[0]["views"], *told[0]["points"]])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--seeds", "0,0"), "list of seeds"),
        (("--seeds", "a"), "list of seeds"),
        (("--seeds=-1",), "list of seeds"),
        (("--presets", "best"), "accurate, thesis, fast"),
        (("--presets", "fast", "--ablation"), "does not compare presets"),
        (("--speed-frames=-1",), "is less than 0"),
        (("-o", "table.xlsx"), ".csv or .md"),
        (("--growth", "-o", "table.csv"), "--output cannot be combined with it"),
        (("--growth", "--ablation"), "--ablation cannot be combined with it"),
        (
            ("--growth", "--frames", "0:3", "--seeds", "1"),
            "--seeds, --frames cannot be combined with it",
        ),
        (("--annotation", "--views", "N"), "--views cannot be combined with it"),
        (("--annotation", "--set", "legs=no"), "nothing is tracked"),
        (("--frames", "5:900"), "exceeds the end"),
        (("--views", "Q"), "no view"),
        (("--set", "data_point=3"), "unknown parameter"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_sentence(run, recording, arguments, words):
    ended = run("benchmark", recording, *arguments)
    assert ended.status == 2
    assert words in ended.err
    assert ended.out == ""


def test_recordings_without_a_reference_are_refused_before_any_work(run, recording, tmp_path):
    folder = tmp_path / "blind"
    shutil.copytree(recording, folder, ignore=shutil.ignore_patterns("reference.csv"))
    lines = (folder / "recording.toml").read_text().splitlines()
    kept = [line for line in lines if not line.startswith("reference")]
    (folder / "recording.toml").write_text("\n".join(kept))
    ended = run("benchmark", recording, folder, *QUICK)
    assert ended.status == 2
    assert "no reference" in ended.err
    assert "Tracking" not in ended.err


def test_recordings_of_the_same_name_are_told_apart(recording, tmp_path):
    copy = shutil.copytree(recording, tmp_path / "copy")
    assert [one.name for one in open_recordings([recording, copy])] == [str(recording), str(copy)]
    assert open_recordings([recording])[0].name != str(recording)
    with pytest.raises(InputError, match="given twice"):
        open_recordings([recording, copy, recording])


def test_frames_without_truth_are_no_annotation(run, recording, tmp_path):
    folder = shutil.copytree(recording, tmp_path / "few")
    reference = folder / "reference.csv"
    rows = reference.read_text().splitlines()
    reference.write_text("\n".join([rows[0], *(row for row in rows if row.startswith("0,"))]))
    ended = run("benchmark", folder, "--annotation", "--frames", "3:6")
    assert ended.status == 2
    assert "contains none of the frames" in ended.err


def test_tables_say_the_spread_only_where_there_is_one():
    several = dict.fromkeys(MEASURES, Spread(12.345, 12.345))
    single = dict.fromkeys(MEASURES, Spread(12.345))
    rows = (Row("r", "a", 3, 9, several), Row("r", "b", 1, 9, single))
    table = readable(rows, [0, 1, 2], "What")
    assert table.rows[0][2:4] == ("12 ± 12", "12.3 ± 12.3")
    assert table.rows[1][2:4] == ("12", "12.3")
    assert "seeds 0, 1, 2" in table.title
    columns, lines = in_full(rows)
    assert len(columns) == len(lines[0]) == 4 + 2 * len(MEASURES)
    assert in_full(()) == (["recording", "preset", "seeds", "frames"], [])
