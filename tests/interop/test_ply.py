"""Clouds as PLY, read back by VTK, which did not write them."""

import numpy as np
import pytest
import pyvista

from stereotrack_core.errors import InputError
from stereotrack_core.interop.ply import VIEW_COLOURS, write_cloud


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


def test_empty_cloud_and_absent_folder(tmp_path):
    nothing, views = np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    write_cloud(tmp_path / "a.ply", nothing, views, ["N"], 0)
    assert b"element vertex 0" in (tmp_path / "a.ply").read_bytes()
    with pytest.raises(InputError, match="folder"):
        write_cloud(tmp_path / "absent" / "a.ply", nothing, views, ["N"], 0)
