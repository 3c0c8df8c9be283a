import shutil

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.study.create import Pattern, create_study
from stereotrack_core.study.file import read_study


def by_name(study):
    return {row.recording: row for row in study.rows}


def test_recordings_are_listed_with_factors_from_their_folders(study):
    rows = by_name(read_study(study.path))
    assert sorted(rows) == ["data/anna/fast", "data/anna/slow", "data/ben/slow"]
    assert rows["data/ben/slow"].factors == {"subject": "ben", "condition": "slow"}
    assert len({row.fingerprint for row in rows.values()}) == 3


def test_listing_again_adds_what_is_new_and_keeps_what_a_person_wrote(study, tmp_path):
    text = study.path.read_text("utf-8").splitlines()
    text = [f"{line},{'shoes' if k == 0 else f'pair {k}'}" for k, line in enumerate(text)]
    text[1] = text[1].replace(",anna,", ",Anna B,")
    study.path.write_text("\n".join(reversed(text[1:])).join([text[0] + "\n", "\n"]), "utf-8")
    shutil.copytree(tmp_path / "data/ben/slow", tmp_path / "data/ben/fast")
    (tmp_path / "data/ben/fast.stereotrack").unlink(missing_ok=True)
    Project.create(tmp_path / "data/ben/fast.stereotrack", tmp_path / "data/ben/fast").close()

    made = create_study(study.path, [tmp_path / "data"], Pattern("subject/condition"))
    assert made.added == ("data/ben/fast",)
    assert made.moved == ()
    rows = by_name(read_study(study.path))
    assert rows["data/anna/fast"].factors == {
        "subject": "Anna B", "condition": "fast", "shoes": "pair 1",
    }  # fmt: skip
    assert rows["data/ben/fast"].project == "data/ben/fast.stereotrack"
    assert list(rows)[:3] == ["data/ben/slow", "data/anna/slow", "data/anna/fast"]


def test_a_recording_that_moved_is_written_with_its_runs_and_project(study, tmp_path):
    project = tmp_path / "data/ben/slow.stereotrack"
    Project.create(project, tmp_path / "data/ben/slow").close()
    create_study(study.path, [tmp_path / "data"])
    kept = study.runs / "data/ben/slow/fast-seed0.npz"
    kept.parent.mkdir(parents=True)
    kept.write_bytes(b"a run")
    (tmp_path / "data/ben").rename(tmp_path / "data/benjamin")

    made = create_study(study.path, [tmp_path / "data"])
    assert made.moved == ("data/ben/slow",)
    assert made.added == ()
    row = by_name(read_study(study.path))["data/benjamin/slow"]
    assert row.project == "data/benjamin/slow.stereotrack"
    assert row.factors["subject"] == "ben"
    assert (study.runs / "data/benjamin/slow/fast-seed0.npz").read_bytes() == b"a run"


def test_what_cannot_be_found_stays_in_the_list(study, tmp_path):
    shutil.rmtree(tmp_path / "data/ben")
    made = create_study(study.path, [tmp_path / "data"])
    assert "data/ben/slow" in by_name(made.study)
    assert [one.what for one in made.findings] == ["the recording was not found"]


def test_one_of_several_copies_is_not_taken_for_the_moved_one(study, tmp_path):
    for name in ("x", "y"):
        shutil.copytree(tmp_path / "data/ben/slow", tmp_path / f"elsewhere/{name}")
    shutil.rmtree(tmp_path / "data/ben")
    made = create_study(study.path, [tmp_path / "data"])
    assert "several folders have its content" in made.findings[0].what


@pytest.mark.parametrize(
    ("pattern", "relative", "factors"),
    [
        ("subject/condition", "anna/slow", {"subject": "anna", "condition": "slow"}),
        ("*/day", "anna/2", {"day": "2"}),
        ("{who}/{how}_{day}", "anna/very_slow_2", {"who": "anna", "how": "very", "day": "slow_2"}),
        ("s{number}", "s7", {"number": "7"}),
        ("subject/condition", "anna", None),
    ],
)
def test_patterns_read_factors_from_folders(pattern, relative, factors):
    assert Pattern(pattern).factors(relative) == factors


@pytest.mark.parametrize("pattern", ["", "a/a", "{a b}", "project", "value", "*"])
def test_a_pattern_that_cannot_be_meant_is_refused(pattern):
    with pytest.raises(InputError) as refused:
        Pattern(pattern)
    assert refused.value.remedy


def test_folders_that_do_not_fit_are_told_in_one_sentence(study, tmp_path):
    for k in range(7):
        shutil.copytree(tmp_path / "data/anna/slow", tmp_path / f"other/r{k}")
    made = create_study(study.path, [tmp_path / "other"], Pattern("subject/condition"))
    assert len(made.added) == 7
    (told,) = made.findings
    assert "r0, r1, r2, r3, r4 and 2 more" in told.what


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(InputError, match="no recording in this folder"):
        create_study(tmp_path / "a.study.csv", [tmp_path])
