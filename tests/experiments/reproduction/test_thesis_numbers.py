"""The thesis's numbers, checked against each other: the same result stands in several tables."""

import numpy as np
import pytest

from stereotrack_core.experiments.reproduction.thesis import (
    MOTIONS,
    ROWS,
    TABLE_4_1,
    TABLE_4_2,
    TABLE_4_4,
    TABLES,
)


def column(table, name):
    place = table.columns.index(name)
    return [table.values[measure][place] for measure, _, _ in ROWS]


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.number)
def test_every_table_is_whole_and_says_where_it_stands(table):
    assert list(table.values) == [measure for measure, _, _ in ROWS]
    assert {len(row) for row in table.values.values()} == {len(table.columns)}
    assert 49 < table.page < 56
    assert table.source == f"table {table.number}, page {table.page}"


def test_the_reference_parameters_give_the_same_in_three_tables():
    together = column(TABLE_4_1, "together")
    assert column(TABLE_4_2, "m = 64") == together
    assert column(TABLE_4_4, "individual") == together


def test_the_pooled_errors_lie_within_those_of_the_people():
    for row in TABLE_4_1.values.values():
        assert min(row[:4]) <= row[4] <= max(row[:4])
        assert row[4] == pytest.approx(np.mean(row[:4]), abs=1.0)


def test_the_motions_take_as_long_as_their_frame_numbers_say():
    lengths = {motion.segment: motion.frames[-1] - motion.frames[0] for motion in MOTIONS}
    assert lengths == {"whip": 274, "travolta": 38, "tie-shoes": 215, "cross-arms": 130}
