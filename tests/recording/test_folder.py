"""Every mistake in a folder is one sentence with file, key and remedy."""

import re
import shutil

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.description import Subject, read_subject, write_subject
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.recording.landmarks import read_landmarks

N_LEFT = 'frames = "N_left/%03d.png"'

MISTAKES = {
    # file, old, new, what the sentence says
    "no format": ("recording.toml", "format = 1\n", "", "format: the key is missing"),
    "later format": ("recording.toml", "format = 1", "format = 2", "unknown format 2"),
    "no fps": ("recording.toml", "fps = 10.0", "", "fps: the key is missing"),
    "fps 0": ("recording.toml", "fps = 10.0", "fps = 0", "fps: 0 frame sets per second"),
    "fps text": ("recording.toml", "fps = 10.0", 'fps = "10"', "fps: '10' is not a finite number"),
    "kind": ("recording.toml", 'kind = "stereo"', 'kind = "sterio"', "unknown kind 'sterio'"),
    "no calibration": ("recording.toml", '"calibration', '"c', "file 'c.toml' not found"),
    "camera": ("recording.toml", 'camera = "N_left"', 'camera = "X"', "camera 'X' is not in the"),
    "no frames": ("recording.toml", N_LEFT, "", "left, frames: the key is missing"),
    "outside": ("recording.toml", N_LEFT, 'frames = "../%03d.png"', "leaves the recording folder"),
    "drive": ("recording.toml", N_LEFT, "frames = 'C:\\%03d.png'", "leaves the recording folder"),
    "background": ("recording.toml", '"N_left/000.png"', '"gone.png"', "file 'gone.png' not found"),
    "same view": ("recording.toml", 'name = "O"', 'name = "N"', "two views named 'N'"),
    "units": ("calibration.toml", 'units = "m"', "", "the unit of the translations is not stated"),
    "singular": ("calibration.toml", "40.0,\n        0.0,", "0.0,\n        0.0,", "singular"),
    "short": ("calibration.toml", "rotation = [", "rotation = [0.0]\nx = [", "rotation vector"),
    "coefficients": (
        "calibration.toml",
        "distortions = [",
        "distortions = [0,0,0]\nx = [",
        "has 3",
    ),
    "same camera": ("calibration.toml", '"N_left"', '"N_right"', "two cameras named 'N_right'"),
    "length": ("subject.toml", "shoulder_width = 0.4", "shoulder_width = -1", "not possible"),
    "column": ("reference.csv", "landmark", "point", "column 'landmark' is missing"),
    "empty": ("segments.csv", "0,8", "8,8", "from 8 to 8"),
}


def change(folder, file, old, new):
    text = (folder / file).read_text()
    assert old in text, text
    (folder / file).write_text(text.replace(old, new, 1))


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence_and_among_the_findings(small_recording, mistake):
    file, old, new, says = MISTAKES[mistake]
    change(small_recording.folder, file, old, new)
    with pytest.raises(InputError) as error:
        open_recording(small_recording.folder)
    sentence = str(error.value)
    assert says in sentence
    assert file in sentence or "recording.toml" in sentence
    assert "\n" not in sentence
    assert error.value.remedy
    found = [f for f in examine(small_recording.folder) if f.severity == "error"]
    assert any(f.what == error.value.what and f.where == error.value.where for f in found)


@pytest.mark.parametrize("file", ["recording.toml", "calibration.toml", "N_left/000.png"])
def test_a_file_that_is_gone_is_named(small_recording, file):
    (small_recording.folder / file).unlink()
    if file == "N_left/000.png":  # the pattern starts at its lowest index, the background is gone
        file = "000.png"
    with pytest.raises(InputError, match=re.escape(file)):
        open_recording(small_recording.folder)


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match="there is no such folder"):
        open_recording(tmp_path / "nowhere")
    assert [f.severity for f in examine(tmp_path / "nowhere")] == ["error"]


def test_several_mistakes_are_told_at_once(small_recording):
    for name in ("fps 0", "units", "camera", "singular", "empty"):
        change(small_recording.folder, *MISTAKES[name][:3])
    said = " ".join(f.what for f in examine(small_recording.folder, deep=True))
    for name in ("units", "camera", "singular", "empty"):
        assert MISTAKES[name][3].split(": ")[-1] in said


def test_unknown_keys_and_sections_are_ignored(small_recording):
    change(small_recording.folder, "recording.toml", "format = 1", "format = 1\nmade_by = 'me'")
    change(small_recording.folder, "calibration.toml", "[metadata]", "[metadata]\nerror = 0.3")
    assert open_recording(small_recording.folder).views == small_recording.views


def test_millimetres_become_metres(small_recording):
    path = small_recording.folder / "calibration.toml"
    before = read_calibration(path)
    change(small_recording.folder, "calibration.toml", 'units = "m"', 'units = "mm"')
    for name, camera in read_calibration(path).items():
        ours, theirs = (one.camera_from_world.translation for one in (camera, before[name]))
        assert np.allclose(ours, theirs / 1000, rtol=1e-12)


def test_empty_and_nan_coordinates_are_unknown(tmp_path):
    path = tmp_path / "reference.csv"
    rows = "3,head,2,1,2,\n,head,5,1,2,\n9,left_hip,5,inf,2,a\n1,nose,5,1,1,\n"
    path.write_text(f"z,landmark,frame,x,y,note\n{rows}")
    found = read_landmarks(path)
    assert found.frame.tolist() == [2, 5]
    assert found.points[0, 6].tolist() == [1, 2, 3]
    assert np.isnan(found.points[1, 6, 2])
    assert not np.isfinite(found.points[1]).all(axis=1).any()


def test_it_stays_when_the_folder_moves_or_the_reference_is_mended(small_recording, tmp_path):
    before = fingerprint(open_recording(small_recording.folder))
    assert len(before) == 32
    elsewhere = tmp_path.parent / f"{tmp_path.name} elsewhere"
    shutil.copytree(small_recording.folder, elsewhere)
    reference = elsewhere / "reference.csv"
    reference.write_text(reference.read_text().replace("1.400000", "1.410000"))
    assert fingerprint(open_recording(elsewhere)) == before


def test_it_changes_with_description_calibration_and_images(small_recording):
    folder = small_recording.folder
    seen = {fingerprint(open_recording(folder))}
    for change in (
        lambda: append(folder / "recording.toml"),
        lambda: append(folder / "calibration.toml"),
        lambda: append(folder / "N_left/000.png"),
        lambda: (folder / "W_right/007.png").unlink(),
    ):
        change()
        seen.add(fingerprint(open_recording(folder)))
    assert len(seen) == 5


def append(path):
    with path.open("ab") as file:
        file.write(b"\n# more\n")


OFFSETS = {"left_hip": (0.001, -0.02, 0.0), "head": (0.0, 0.0, -0.003)}


@pytest.mark.parametrize(
    "subject",
    [Subject("P"), Subject("P", torso_length=0.5), Subject("P", hip_width=0.2, offsets=OFFSETS)],
)
def test_a_subject_comes_back_as_it_was(tmp_path, subject):
    write_subject(tmp_path / "subject.toml", subject)
    assert read_subject(tmp_path / "subject.toml") == subject
    assert hash(read_subject(tmp_path / "subject.toml")) == hash(subject)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("left_knee = [0.0, 0.0, 0.0]", "unknown landmark 'left_knee'"),
        ("left_hip = [0.0, 20.0, 0.0]", "is not a possible offset"),
        ("left_hip = 3", "is not 3 numbers"),
    ],
)
def test_wrong_offsets_are_named(tmp_path, line, words):
    (tmp_path / "s.toml").write_text(f"[offsets]\n{line}\n")
    with pytest.raises(InputError, match="offsets") as told:
        read_subject(tmp_path / "s.toml")
    assert words in str(told.value)
