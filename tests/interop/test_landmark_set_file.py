"""A set of landmarks goes into a file and comes back; slips are named with file and landmark."""

import pytest
import tomli_w

from stereotrack_core.annotation.landmark_set import NINE, Landmark, LandmarkSet, read_landmark_set
from stereotrack_core.errors import InputError

WRIST = Landmark("left_wrist", "#112233", "left_forearm", "left_forearm", 0.7, 0.0, (0, 0.01, 0))


@pytest.mark.parametrize("landmarks", [NINE, LandmarkSet("with wrist", (*NINE.landmarks, WRIST))])
def test_round_trip(tmp_path, landmarks):
    (tmp_path / "set.toml").write_text(tomli_w.dumps(landmarks.facts()))
    assert read_landmark_set(tmp_path / "set.toml") == landmarks


def test_a_set_without_a_name_gets_the_files(tmp_path):
    path = tmp_path / "mine.toml"
    facts = 'name = "nose"\ncolour = "#112233"\nlimb = "head"\npart = "head"'
    path.write_text(f"[[landmarks]]\n{facts}\n")
    found = read_landmark_set(path)
    assert (found.name, found.names) == ("mine", ("nose",))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no landmarks"),
        ("landmarks = 3", "not a list"),
        ('[[landmarks]]\nname = "nose"\nlimb = "tail"\npart = "head"\ncolour = "#112233"', "tail"),
        ('[[landmarks]]\nname = "nose"\nshoe = 3', "shoe"),
        ("landmarks = [", "TOML"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, said):
    path = tmp_path / "set.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=said) as caught:
        read_landmark_set(path)
    assert "set.toml" in caught.value.where
    assert caught.value.remedy


def test_a_missing_file_is_said(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_landmark_set(tmp_path / "none.toml")
