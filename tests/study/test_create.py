import dataclasses
import shutil

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.study.create import Pattern, with_recordings


def by_name(study):
    return {row.recording: row for row in study.rows}


def test_recordings_are_listed_with_factors_from_their_folders(study):
    rows = by_name(study)
    assert sorted(rows) == ["data/anna/fast", "data/anna/slow", "data/ben/slow"]
    assert rows["data/ben/slow"].factors == {"subject": "ben", "condition": "slow"}


def test_listing_again_adds_what_is_new_and_keeps_what_a_person_wrote(study, tmp_path):
    first = study.rows[0]
    written = dataclasses.replace(first, factors={"subject": "Anna B", "shoes": "old"})
    study = dataclasses.replace(study, rows=(*study.rows[:0:-1], written))
    shutil.copytree(tmp_path / "data/ben/slow", tmp_path / "data/ben/fast")
    Project.create(tmp_path / "data/ben/fast.stereotrack", tmp_path / "data/ben/fast").close()

    made = with_recordings(study, [tmp_path / "data"], Pattern("subject/condition"))
    assert made.added == ("data/ben/fast",)
    rows = by_name(made.study)
    assert list(rows)[:3] == [row.recording for row in study.rows]
    assert rows[first.recording].factors == {
        "subject": "Anna B", "shoes": "old", "condition": "fast",
    }  # fmt: skip
    assert rows["data/ben/fast"].project == "data/ben/fast.stereotrack"


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
