"""Journals that somebody is killed in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.errors import InputError
from stereotrack_core.interop.records import Journal, read_journal

ENTRIES = [{"job": "a", "value": 1.5}, {"job": "b", "words": 'ü \n " ]}'}, {"job": "c"}]


def written(path, entries):
    with Journal(path) as journal:
        for entry in entries:
            journal.append(entry)
    return path.read_bytes()


def test_what_is_appended_is_read_again(tmp_path):
    path = tmp_path / "a.jsonl"
    assert read_journal(path) == []
    written(path, ENTRIES[:1])
    written(path, ENTRIES[1:])
    assert read_journal(path) == ENTRIES


@given(share=st.floats(0.0, 1.0))
def test_a_torn_line_is_lost_alone(tmp_path_factory, share):
    path = tmp_path_factory.mktemp("journal") / "a.jsonl"
    whole = written(path, ENTRIES)
    kept = int(share * len(whole))
    path.write_bytes(whole[:kept])
    left = read_journal(path)
    assert left == ENTRIES[: whole[:kept].count(b"\n")]
    written(path, [{"job": "d"}])
    assert read_journal(path) == [*left, {"job": "d"}] or (
        # the line's end alone was missing, so that the entry is complete after all
        read_journal(path) == [*ENTRIES[: len(left) + 1], {"job": "d"}]
    )


def test_what_cannot_be_written_is_refused_in_words(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        Journal(tmp_path / "missing" / "a.jsonl")
    with pytest.raises(InputError, match="a folder, not a file"):
        read_journal(tmp_path)
