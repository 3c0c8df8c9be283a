"""Tables of clicks, ours and those of DLTdv, Argus and XMALab: pixels, rows and slips."""

from pathlib import Path

import pytest

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import read_clicks, read_labels, write_clicks
from tests.recording.small import filmless

HEAD = "frame,view,landmark,x,y,visibility\n"
RECORDING = filmless(Path("walk"), "N_left", "N_right", "S", size=(640, 480))


def test_the_layout_is_that_of_the_command_line(tmp_path):
    path = tmp_path / "clicks.csv"
    clicks = [
        Click(
            4, "N_right", "head", (100.5, 20.0), Visibility.GUESSED, "uncertain", 3.0, "imported"
        ),
        Click(3, "N_left", "left_hip", (1.25, 2.0)),
        Click(3, "S", "left_hip", None, Visibility.OUTSIDE, origin="accepted"),
        Click(5, "S", "left_hip", (1.0, 1.0), deleted=True),
    ]
    write_clicks(path, clicks, RECORDING)
    assert path.read_text() == (
        f"{HEAD.strip()},source,sigma,flag,annotator,time\n"
        "3,N_left,left_hip,1.25,2.0,2,clicked,,,,\n3,S,left_hip,,,0,accepted,,,,\n"
        "4,N,head,100.5,20.0,1,imported,3.0,uncertain,,\n"
    )
    found = read_clicks(path, RECORDING).checked()
    assert [click.origin for click in found] == ["hand", "accepted", "imported"]


SLIPS = {
    "x,N,head,1,2,2": "line {} has 'x' as frame",
    "100,N,head,1,2,2": "line {}: frame 100 does not exist",
    "1,Q,head,1,2,2": "line {}: unknown view or camera 'Q'",
    "1,N,nose,1,2,2": "line {}: unknown landmark 'nose'",
    "1,N,head,1,2,3": "line {}: invalid visibility '3'",
    "1,N,head,1,nan,1": "line {} has 'nan' as y",
    "1,N,head,640,2,2": "line {}: (640, 2) is outside the image of 640 x 480 pixels",
    "1,N,head,1,2,2,5": "line {} has 7 values, expected 6",
    "2,N_right,head,9,9,2": "line {} repeats head of frame 2 in N_right, given in line 2",
}


def test_every_slip_is_named_with_its_line_and_a_remedy(tmp_path):
    path = tmp_path / "clicks.csv"
    good = "2,N,head,1,2,2\n"
    path.write_text(HEAD + good + "\n".join(SLIPS) + "\n3,S,head,,,0\n")
    found = read_clicks(path, RECORDING, frames=100)
    expected = [text.format(line) for line, text in enumerate(SLIPS.values(), start=3)]
    assert [problem.what for problem in found.problems] == expected
    assert all(problem.remedy and problem.where == str(path) for problem in found.problems)
    assert [click.frame for click in found.clicks] == [2, 3]
    with pytest.raises(InputError, match=r"line 3 has 'x' as frame \(8 more problems"):
        found.checked()


@pytest.fixture
def recording(tmp_path):
    return filmless(tmp_path, "N", "S")


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
    places = {one.key[:2]: one.position for one in found.clicks}
    assert places == {(0, "N"): (0.0, 0.0), (2, "N"): (0.0, 0.0), (2, "S"): (63.0, 47.0)}


def test_a_table_of_another_program_alone(recording, tmp_path):
    path = tmp_path / "DLTdv8_xypts.csv"
    path.write_text("pt1_cam1_X,pt1_cam1_Y,pt2_cam1_X,pt2_cam1_Y\n1,1,NaN,NaN\n2.5,3,4,\n")
    source = LabelSource(path, recording, NINE.names, names={"pt1": "head"})
    found = read_labels(source)
    places = {one.key[:2]: one.position for one in found.clicks}
    assert places == {(0, "N"): (0.0, 0.0), (1, "N"): (1.5, 2.0)}
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
