"""A subject's file: lengths, and where the bones lie."""

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Subject, read_subject, write_subject

OFFSETS = {"left_hip": (0.001, -0.02, 0.0), "head": (0.0, 0.0, -0.003)}


@pytest.mark.parametrize(
    "subject",
    [Subject("P"), Subject("P", torso_length=0.5), Subject("P", hip_width=0.2, offsets=OFFSETS)],
)
def test_a_subject_comes_back_as_it_was(tmp_path, subject):
    write_subject(tmp_path / "subject.toml", subject)
    assert read_subject(tmp_path / "subject.toml") == subject
    assert hash(read_subject(tmp_path / "subject.toml")) == hash(subject)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("left_knee = [0.0, 0.0, 0.0]", "unknown landmark 'left_knee'"),
        ("left_hip = [0.0, 20.0, 0.0]", "is not a possible offset"),
        ("left_hip = 3", "is not 3 numbers"),
    ],
)
def test_wrong_offsets_are_named(tmp_path, line, words):
    (tmp_path / "s.toml").write_text(f"[offsets]\n{line}\n")
    with pytest.raises(InputError, match="offsets") as told:
        read_subject(tmp_path / "s.toml")
    assert words in str(told.value)
