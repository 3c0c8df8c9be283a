"""Tables of DLTdv, Argus and XMALab: pixels, rows and columns, and back again."""

import csv
import json

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.interop.point_tables import POINT_TABLES, write_points
from stereotrack_core.recording.description import Recording, Stream, View

CLICKS = (
    Click(0, "N", "head", (0.0, 0.0), origin="imported"),
    Click(2, "N", "left_hand", (63.0, 47.0), origin="imported"),
    Click(2, "S", "left_hand", (-0.25, 12.125), origin="imported"),
)
OUTSIDE = Click(1, "S", "head", None, Visibility.OUTSIDE)


@pytest.fixture
def recording(tmp_path):
    lens = np.array([[50.0, 0, 31.5], [0, 50, 23.5], [0, 0, 1]])
    cameras = {
        name: Camera(name, 64, 48, lens, np.zeros(5), False, RigidTransform.identity())
        for name in "NS"
    }
    views = tuple(View(name, "mono", Stream(name, f"{name}/%d.png")) for name in "NS")
    return Recording(tmp_path, "walk", 10.0, views, cameras)


def rows_of(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("form", POINT_TABLES)
def test_round_trip(recording, tmp_path, form):
    path = tmp_path / "points.csv"
    assert write_points(path, (*CLICKS, OUTSIDE), recording, NINE.names, form, 5) == 3
    assert len(rows_of(path)) == 5
    found = read_labels(LabelSource(path, recording, NINE.names), 5)
    assert not found.problems
    assert sorted(found.clicks, key=lambda one: one.key) == sorted(CLICKS, key=lambda one: one.key)


def test_conventions(recording, tmp_path):
    """What each program counts from: the numbers are worked out by hand."""
    corner = {"dltdv": (1.0, 1.0), "argus": (0.0, 48.0), "xmalab": (0.0, 0.0)}
    last = {"dltdv": (64.0, 48.0), "argus": (63.0, 1.0), "xmalab": (63.0, 47.0)}
    head, hand = NINE.names.index("head") + 1, NINE.names.index("left_hand") + 1
    columns = {
        "dltdv": (f"pt{head}_cam1_X", f"pt{head}_cam1_Y", f"pt{hand}_cam1_X", f"pt{hand}_cam1_Y"),
        "argus": ("head_cam_1_x", "head_cam_1_y", "left_hand_cam_1_x", "left_hand_cam_1_y"),
        "xmalab": ("head_cam1_X", "head_cam1_Y", "left_hand_cam1_X", "left_hand_cam1_Y"),
    }
    for form, (x, y, hand_x, hand_y) in columns.items():
        path = tmp_path / f"{form}.csv"
        write_points(path, CLICKS, recording, NINE.names, form)
        rows = rows_of(path)
        assert (float(rows[0][x]), float(rows[0][y])) == corner[form]
        assert (float(rows[2][hand_x]), float(rows[2][hand_y])) == last[form]
        assert rows[1][x] == "NaN"
        assert json.loads((tmp_path / f"{form}.csv.json").read_text())["cameras"]["2"] == "S"


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
    assert "'a' is not a number" in str(found.problems[0])
    assert "outside the image" in str(found.problems[1])
