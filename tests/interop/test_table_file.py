"""Tables as CSV and Markdown."""

import csv

from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.tables import csv_text, guarded, markdown_text, read_csv_table, unguarded

CELL = st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=12)
ROWS = st.integers(1, 4).flatmap(
    lambda n: st.lists(st.lists(CELL, min_size=n, max_size=n), min_size=1, max_size=5)
)


@given(ROWS)
def test_csv_comes_back(rows):
    lines = csv.reader(csv_text(rows[0], rows[1:]).splitlines())
    assert [[unguarded(cell) for cell in line] for line in lines] == rows


COMPUTED = ("=", "+", "-", "@", "\t", "\r", "\n")


@given(st.text(st.sampled_from([*COMPUTED, "'", "1", ".", "e", "x", "|"]), max_size=6))
def test_no_text_is_computed_and_every_text_comes_back(text):
    cell = guarded(text)
    assert unguarded(cell) == text
    if cell.startswith(COMPUTED):
        float(cell)


def test_an_apostrophe_is_taken_away_where_one_was_written(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(csv_text(["=a", "b"], [["=cmd|' /C calc'!A0", "'=x"], ["'-1", -1]]))
    assert path.read_text() == "'=a,b\n'=cmd|' /C calc'!A0,''=x\n'-1,-1\n"
    assert read_csv_table(path) == (
        ("=a", "b"), (("=cmd|' /C calc'!A0", "'=x"), ("'-1", "-1"))
    )  # fmt: skip


def test_markdown_aligns_numbers_to_the_right_and_keeps_its_columns():
    text = markdown_text(["name", ">mm"], [["a|b", "3"]])
    assert text == "| name | mm |\n| --- | ---: |\n| a\\|b | 3 |\n"
