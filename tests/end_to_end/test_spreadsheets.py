"""Names that a spreadsheet would compute: every table that is written holds them as texts."""

import csv
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.recording.description import (
    Recording,
    Segment,
    Stream,
    View,
    read_segments,
    write_segments,
)
from stereotrack_core.study.job import Job, JobResult
from stereotrack_core.study.points import Point
from stereotrack_core.study.store import table_of
from stereotrack_core.tables import csv_text, read_csv_table
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import camera_towards_the_middle

NAMES = (
    "=cmd|' /C calc'!A0",
    "=HYPERLINK(\"http://example.org\", 'a,b')",
    "@SUM(A1:A9)",
    "'=already",
)
EACH = pytest.mark.parametrize("name", NAMES)


def check_texts(path: Path, name: str) -> None:
    """Nothing is computed, and the name is there, behind an apostrophe."""
    with path.open(encoding="utf-8", newline="") as file:
        cells = [cell for line in csv.reader(file) for cell in line]
    for cell in cells:
        if cell.startswith(("=", "+", "-", "@", "\t", "\r")):
            float(cell)
    assert f"'{name}" in cells


@EACH
def test_segments(name, tmp_path):
    path, segments = tmp_path / "segments.csv", (Segment(name, 0, 5), Segment("walk", 5, 9))
    write_segments(path, segments)
    check_texts(path, name)
    assert read_segments(path) == segments


@EACH
def test_clicks(name, tmp_path):
    """Clicks in a camera and of a landmark of that name."""
    camera = camera_towards_the_middle(name, np.array([0.0, 2.0, 1.5]))
    view = View(name, "mono", Stream(name, "N/%d.png"))
    recording = Recording(tmp_path, name, 10.0, (view,), {name: camera})
    path, click = tmp_path / "clicks.csv", Click(3, name, name, (-0.25, 6.0), origin="imported")
    write_clicks(path, [click], recording)
    check_texts(path, name)
    assert read_clicks(path, recording, landmarks=(name,)).checked() == (click,)


@EACH
def test_tables_of_results(name, tmp_path):
    path, spec = tmp_path / "table.csv", RunSpec(preset("fast"), preset="fast", frames=range(3))
    job = Job("x", "", "", name, "", "", Point((("views", name),)), spec)
    text = csv_text(*table_of([job], {"x": JobResult("x", "failed", error=name)}))
    path.write_text(text, encoding="utf-8", newline="")
    check_texts(path, name)
    _, rows = read_csv_table(path)
    assert all(row.count(name) >= 2 for row in rows)
    assert rows
