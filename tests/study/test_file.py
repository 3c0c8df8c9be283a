import dataclasses

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.study.file import Study, StudyRow, read_study, selected, write_study

ROWS = tuple(
    StudyRow(f"data/{subject}/{speed}", "", "", {"subject": subject, "speed": speed})
    for subject in ("anna", "ben")
    for speed in ("slow", "fast")
)


@pytest.fixture
def made(tmp_path):
    return Study(tmp_path / "walks.study.csv", ("subject", "speed"), ROWS)


def test_what_is_written_is_read_again(made):
    odd = StudyRow("data/=x", "p, q.stereotrack", "f", {"subject": "=1+1", "speed": 'a "b"'})
    study = dataclasses.replace(made, rows=(*ROWS, odd))
    write_study(study)
    assert read_study(study.path) == study
    assert "'=1+1" in study.path.read_text("utf-8")


def test_columns_of_a_spreadsheet_may_stand_in_any_order(tmp_path):
    path = tmp_path / "a.study.csv"
    path.write_text("note,recording\nold shoes,r1\n,r2\n", "utf-8")
    study = read_study(path)
    assert study.factors == ("note",)
    assert [row.recording for row in study.rows] == ["r1", "r2"]
    assert study.rows[0].factors == {"note": "old shoes"}
    write_study(study)
    assert path.read_text("utf-8").startswith("note,recording,project,fingerprint\nold shoes,r1,")
    assert read_study(path) == study


def test_semicolons_of_a_spreadsheet_stay(tmp_path):
    path = tmp_path / "a.study.csv"
    path.write_bytes(b'\xef\xbb\xbf"recording";subject;speed\r\nr1;anna;1,5\r\n')
    study = read_study(path)
    assert study.rows == (StudyRow("r1", factors={"subject": "anna", "speed": "1,5"}),)
    write_study(study)
    assert read_study(path) == study
    assert path.read_bytes().startswith(b"\xef\xbb\xbfrecording;subject;speed;project;"), (
        "the mark by which the spreadsheet knows UTF-8, and the order of the columns"
    )


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("subject\nanna\n", "'recording' is missing"),
        ("recording,value\nr,1\n", "a column of the results"),
        ("recording\nr\n./r\n", "listed twice"),
        ("recording,subject\n,anna\n", "has no folder"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(tmp_path, text, what):
    path = tmp_path / "a.study.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(InputError, match=what) as refused:
        read_study(path)
    assert refused.value.remedy


def test_another_name_is_refused_with_one_that_would_do(tmp_path):
    with pytest.raises(InputError, match=r"Use the name walks\.study\.csv"):
        read_study(tmp_path / "walks.csv")


def names(rows):
    return [row.recording.removeprefix("data/") for row in rows]


@pytest.mark.parametrize(
    ("select", "expected"),
    [
        ([], ["anna/slow", "anna/fast", "ben/slow", "ben/fast"]),
        (["speed=slow"], ["anna/slow", "ben/slow"]),
        (["speed=slow", "subject=b*"], ["ben/slow"]),
        (["speed=slow,fast", "subject=ben"], ["ben/slow", "ben/fast"]),
        (["recording=*/anna/*"], ["anna/slow", "anna/fast"]),
    ],
)
def test_rows_are_selected_by_their_columns(made, select, expected):
    assert names(selected(made, select)) == expected


@pytest.mark.parametrize("select", ["sped=slow", "speed", "speed=none"])
def test_a_selection_that_means_nothing_is_refused(made, select):
    with pytest.raises(InputError) as refused:
        selected(made, [select])
    assert refused.value.remedy


def test_runs_of_different_recordings_go_to_different_folders(made):
    rows = [StudyRow(name) for name in ("a/b", "a_b", "../a/b", "../../a/b", "/data/a/b")]
    assert len({made.runs_of(row) for row in rows}) == len(rows)
    assert all(made.runs_of(row).is_relative_to(made.runs) for row in rows)
