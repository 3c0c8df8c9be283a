"""Tables as CSV and Markdown."""

import csv

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.errors import InputError
from stereotrack_core.interop.table_file import (
    csv_text,
    markdown_text,
    table_suffix,
    write_text_table,
)

CELL = st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=12)
ROWS = st.integers(1, 4).flatmap(
    lambda n: st.lists(st.lists(CELL, min_size=n, max_size=n), min_size=1, max_size=5)
)


@given(ROWS)
def test_csv_comes_back(rows):
    text = csv_text(rows[0], rows[1:])
    assert list(csv.reader(text.splitlines())) == rows


def test_numbers_come_back_in_full():
    text = csv_text(["a", "b"], [[0.1 + 0.2, 3]])
    value, whole = next(iter(csv.reader(text.splitlines()[1:])))
    assert float(value) == 0.1 + 0.2
    assert whole == "3"


def test_markdown_aligns_numbers_to_the_right_and_keeps_its_columns():
    text = markdown_text(["name", ">mm"], [["a|b", "3"]])
    assert text == "| name | mm |\n| --- | ---: |\n| a\\|b | 3 |\n"


@pytest.mark.parametrize("name", ["t.csv", "t.MD"])
def test_files_are_written_whole(tmp_path, name):
    assert table_suffix(tmp_path / name) in (".csv", ".md")
    write_text_table(tmp_path / name, "ä ± 1\n")
    assert (tmp_path / name).read_bytes() == "ä ± 1\n".encode()
    assert len(list(tmp_path.iterdir())) == 1


def test_other_files_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"\.csv or \.md"):
        table_suffix(tmp_path / "t.xlsx")
