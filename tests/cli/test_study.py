import pytest

from stereotrack_core.cli import study as study_command
from stereotrack_core.study.description import read_study
from tests.study.conftest import InThisProcess, study, walks  # noqa: F401 - fixtures


def test_a_study_from_the_first_list_to_the_table(study, tmp_path, run, monkeypatch):  # noqa: F811
    monkeypatch.setattr(study_command, "workers_of", lambda _: InThisProcess())
    create = ("study", "create", tmp_path / "data", "-o", study.path)
    made = run(*create, "--frames", "0:2", "--grid", "iterations=2,3", "--json")
    assert (made.json["recordings"], made.json["added"]) == (3, [])
    described = read_study(study.path).settings
    assert (described.preset, described.frames) == ("fast", "0:2"), "only what was given changes"
    assert described.changes == study.settings.changes

    tracked = run("study", "run", study.path, "--select", "subject=ben", "--json")
    assert (tracked.json["computed"], tracked.json["runs"][0]["frames"]) == (2, 2)
    again = run("study", "run", study.path, "--select", "subject=ben")
    assert "0 computed, 2 there already" in again.out

    told = run("study", "status", study.path, "--json").json["recordings"]
    assert {row["recording"]: row["runs"] for row in told}["data/ben/slow"] == "2 of 2"
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
        ("create", ".", "-o", "STUDY", "--grid", "itertions=2"),
        ("status", "missing.study.toml"),
        ("export", "STUDY", "-o", "table.xlsx"),
        ("run", "STUDY", "--select", "sped=slow"),
        ("run", "STUDY", "--workers", "0"),
        ("run", "STUDY", "--workers", "2", "--scheduler", "tcp://a:1"),
    ],
)
def test_wrong_input_is_told_in_a_sentence(arguments, study, run):  # noqa: F811
    words = [study.path if word == "STUDY" else word for word in arguments]
    assert run("study", *words, status=2).err.startswith("stereotrack: ")
