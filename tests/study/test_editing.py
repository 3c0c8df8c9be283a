import dataclasses

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.study.create import Pattern
from stereotrack_core.study.editing import (
    values_of,
    with_column,
    with_column_renamed,
    with_names_of_folders,
    with_recordings,
    with_value,
    without,
    without_column,
)
from stereotrack_core.study.file import Study, StudyRow, read_study, write_study

ROWS = tuple(
    StudyRow(f"data/{subject}/{speed}", "", "f", {"subject": subject, "speed": speed})
    for subject in ("anna", "ben")
    for speed in ("slow", "fast")
)


@pytest.fixture
def made(tmp_path):
    return Study(tmp_path / "walks.study.csv", ("subject", "speed"), ROWS)


def column(study, name):
    return [row.factors[name] for row in study.rows]


def again(study):
    """The study as it is read again, which is the same."""
    write_study(study)
    assert read_study(study.path) == study
    return study


def test_recordings_are_added_behind_the_others_with_empty_cells(made):
    new = again(with_recordings(made, [StudyRow("data/cleo/slow", "data/cleo.stereotrack", "g")]))
    assert new.rows[:4] == made.rows
    assert new.rows[4].factors == {"subject": "", "speed": ""}


def test_a_recording_is_listed_once_and_takes_the_project_that_is_named(made):
    again_listed = StudyRow("data/../data/anna/slow", "", "other")
    assert with_recordings(made, [again_listed]) == made
    named = StudyRow("data/anna/slow", "p.stereotrack", "other", {"subject": "x"})
    new = with_recordings(made, [named])
    assert new.rows[0] == dataclasses.replace(made.rows[0], project="p.stereotrack")


def test_rows_are_removed(made):
    new = again(without(made, {"data/anna/slow", "data/ben/fast"}))
    assert [row.recording for row in new.rows] == ["data/anna/fast", "data/ben/slow"]
    assert again(without(made, {row.recording for row in made.rows})).rows == ()


def test_a_value_is_written_into_several_rows(made):
    new = again(with_value(made, {"data/anna/slow", "data/ben/slow"}, "speed", " very\n slow "))
    assert column(new, "speed") == ["very slow", "fast", "very slow", "fast"]
    assert values_of(new, "speed") == ("fast", "very slow")
    assert made.rows == ROWS, "the study before is as it was"


@pytest.mark.parametrize("name", ["recording", "fingerprint", "shoes"])
def test_only_columns_of_a_person_can_be_written(made, name):
    with pytest.raises(InputError, match=name) as refused:
        with_value(made, {"data/anna/slow"}, name, "x")
    assert "subject, speed" in refused.value.remedy


def test_columns_are_added_renamed_and_removed(made):
    ordered = dataclasses.replace(
        made, order=("subject", "recording", "speed", "project", "fingerprint")
    )
    new = again(with_column(ordered, " shoe size "))
    assert new.factors == ("subject", "speed", "shoe size")
    assert column(new, "shoe size") == [""] * 4
    new = again(with_column_renamed(new, "speed", "condition"))
    assert new.columns[:3] == ("subject", "recording", "condition")
    assert column(new, "condition") == column(made, "speed")
    new = again(without_column(new, "subject"))
    assert new.factors == ("condition", "shoe size")
    assert with_column_renamed(new, "condition", " condition ") == new


@pytest.mark.parametrize("name", ["", "  ", "subject", "recording", "value", "a=b", "a;b", "a,b"])
def test_a_name_that_cannot_be_a_column_is_refused(made, name):
    for edit in (lambda: with_column(made, name), lambda: with_column_renamed(made, "speed", name)):
        with pytest.raises(InputError) as refused:
            edit()
        assert refused.value.remedy


@pytest.mark.parametrize(
    "edit", [without_column, lambda study, name: with_value(study, (), name, "")]
)
def test_a_column_that_is_not_there_is_named_with_one_like_it(made, edit):
    with pytest.raises(InputError, match="no column 'sped'") as refused:
        edit(made, "sped")
    assert "Did you mean speed?" in refused.value.remedy


def test_empty_cells_are_filled_from_the_names_of_folders(made):
    emptied = with_value(made, {"data/anna/fast", "data/ben/slow"}, "speed", "")
    chosen = {row.recording for row in made.rows} - {"data/anna/fast"}
    new = again(with_names_of_folders(emptied, chosen, Pattern("person/speed")))
    assert column(new, "speed") == ["slow", "", "slow", "fast"]
    assert column(new, "person") == ["anna", "", "ben", "ben"]
    with pytest.raises(InputError, match="no recording fits"):
        with_names_of_folders(made, chosen, Pattern("{a}-{b}"))
