import dataclasses

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.study.description import (
    Study,
    StudyRecording,
    StudySettings,
    read_study,
    selected,
    with_factor,
    write_study,
)

ROWS = tuple(
    StudyRecording(f"data/{subject}/{speed}", factors={"subject": subject, "speed": speed})
    for subject in ("anna", "ben")
    for speed in ("slow", "fast")
)


@pytest.fixture
def made(tmp_path):
    return Study(tmp_path / "walks.study.toml", ROWS)


@pytest.mark.parametrize(
    "settings",
    [
        StudySettings(),
        StudySettings(
            preset="fast",
            changes=("iterations=3", "fit_shape=no", "loss_scale=0.0375"),
            grid=("views=NS,NOSW", "smooth=yes,no"),
            seeds="0,3",
            frames="0:20",
            init="tpose",
        ),
    ],
)
def test_what_is_written_is_read_again(made, settings):
    odd = StudyRecording("data/x", "p, q.stereotrack", "k.csv", {"subject": 'a "b" = 1'})
    study = dataclasses.replace(made, rows=(*ROWS, odd), settings=settings)
    write_study(study)
    assert read_study(study.path) == study


def test_a_table_of_an_earlier_version_is_read(tmp_path):
    path = tmp_path / "a.study.csv"
    path.write_bytes(
        b'\xef\xbb\xbf"recording";subject;project;fingerprint\r\nr1;anna;;f\r\nr2;ben;b.stereotrack;'
    )
    study = read_study(path)
    assert study.path.name == "a.study.toml"
    assert study.rows == (
        StudyRecording("r1", factors={"subject": "anna"}),
        StudyRecording("r2", "b.stereotrack", factors={"subject": "ben"}),
    )


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("sedes = [1]", "unknown key 'sedes'"),
        ("[settings]\nitertions = 2", "unknown parameter"),
        ('preset = "none"', "accurate, thesis, fast"),
        ('[[recording]]\nsubject = "anna"', "has no folder"),
        ('[[recording]]\nrecording = "r"\nvalue = 1', "a column of the results"),
        ('[[recording]]\nrecording = "r"\n[[recording]]\nrecording = "./r"', "listed twice"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(made, text, what):
    made.path.write_text(text, "utf-8")
    with pytest.raises(InputError, match=what) as refused:
        read_study(made.path)
    assert refused.value.remedy
    assert "walks.study.toml" in refused.value.where


@pytest.mark.parametrize(
    ("select", "expected"),
    [
        ([], ["anna/slow", "anna/fast", "ben/slow", "ben/fast"]),
        (["speed=slow", "subject=b*"], ["ben/slow"]),
        (["speed=slow,fast", "subject=ben"], ["ben/slow", "ben/fast"]),
    ],
)
def test_rows_are_selected_by_their_columns(made, select, expected):
    found = [row.recording.removeprefix("data/") for row in selected(made, select)]
    assert found == expected


def test_a_factor_is_set_for_several_recordings(made):
    changed = with_factor(made, ["data/anna/slow", "data/ben/slow"], "shoes", " old  ones ")
    assert [row.cell("shoes") for row in changed.rows] == ["old ones", "", "old ones", ""]
    assert changed.factors == ("subject", "speed", "shoes")
    for name in ("recording", "value", " "):
        with pytest.raises(InputError):
            with_factor(made, ["data/anna/slow"], name, "1")
