"""Tables of a report that are filled from what a run states."""

from __future__ import annotations

from types import SimpleNamespace

from stereotrack_core.report.run_tables import _lengths


def test_lengths_are_those_of_segments_whatever_else_the_subject_states():
    subject = {
        "name": "P2",
        "hip_width": 0.2,
        "forearm_length": None,
        "offsets": {"head": [0, 0, 0]},
    }
    table = _lengths(SimpleNamespace(meta={"subject": subject}))
    assert list(table.columns) == ["", ">hip width", ">forearm"]
    assert [list(row) for row in table.rows] == [["length [mm]", "200", "average"]]
