"""Names that a spreadsheet would compute: every table that is written holds them as texts."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
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

SIGNS = ("=", "+", "-", "@", "\t", "\r")
NAMES = (
    "=cmd|' /C calc'!A0",
    "=HYPERLINK(\"http://example.org\", 'a,b')",
    "@SUM(A1:A9)",
    "'=already",
)


def cells_of(path: Path, delimiter: str = ",") -> list[str]:
    with path.open(encoding="utf-8", newline="") as file:
        return [cell for line in csv.reader(file, delimiter=delimiter) for cell in line]


def check_texts(cells: list[str], *names: str) -> None:
    """Nothing is computed, and the names are there, behind an apostrophe."""
    for cell in cells:
        if cell.startswith(SIGNS):
            float(cell)
    for name in names:
        assert f"'{name}" in cells


@pytest.fixture(params=NAMES)
def name(request) -> str:
    return request.param


@pytest.fixture
def recording(name, tmp_path) -> Recording:
    """A recording with one view of that name, whose camera has it as well."""
    lens = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    camera = Camera(name, 64, 48, lens, np.zeros(5), False, RigidTransform.identity())
    view = View(name, "mono", Stream(name, "N/%d.png"))
    return Recording(tmp_path, name, 10.0, (view,), {name: camera})


def test_segments(name, tmp_path):
    path, segments = tmp_path / "segments.csv", (Segment(name, 0, 5), Segment("walk", 5, 9))
    write_segments(path, segments)
    check_texts(cells_of(path), name)
    assert read_segments(path) == segments


def test_clicks(name, recording, tmp_path):
    path, click = tmp_path / "clicks.csv", Click(3, name, name, (-0.25, 6.0), origin="imported")
    write_clicks(path, [click], recording)
    check_texts(cells_of(path), name)
    assert read_clicks(path, recording, landmarks=(name,)).checked() == (click,)


def _sweep(name: str) -> str:
    point = Point((("views", name),))
    spec = RunSpec(preset("fast"), preset="fast", frames=range(3))
    job = Job("x", "", "", name, "", "", point, spec)
    return csv_text(*table_of([job], {"x": JobResult("x", "failed", error=name)}))


def test_tables_of_results(name, tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(_sweep(name), encoding="utf-8", newline="")
    check_texts(cells_of(path), name)
    _, rows = read_csv_table(path)
    assert all(row.count(name) >= 2 for row in rows)
    assert rows
