"""Clouds as PLY, read back by VTK, which did not write them."""

import numpy as np
import pyvista

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
