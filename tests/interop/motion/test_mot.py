"""Motion files, read back by NumPy, and by OpenSim where it is installed."""

from __future__ import annotations

import json

import numpy as np
import pytest
import pyvista

from stereotrack_core.errors import InputError
from stereotrack_core.interop.motion.mot import write_mot
from stereotrack_core.interop.ply import VIEW_COLOURS, write_cloud

FRAME = np.array([4, 5, 6, 9])
NAMES = ("elbow", "never", "torso")
ANGLE = np.radians(
    [[10.0, np.nan, -190.5], [20.0, np.nan, np.nan], [np.nan, np.nan, -200.0], [30.0, np.nan, 7.25]]
)
ROWS = np.arange(4, 10)
HELD = [[10.0, -190.5], [20.0, -190.5], *[[20.0, -200.0]] * 3, [30.0, 7.25]]


def test_degrees_over_time_with_the_header_of_opensim(tmp_path):
    path = tmp_path / "my walk.mot"
    assert write_mot(path, FRAME, NAMES, ANGLE, 10.0) == 6
    lines = path.read_text().splitlines()
    header = ["my walk", "version=1", "nRows=6", "nColumns=3", "inDegrees=yes", "endheader"]
    assert lines[:6] == header
    assert lines[6] == "time\telbow\ttorso"
    table = np.genfromtxt(path, skip_header=7)
    np.testing.assert_allclose(table[:, 0], ROWS / 10.0)
    np.testing.assert_allclose(table[:, 1:], HELD)
    notes = json.loads((tmp_path / "my walk.mot.json").read_text())
    assert notes["angles_never_known"] == ["never"]
    assert notes["frames_with_held_angles"] == {"elbow": [6, 7, 8], "torso": [5, 7, 8]}


def test_opensim_reads_all_rows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where it keeps its log
    opensim = pytest.importorskip("opensim")
    write_mot(tmp_path / "a.mot", FRAME, NAMES, ANGLE, 10.0)
    table = opensim.TimeSeriesTable(str(tmp_path / "a.mot"))
    assert table.getTableMetaDataString("inDegrees") == "yes"
    assert list(table.getColumnLabels()) == ["elbow", "torso"]
    np.testing.assert_allclose(table.getIndependentColumn(), ROWS / 10.0)
    rows = [table.getRowAtIndex(k).to_numpy() for k in range(6)]
    np.testing.assert_allclose(rows, HELD)
    storage = opensim.Storage(str(tmp_path / "a.mot"))  # which reads motions in its window
    assert (storage.getSize(), storage.isInDegrees()) == (6, True)


def test_nothing_known_is_refused(tmp_path):
    for frame, angle in ((FRAME, np.full((4, 3), np.nan)), (FRAME[:0], ANGLE[:0])):
        with pytest.raises(InputError, match="no joint angle is known"):
            write_mot(tmp_path / "a.mot", frame, NAMES, angle, 10.0)
    assert not list(tmp_path.iterdir())


def test_points_views_and_colours(tmp_path, random):
    points, view = random.normal(size=(50, 3)), random.integers(0, 4, 50)
    write_cloud(tmp_path / "a.ply", points, view, list("NOSW"), 7)
    cloud = pyvista.read(tmp_path / "a.ply")
    np.testing.assert_allclose(cloud.points, points, atol=1e-6)
    np.testing.assert_array_equal(cloud["RGB"], VIEW_COLOURS[view])
    data = (tmp_path / "a.ply").read_bytes()
    header, body = data.split(b"end_header\n", 1)
    assert b"comment view 2: S" in header
    assert b"comment frame: 7" in header
    assert [body[k * 16 + 15] for k in range(50)] == view.tolist()
