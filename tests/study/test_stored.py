import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.study.create import find_recordings
from stereotrack_core.study.editing import with_column, with_recordings, without
from stereotrack_core.study.file import read_study
from stereotrack_core.study.stored import FACTORS, StoredStudy, StudyChanged


def test_a_new_study_has_the_usual_columns_and_overwrites_nothing(tmp_path):
    path = tmp_path / "walks.study.csv"
    new = StoredStudy.new(path)
    assert new.study.factors == FACTORS
    assert read_study(path) == new.study
    with pytest.raises(InputError, match="already"):
        StoredStudy.new(path)
    with pytest.raises(InputError, match=r"Use the name b\.study\.csv"):
        StoredStudy.new(tmp_path / "b.csv")


def test_edits_are_saved_one_after_the_other_and_back(tmp_path):
    first = StoredStudy.new(tmp_path / "walks.study.csv")
    second = first.saved(with_column(first.study, "shoes"))
    assert second.is_current
    assert not first.is_current
    third = second.saved(first.study)
    assert third == first
    assert first.is_current, "the bytes are the same again"


def test_what_another_program_wrote_is_not_overwritten(tmp_path):
    path = tmp_path / "walks.study.csv"
    stored = StoredStudy.new(path)
    path.write_text("recording,shoes\nr,old\n", "utf-8")
    with pytest.raises(StudyChanged, match="another program") as refused:
        stored.saved(with_column(stored.study, "shoes"))
    assert "Refresh" in refused.value.remedy
    assert path.read_text("utf-8") == "recording,shoes\nr,old\n"
    path.unlink()
    with pytest.raises(StudyChanged, match="no longer there"):
        stored.saved(with_column(stored.study, "shoes"))
    assert list(tmp_path.iterdir()) == []


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    stored = StoredStudy.new(tmp_path / "walks.study.csv")
    monkeypatch.setattr("stereotrack_core.study.stored.bytes_of", lambda _: b"half")
    monkeypatch.setattr("pathlib.Path.write_bytes", lambda _path, data: len(data))
    with pytest.raises(InputError, match="not all data"):
        stored.saved(stored.study)
    assert stored.is_current


def test_recordings_are_found_in_folders_and_by_their_projects(study, tmp_path):
    project = tmp_path / "elsewhere" / "anna.stereotrack"
    project.parent.mkdir()
    Project.create(project, tmp_path / "data/anna/slow").close()
    less = without(study, {"data/ben/slow", "data/anna/fast"})
    (tmp_path / "empty").mkdir()
    given = [tmp_path / "data", tmp_path / "empty", tmp_path / "data/ben/slow/recording.toml"]
    found = find_recordings(less, [*given, project])
    assert [row.recording for row in found.rows] == [
        *("data/anna/slow", "data/anna/fast", "data/ben/slow"),
    ]
    assert found.rows[0].project == "elsewhere/anna.stereotrack"
    assert (found.listed, len(found.findings)) == (0, 1)
    assert found.findings[0].where == str(tmp_path / "empty")
    new = with_recordings(less, found.rows)
    assert {row.fingerprint for row in new.rows} == {row.fingerprint for row in study.rows}
    assert find_recordings(new, [tmp_path / "data"]).listed == 3


def test_a_project_without_its_recording_is_told(study, tmp_path):
    project = tmp_path / "ben.stereotrack"
    Project.create(project, tmp_path / "data/ben/slow").close()
    (tmp_path / "data").rename(tmp_path / "away")
    found = find_recordings(study, [project])
    assert found.rows == ()
    assert "not found" in found.findings[0].what


def test_a_recording_that_has_moved_is_not_listed_twice(study, tmp_path):
    (tmp_path / "data/ben").rename(tmp_path / "data/benjamin")
    found = find_recordings(study, [tmp_path / "data"])
    assert (found.rows, found.listed) == ((), 2)
    assert "data/ben/slow, which has moved here" in found.findings[0].what
