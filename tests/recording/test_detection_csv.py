"""Files of detections."""

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.detections import read_detections
from tests.recording.small import filmless

HEADER = "frame,view,kind,x,y,z,sigma,confidence\n"


@pytest.fixture
def recording(tmp_path):
    return filmless(tmp_path, "N_left", "N_right")


def _read(tmp_path, recording, text):
    path = tmp_path / "detections.csv"
    path.write_text(text)
    return read_detections(path, recording)


def test_detections_come_in_the_order_of_their_times(tmp_path, recording):
    rows = "0,,head,0.1,-0.2,1.7,0.05,0.9\n2.25,N_left,hand,12.5,40.25,,3,1\n"
    found = _read(tmp_path, recording, HEADER + rows + "1,,left_hand,1,2,3,0.03,0.25\n")
    read = [*found.until(0), *found.until(1), *found.until(2), *found.until(3)]
    assert [(one.time, one.kind, one.sigma, one.confidence) for one in read] == [
        (0.0, "head", 0.05, 0.9),
        (1.0, "left_hand", 0.03, 0.25),
        (2.25, "hand", 3.0, 1.0),
    ]
    assert [one.camera for one in read] == [None, None, recording.cameras["N_left"]]
    np.testing.assert_array_equal(read[2].position, [12.5, 40.25])


def test_a_view_means_its_reference_camera(tmp_path, recording):
    (one,) = _read(tmp_path, recording, HEADER + "3,N,head,10,20,,2,\n").until(3)
    assert one.camera is recording.cameras["N_right"]
    assert one.confidence == 1.0
    assert one.position.shape == (2,)


def test_no_confidence_says_nothing(tmp_path, recording):
    assert len(_read(tmp_path, recording, HEADER + "3,,head,0,0,1,0.1,0\n")) == 0


@pytest.mark.parametrize(
    ("row", "word"),
    [
        ("0,,nose,0,0,1,0.1,1", "'nose'"),
        ("0,X,head,0,0,,0.1,1", "'X'"),
        ("0,N,head,0,0,1,0.1,1", "has both a view and a z"),
        ("0,,head,0,0,,0.1,1", "as z"),
        ("0,,head,0,0,1,0,1", "sigma"),
        ("soon,,head,0,0,1,0.1,1", "'soon' as frame"),
    ],
)
def test_mistakes_are_told_with_their_line(tmp_path, recording, row, word):
    with pytest.raises(InputError, match="line 2") as told:
        _read(tmp_path, recording, HEADER + row + "\n")
    assert word in str(told.value)
    assert "detections.csv" in str(told.value)
