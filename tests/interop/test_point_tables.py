"""Tables of DLTdv, Argus and XMALab: pixels, rows and columns, worked out by hand."""

import numpy as np
import pytest

from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.recording.description import Recording, Stream, View


@pytest.fixture
def recording(tmp_path):
    lens = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    cameras = {
        name: Camera(name, 64, 48, lens, np.zeros(5), False, RigidTransform.identity())
        for name in "NS"
    }
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in "NS")
    return Recording(tmp_path, "walk", 10.0, views, cameras)


@pytest.mark.parametrize(
    ("header", "corner", "last"),
    [
        ("pt1_cam{}_X,pt1_cam{}_Y", "1,1", "64,48"),
        ("head_cam_{}_x,head_cam_{}_y", "0,48", "63,1"),
        ("head_cam{}_X,head_cam{}_Y", "0,0", "63,47"),
    ],
)
def test_conventions(recording, tmp_path, header, corner, last):
    """What each program counts from, in the first and in the second camera."""
    path = tmp_path / "points.csv"
    columns = f"{header.format(1, 1)},{header.format(2, 2)}"
    path.write_text(f"{columns}\n{corner},NaN,NaN\nNaN,NaN,NaN,NaN\n{corner},{last}\n")
    names = {"pt1": "head"} if header.startswith("pt1") else None
    found = read_labels(LabelSource(path, recording, NINE.names, names=names), 3)
    assert not found.problems
    assert [(one.key, one.position) for one in found.clicks] == [
        ((0, "N", "head"), (0.0, 0.0)),
        ((2, "N", "head"), (0.0, 0.0)),
        ((2, "S", "head"), (63.0, 47.0)),
    ]


def test_a_table_of_another_program_alone(recording, tmp_path):
    path = tmp_path / "DLTdv8_xypts.csv"
    path.write_text("pt1_cam1_X,pt1_cam1_Y,pt2_cam1_X,pt2_cam1_Y\n1,1,NaN,NaN\n2.5,3,4,\n")
    source = LabelSource(path, recording, NINE.names, names={"pt1": "head"})
    found = read_labels(source)
    assert [(one.key, one.position) for one in found.clicks] == [
        ((0, "N", "head"), (0.0, 0.0)),
        ((1, "N", "head"), (1.5, 2.0)),
    ]
    assert found.left_out == ("pt2",)
    with pytest.raises(InputError, match="none of its landmarks is known"):
        read_labels(LabelSource(path, recording, NINE.names))
    path.write_text("head_cam3_X,head_cam3_Y\n1,1\n")
    with pytest.raises(InputError, match="the file has a camera 3"):
        read_labels(LabelSource(path, recording, NINE.names))
    path.write_text("head_cam1_X,head_cam1_Y\n1,a\n70,1\n")
    found = read_labels(LabelSource(path, recording, NINE.names))
    assert "'a' as" in str(found.problems[0])
    assert "outside the image" in str(found.problems[1])
