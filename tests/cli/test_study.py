from pathlib import Path

import pytest

from stereotrack_core.cli.commands import command_named, parser_of
from stereotrack_core.cli.jobs import request_of
from stereotrack_core.cli.studies import run as run_command
from stereotrack_core.study.run import StudyRequest
from tests.study.conftest import InThisProcess, study, walks  # noqa: F401 - fixtures

SMALL = (
    *("--preset", "fast", "--init", "tpose", "--frames", "0:2", "--set", "pixel_step=1"),
    *("--set", "data_points=200", "--set", "fit_shape=no", "--set", "search_arms=no"),
)


class Executor(InThisProcess):
    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass


def test_a_study_from_the_first_list_to_the_table(study, tmp_path, run, monkeypatch):  # noqa: F811
    monkeypatch.setattr(run_command, "executor_of", lambda _: Executor())
    made = run("study", "create", tmp_path / "data", "-o", study.path, "--json")
    assert (made.status, made.json["recordings"], made.json["added"]) == (0, 3, [])

    planned = run("study", "run", study.path, *SMALL, "--dry-run", "--json")
    assert planned.json["to_compute"] == 3
    tracked = run("study", "run", study.path, *SMALL, "--select", "subject=ben", "--json")
    assert tracked.status == 0
    assert (tracked.json["computed"], tracked.json["runs"][0]["frames"]) == (1, 2)
    again = run("study", "run", study.path, *SMALL, "--select", "subject=ben")
    assert "0 tracked, 1 there already" in again.out

    told = run("study", "status", study.path, "--json").json["recordings"]
    assert {row["recording"]: row["runs"] for row in told}["data/ben/slow"] == 1
    shown = run("study", "status", study.path, "--select", "subject=ben")
    assert "forearms" in shown.out
    assert "annotated" not in shown.out, "nobody has annotated anything"

    exported = run("study", "export", study.path, "-o", tmp_path / "r.csv", "--json")
    assert exported.json["without_run"] == ["data/anna/fast", "data/anna/slow"]
    assert (tmp_path / "r.csv").read_text("utf-8").count("\n") == exported.json["values"] + 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("create", ".", "-o", "walks.csv"),
        ("status", "missing.study.csv"),
        ("export", "STUDY", "-o", "table.xlsx"),
        ("run", "STUDY", "--select", "sped=slow"),
        ("run", "STUDY", "--workers", "0"),
    ],
)
def test_wrong_input_is_told_in_a_sentence(arguments, study, run):  # noqa: F811
    words = [study.path if word == "STUDY" else word for word in arguments]
    ended = run("study", *words)
    assert ended.status == 2
    assert ended.err.startswith("stereotrack: ")


def test_a_request_is_the_command_that_asks_for_it():
    """Also where a value is none that counts: no retries are 0, not the usual number."""
    request = StudyRequest(
        Path("walks.study.csv"),
        select=("condition=slow",),
        changes=("iterations=3",),
        smooth=True,
        retries=0,
        workers=2,
    )
    args = parser_of(command_named("study")).parse_args(request.arguments()[1:])
    assert request_of(args, StudyRequest) == request
