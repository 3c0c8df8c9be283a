"""Sweeps as a command: what is known is not computed again."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stereotrack_core.cli import study
from stereotrack_core.locks import is_held
from stereotrack_core.program import main
from stereotrack_core.study.store import journal_of, stored_results
from tests.study.conftest import InThisProcess

QUICK = (
    *("--preset", "fast", "--frames", "0:2", "--init", "tpose", "--set", "search_arms=no"),
    *("--set", "data_points=200", "--set", "fit_shape=no"),
)
GRID = ("--grid", "iterations=2", "--grid", "views=N,NS", "--seeds", "0,1")


@pytest.fixture
def here(monkeypatch):
    """Lets sweeps compute in this process."""
    monkeypatch.setattr(study, "workers_of", lambda _: InThisProcess())


def rows_of(table):
    return list(csv.DictReader(Path(table).read_text().splitlines()))


@pytest.fixture(scope="module")
def swept(recording, tmp_path_factory):
    """A finished sweep of four jobs."""
    table = tmp_path_factory.mktemp("sweep") / "sweep.csv"
    patch = pytest.MonkeyPatch()
    patch.setattr(study, "workers_of", lambda _: InThisProcess())
    words = ("sweep", recording, *QUICK, *GRID, "-o", table, "--workers", 1)
    assert main([str(word) for word in words]) == 0
    patch.undo()
    return table


def test_the_table_has_a_row_for_every_job(swept, recording):
    rows = rows_of(swept)
    assert len(rows) == len({row["job"] for row in rows}) == 4
    assert list(rows[0])[:5] == ["recording", "iterations", "views", "seed", "status"]
    assert {row["status"] for row in rows} == {"done"}
    assert {(row["views"], row["seed"]) for row in rows} == {
        (v, s) for v in ("N", "NS") for s in "01"
    }
    for row in rows:
        assert float(row["forearms"]) >= 0
        assert float(row["frames_per_second"]) > 0
        assert (row["iterations"], row["frames"]) == ("2", "2")
    assert not is_held(swept, unsure=False)


def test_the_same_command_computes_nothing_and_more_computes_the_rest(run, recording, swept):
    command = ("sweep", recording, *QUICK, *GRID, "-o", swept, "--workers", 1, "--json")
    before = swept.read_text()
    ended = run(*command)
    told = ended.json
    assert (told["jobs"], told["computed"], told["reused"]) == (4, 0, 4)
    assert swept.read_text() == before
    assert len(told["points"]) == 2
    best = [point["mean"]["forearms"] for point in told["points"]]
    assert best == sorted(best)
    assert all(point["runs"] == 2 for point in told["points"])
    table = run(*(word for word in command if word != "--json"))
    assert "0 computed, 4 reused" in table.out
    assert "best forearms first" in table.out


def test_results_that_failed_are_tried_again(run, recording, swept, tmp_path, here):
    table = Path(shutil.copy(swept, tmp_path))
    journal = Path(shutil.copy(journal_of(swept), journal_of(table)))
    command = ("sweep", recording, *QUICK, *GRID, "-o", table, "--workers", 1)
    lines = journal.read_text().splitlines()
    spoilt = {**json.loads(lines[0]), "status": "failed", "error": "no room", "measures": {}}
    journal.write_text("\n".join([*lines[1:], json.dumps(spoilt)]) + "\n")
    told = run(*command, "--json").json
    assert (told["computed"], told["reused"], told["failed"]) == (1, 3, 0)


@pytest.mark.slow
def test_a_sweep_that_is_stopped_says_how_it_goes_on(recording, tmp_path):
    table = tmp_path / "sweep.csv"
    code = "import sys; from stereotrack_core.program import main; sys.exit(main(sys.argv[1:]))"
    words = ["sweep", recording, *QUICK, *GRID, "-o", table, "--workers", 1]
    command = [sys.executable, "-c", code, *map(str, words)]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 120
    while not stored_results(table):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < until
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=120)
    if len(stored_results(table)) < 4:
        assert process.returncode == 1
        assert "run the same command again to continue" in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--grid", "points=3"), "unknown parameter 'points'"),
        (("--workers", "2", "--scheduler", "tcp://a:1"), "one of them"),
        (("--grid", "views=NX"), "no view"),
        (("--seeds", "0,0"), "list of seeds"),
    ],
)
def test_what_cannot_be_meant_is_refused(run, recording, tmp_path, arguments, words):
    ended = run("sweep", recording, *QUICK, "-o", tmp_path / "sweep.csv", *arguments, status=2)
    assert words in ended.err
    assert not list(tmp_path.iterdir())


def test_a_file_that_is_something_else_is_not_written_over(run, recording, tmp_path):
    table = tmp_path / "mine.csv"
    table.write_text("a,b\n1,2\n")
    assert "not a sweep table" in run("sweep", recording, *QUICK, "-o", table, status=2).err
    assert table.read_text() == "a,b\n1,2\n"
    run("sweep", recording, recording, *QUICK, "-o", tmp_path / "a.csv", status=2)
