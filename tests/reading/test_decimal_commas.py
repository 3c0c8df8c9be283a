"""Tables from spreadsheets that write decimal commas: read as meant, or refused with a sentence."""

import pickle
import re

import pytest

from stereotrack_core.errors import InputError

NUMBER = re.compile(r"(?<![\w.])(-?\d+)\.(\d+)(?![\w.])")
REFUSED = "refused"
TABLES = (
    "reference.csv", "detections.csv", "clicks", "keypoints, table", "keypoints, DeepLabCut",
    "DeepLabCut", "Argus",
)  # fmt: skip
"""Readers of tables that people make or change."""


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
def test_decimal_commas(reader, tmp_path):
    path, text = tmp_path / reader.file, reader.content.decode()
    assert NUMBER.search(text)
    right = result(reader, path, text)
    assert right != REFUSED
    semicolons = NUMBER.sub(r"\1,\2", text.replace(",", ";"))
    quoted = NUMBER.sub(r'"\1,\2"', text)
    assert result(reader, path, semicolons) == right
    assert result(reader, path, quoted) == right
    assert result(reader, path, NUMBER.sub(r"\1,\2", text)) == REFUSED, "25,5 is 25 and 5"
