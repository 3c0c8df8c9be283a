"""Tables from spreadsheets that write decimal commas: read as meant, or refused with a sentence."""

from __future__ import annotations

import pickle
import re

import pytest

from stereotrack_core.errors import InputError

NUMBER = re.compile(r"(?<![\w.])(-?\d+)\.(\d+)(?![\w.])")
READ, REFUSED = "read", "refused"
TABLES = {
    "reference.csv": READ,
    "detections.csv": READ,
    "clicks": READ,
    "keypoints, table": READ,
    "keypoints, DeepLabCut": READ,
    "DeepLabCut": REFUSED,
    "Argus": REFUSED,
}
"""Readers of tables that people make or change, and what they do with clear decimal commas."""


def result(reader, path, text):
    """What is read, as bytes, or that all or some of it is refused."""
    path.write_text(text, encoding="utf-8")
    try:
        found = reader.read(path)
    except InputError:
        return REFUSED
    said = repr(found)
    return REFUSED if "InputError" in said or "is not a number" in said else pickle.dumps(found)


@pytest.mark.parametrize("name", TABLES)
def test_decimal_commas(name, catalogue, tmp_path):
    reader = catalogue[name]
    path, text = tmp_path / reader.file, reader.content.decode()
    assert NUMBER.search(text)
    right = result(reader, path, text)
    assert right != REFUSED
    semicolons = NUMBER.sub(r"\1,\2", text.replace(",", ";"))
    quoted = NUMBER.sub(r'"\1,\2"', text)
    expected = right if TABLES[name] == READ else REFUSED
    assert result(reader, path, semicolons) == expected
    assert result(reader, path, quoted) == expected
    assert result(reader, path, NUMBER.sub(r"\1,\2", text)) == REFUSED, "25,5 is 25 and 5"
