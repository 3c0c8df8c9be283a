"""A correction is made only if the checks that asked for it are content then."""

import dataclasses
import shutil

import numpy as np
import pytest

from stereotrack_core.doctor import correcting
from stereotrack_core.doctor.correcting import correct, correct_all, corrected_text, intended
from stereotrack_core.errors import Correction, Finding, InputError
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.camera_checks import transposed
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.writing import write_recording_description
from tests.end_to_end.writers import content_of, full_disk
from tests.recording.small import written_recording


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    return written_recording(tmp_path_factory.mktemp("small")).folder


@pytest.fixture
def wrong(pictures, tmp_path, monkeypatch):
    """A copy in which the rotations of view O are transposed; its noise is not measured."""
    folder = shutil.copytree(pictures, tmp_path / "small")
    path = folder / "calibration.toml"
    cameras = read_calibration(path)
    change = {n: transposed(c) if n[0] == "O" else c for n, c in cameras.items()}
    write_calibration(path, change)
    monkeypatch.setattr(correcting, "diagnose", lambda *_: ())
    return folder


@pytest.fixture
def sound(pictures, tmp_path):
    recording = open_recording(shutil.copytree(pictures, tmp_path / "small"))
    (recording.folder / "segments.csv").unlink()
    return dataclasses.replace(recording, segments=())


def serious(folder):
    return [one for one in examine(folder) if one.severity != "note"]


def corrected(recording, *what, file="recording.toml"):
    """The recording read again after a correction of what was written."""
    write_recording_description(recording)
    path = recording.folder / file
    path.write_text(corrected_text(recording, path, Correction(*what)))
    return open_recording(recording.folder)


def test_what_is_found_is_corrected_and_the_file_before_is_kept(wrong):
    [finding] = serious(wrong)
    assert finding.correction == Correction("transpose", ("O_left", "O_right"))
    said = "calibration.toml: Transpose the rotation of O_left and O_right."
    assert intended(wrong, finding.correction) == said
    before, told = (wrong / "calibration.toml").read_bytes(), []
    late = Finding("error", "view S", "shaken", "", Correction("shift_frames", ("S",), -1.0))
    [done] = correct_all(wrong, (finding, late), told.append)  # the second is not possible
    assert done.kept.read_bytes() == before
    assert done.kept.name == "calibration-before-1.toml"
    assert told[2] == "Corrected. The file before is calibration-before-1.toml."
    assert not serious(wrong)


@pytest.mark.parametrize(
    ("place", "correction", "said"),
    [
        (None, ("exchange_views", ("N", "S")), "the problem would not be gone"),
        ("view S", ("scale_translation", ("S_left", "S_right"), 1000.0), "another one"),
        ("view S", ("shift_frames", ("S",), -1.0), "count frames from their beginning"),
    ],
)
def test_nothing_is_changed_if_it_would_not_help(wrong, place, correction, said):
    [finding] = serious(wrong)
    other = dataclasses.replace(
        finding, where=place or finding.where, correction=Correction(*correction)
    )
    before = content_of(wrong)
    with pytest.raises(InputError, match=said):
        correct(wrong, other)
    assert content_of(wrong) == before


def test_a_full_disk_leaves_everything_as_it_was(wrong):
    [finding] = serious(wrong)
    before = content_of(wrong)
    with full_disk(1000), pytest.raises(InputError, match="could not be written"):
        correct(wrong, finding)
    assert content_of(wrong) == before


@pytest.mark.parametrize(
    ("fault", "kind", "amount"),
    [
        (transposed, "transpose", 1.0),
        (lambda camera: camera.scaled(1000), "scale_translation", 0.001),
    ],
)
def test_cameras_are_as_they_were(sound, fault, kind, amount):
    names = ("N_left", "S_right")
    cameras = {n: fault(c) if n in names else c for n, c in sound.cameras.items()}
    wrong = dataclasses.replace(sound, cameras=cameras)
    again = corrected(wrong, kind, names, amount, file="calibration.toml").cameras
    for name, camera in sound.cameras.items():
        assert np.allclose(
            again[name].camera_from_world.matrix(), camera.camera_from_world.matrix()
        )


def test_units_comments_of_tools_and_unknown_keys_stay(sound):
    write_recording_description(sound)
    path = sound.folder / "calibration.toml"
    text = path.read_text().replace('units = "m"', 'units = "mm"\ntool = "X"')
    path.write_text(text.replace('name = "N_left"', 'name = "N_left"\nerror = 0.25'))
    change = Correction("transpose", ("N_left",))
    path.write_text(corrected_text(open_recording(sound.folder), path, change))
    for kept in ('tool = "X"', "error = 0.25", 'units = "mm"'):
        assert kept in path.read_text()


def exchanged(view, other):
    def taken(stream, files):
        return dataclasses.replace(files, camera=stream.camera)

    return dataclasses.replace(
        view, image=taken(view.image, other.image), left=taken(view.left, other.left)
    )


def test_files_of_views_and_pairs_are_exchanged(sound):
    n, *rest, w = sound.views
    wrong = dataclasses.replace(sound, views=(exchanged(n, w), *rest, exchanged(w, n)))
    assert corrected(wrong, "exchange_views", ("N", "W")).views == sound.views
    mixed = dataclasses.replace(
        n,
        left=dataclasses.replace(n.image, camera=n.left.camera),
        image=dataclasses.replace(n.left, camera=n.image.camera),
    )
    wrong = dataclasses.replace(sound, views=(mixed, *rest, w))
    assert corrected(wrong, "exchange_pair", ("N",)).views == sound.views


def test_streams_begin_later_or_all_others_do(sound):
    alone = dataclasses.replace(sound, reference=None)
    later = corrected(alone, "shift_frames", ("O",), 3.0)
    assert [v.image.first_frame for v in later.views] == [0, 3, 0, 0]
    assert later.view("O").left.first_frame == 3
    later = corrected(later, "shift_left", ("O",), -4.0)
    assert [v.left.first_frame for v in later.views] == [1, 0, 1, 1]
    assert [v.image.first_frame for v in later.views] == [1, 4, 1, 1]
