import json
import shutil

import pytest

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.plain_data import plain
from stereotrack_core.project.clicks import PlaceClicks
from stereotrack_core.project.marks import SetKeyframes
from stereotrack_core.project.project import Project
from stereotrack_core.study import facts, status
from stereotrack_core.study.cache import StudyCache
from stereotrack_core.study.create import create_study
from stereotrack_core.study.file import Study, StudyRow
from stereotrack_core.study.status import remembered_status, study_status


def read(study):
    """Status of all rows, and how often something was read."""
    cache = StudyCache(study.cache)
    rows = study_status(study, cache)
    cache.save(forget=True)
    return {row.row.recording: row for row in rows}, cache.reads


def test_the_second_time_nothing_is_read(study, monkeypatch):
    first, reads = read(study)
    assert reads == 3
    for name in ("read_recording_facts", "read_project_facts"):
        monkeypatch.setattr(status, name, lambda *_: pytest.fail("it was read again"))
    again, reads = read(study)
    assert (again, reads) == (first, 0)
    assert remembered_status(study, StudyCache(study.cache)) == tuple(first.values())


def test_only_what_has_changed_is_read_again(study, tmp_path):
    read(study)
    description = tmp_path / "data/ben/slow/recording.toml"
    description.write_text(description.read_text("utf-8").replace("fps = 10", "fps = 20"), "utf-8")
    rows, reads = read(study)
    assert reads == 1
    assert rows["data/ben/slow"].recording.fps == 20
    assert "has changed since it was listed" in rows["data/ben/slow"].findings[0].what


def test_a_study_that_moves_as_a_whole_is_not_read_again(study, tmp_path):
    read(study)
    (tmp_path / "other").mkdir()
    for path in (tmp_path / "data", study.path, study.cache):
        path.rename(tmp_path / "other" / path.name)
    moved = Study(tmp_path / "other" / study.path.name, study.factors, study.rows)
    assert read(moved)[1] == 0


@pytest.mark.parametrize("content", [b"", b"{", b'{"entries": 3}', b'{"format": 1, "version": ""}'])
def test_a_damaged_cache_counts_as_empty(study, content):
    study.cache.write_bytes(content)
    assert read(study)[1] == 3


def test_facts_that_somebody_changed_are_read_again(study):
    first, _ = read(study)
    for wrong in ({"frames": "many"}, {"frames": 3, "more": 1}):
        content = json.loads(study.cache.read_text("utf-8"))
        name = next(iter(content["entries"]))
        content["entries"][name]["facts"] |= wrong
        study.cache.write_text(json.dumps(content), "utf-8")
        shown = remembered_status(study, StudyCache(study.cache))
        assert [row.recording is None for row in shown].count(True) == 1
        assert read(study) == (first, 1)


def test_annotation_and_what_is_wrong_are_told(study, tmp_path):
    folder = tmp_path / "data/ben/slow"
    with Project.create(tmp_path / "data/ben/slow.stereotrack", folder) as project:
        project.apply(SetKeyframes((0, 2, 4)))
        project.apply(SetKeyframes((2,), "done"))
        project.apply(PlaceClicks((Click(0, "N", "left_wrist", (3.0, 4.0), Visibility.SEEN),)))
    (tmp_path / "data/anna/slow/calibration.toml").unlink()
    study = create_study(study.path, [tmp_path / "data"]).study
    rows, _ = read(study)
    known = rows["data/ben/slow"].project
    assert (known.keyframes, known.done, known.clicks) == (3, 1, 1)
    spoilt = rows["data/anna/slow"].recording
    assert spoilt.errors >= 1
    assert "calibration.toml" in spoilt.diagnostics[0]
    assert (spoilt.fingerprint, spoilt.frames) == ("", 0)
    shown = remembered_status(study, StudyCache(study.cache))
    assert [row.project for row in shown] == [row.project for row in rows.values()]


def test_moved_and_missing_recordings_are_told_and_nothing_is_written(study, tmp_path):
    before = study.path.read_bytes()
    (tmp_path / "data/ben").rename(tmp_path / "benjamin")
    shutil.rmtree(tmp_path / "data/anna/fast")
    rows, _ = read(study)
    moved, missing = rows["data/ben/slow"], rows["data/anna/fast"]
    assert moved.place.folder == tmp_path / "benjamin/slow"
    assert moved.recording.frames == 6
    assert "has moved to" in moved.findings[0].what
    assert missing.place.folder is None
    assert "was not found" in missing.findings[0].what
    assert study.path.read_bytes() == before


def test_two_hundred_recordings_are_known_at_once(walks, tmp_path, monkeypatch):
    """Rows come from the cache, and no recording is opened for them."""
    rows = []
    for k in range(200):
        (tmp_path / f"r{k}").mkdir()
        for path in (walks / "anna/slow").iterdir():
            if path.is_file():
                shutil.copy(path, tmp_path / f"r{k}" / path.name)
            else:
                (tmp_path / f"r{k}" / path.name).symlink_to(path)
        rows.append(StudyRow(f"r{k}", factors={"subject": f"s{k}"}))
    study = Study(tmp_path / "many.study.csv", ("subject",), tuple(rows))
    light = facts.RecordingFacts("r", "f", "c", 4, 10.0, ("N depth",), 0, 0, (), True)
    monkeypatch.setattr(
        status,
        "read_recording_facts",
        lambda folder: facts.Read(plain(light), (folder, folder / "recording.toml")),
    )
    assert read(study)[1] == 200
    monkeypatch.setattr(status, "read_recording_facts", lambda *_: pytest.fail("read again"))
    shown = remembered_status(study, StudyCache(study.cache))
    assert len(shown) == 200
    assert read(study)[1] == 0
