"""Clicks files: what is written is read again, and every slip is named with its line."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.annotation.click import Click, Visibility
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.landmarks import LANDMARKS

HEAD = "frame,view,landmark,x,y,visibility\n"


def camera(name: str) -> Camera:
    return Camera(name, 640, 480, np.eye(3), np.zeros(5), False, RigidTransform.identity())


RECORDING = Recording(
    Path("walk"),
    "walk",
    10.0,
    (
        View("N", "stereo", Stream("N_right", "a.mp4"), left=Stream("N_left", "b.mp4")),
        View("S", "mono", Stream("S", "c.mp4")),
    ),
    {name: camera(name) for name in ("N_left", "N_right", "S")},
)

CLICKS = st.builds(
    Click,
    frame=st.integers(0, 3000),
    camera=st.sampled_from(["N_left", "N_right", "S"]),
    landmark=st.sampled_from(LANDMARKS),
    position=st.tuples(st.floats(-0.5, 639.5), st.floats(-0.5, 479.5)),
    visibility=st.sampled_from([Visibility.SEEN, Visibility.GUESSED]),
    origin=st.just("imported"),
) | st.builds(
    Click,
    frame=st.integers(0, 3000),
    camera=st.just("S"),
    landmark=st.sampled_from(LANDMARKS),
    position=st.none(),
    visibility=st.just(Visibility.OUTSIDE),
    origin=st.just("imported"),
)


@given(st.lists(CLICKS, unique_by=lambda click: click.key))
def test_what_is_written_is_read_again_bit_by_bit(clicks):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clicks.csv"
        write_clicks(path, clicks, RECORDING)
        found = read_clicks(path, RECORDING)
    assert found.problems == ()
    assert {click.key: click for click in found.checked()} == {click.key: click for click in clicks}


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
        f"{HEAD.strip()},source\n3,N_left,left_hip,1.25,2.0,2,clicked\n"
        "3,S,left_hip,,,0,accepted\n4,N,head,100.5,20.0,1,imported\n"
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
