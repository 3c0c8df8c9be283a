import dataclasses
import shutil

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.study.description import (
    Study,
    StudyRecording,
    StudySettings,
    read_study,
    selected,
    with_recordings,
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


def test_listing_again_adds_what_is_new_and_keeps_what_a_person_wrote(study, tmp_path):
    first = study.rows[0]
    written = dataclasses.replace(first, factors={"subject": "Anna B", "shoes": "old"})
    study = dataclasses.replace(study, rows=(*study.rows[:0:-1], written))
    shutil.copytree(tmp_path / "data/ben/slow", tmp_path / "data/ben/fast")
    Project.create(tmp_path / "data/ben/fast.stereotrack", tmp_path / "data/ben/fast").close()

    made = with_recordings(study, [tmp_path / "data"])
    assert made.added == ("data/ben/fast",)
    rows = {row.recording: row for row in made.study.rows}
    assert list(rows)[:3] == [row.recording for row in study.rows]
    assert rows[first.recording] == written
    assert rows["data/ben/fast"].project == "data/ben/fast.stereotrack"
