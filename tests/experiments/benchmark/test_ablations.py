"""The table of ablations."""

import pytest

from stereotrack_core.experiments.benchmark.accuracy import ABLATIONS
from stereotrack_core.tracking.presets import preset


@pytest.mark.parametrize("row", ABLATIONS, ids=lambda row: row.name)
def test_every_row_takes_something_away_from_accurate(row):
    values = preset("accurate").values()
    changed = preset("accurate").replaced(**row.changes).values()
    assert row.changes
    for name in row.changes:
        assert changed[name] != values[name], f"{name} is what accurate has anyway"


def test_rows_are_told_apart():
    names = [row.name for row in ABLATIONS]
    assert len(names) == len(set(names))
    changes = [tuple(sorted(row.changes.items())) for row in ABLATIONS]
    assert len(changes) == len(set(changes))
