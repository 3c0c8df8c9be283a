"""Each correction undoes its fault in the file, and leaves whatever else the file says."""

import dataclasses
import shutil

import numpy as np
import pytest

from stereotrack_core.doctor.corrections import corrected_text, file_of, words_of
from stereotrack_core.doctor.slips import (
    centre_exchanged,
    inverted,
    resized,
    transposed,
    undistorted,
)
from stereotrack_core.errors import Correction, InputError
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.recording.writing import write_recording_description
from tests.recording.small import written_recording


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """The small recording, written once."""
    return written_recording(tmp_path_factory.mktemp("small")).folder


@pytest.fixture
def sound(pictures, tmp_path):
    """A copy of it without segments, whose principal points are not in the middle."""
    recording = open_recording(shutil.copytree(pictures, tmp_path / "small"))
    (recording.folder / "segments.csv").unlink()
    matrix = np.array([[40.0, 0, 22.0], [0, 40, 17.5], [0, 0, 1]])
    cameras = {n: dataclasses.replace(c, matrix=matrix) for n, c in recording.cameras.items()}
    return dataclasses.replace(recording, cameras=cameras, segments=())


def corrected(recording, *what, **amount):
    """The recording read again after a correction of what was written."""
    write_recording_description(recording)
    correction = Correction(*what, **amount)
    path = file_of(recording.folder, correction)
    path.write_text(corrected_text(recording, path, correction))
    assert words_of(correction).endswith(".")
    return open_recording(recording.folder)


def same_cameras(one, other):
    return all(
        np.allclose(one.cameras[n].matrix, c.matrix)
        and np.allclose(one.cameras[n].distortions, 0)
        and np.allclose(one.cameras[n].camera_from_world.matrix(), c.camera_from_world.matrix())
        for n, c in other.cameras.items()
    )


def far(camera):
    old = camera.camera_from_world
    moved = RigidTransform(old.rotation, 1000 * old.translation)
    return dataclasses.replace(camera, camera_from_world=moved)


def bent(camera):
    return dataclasses.replace(camera, distortions=np.array([0.1, 0, 0, 0, 0]))


@pytest.mark.parametrize(
    ("fault", "kind", "amount"),
    [
        (transposed, "transpose", 1.0),
        (inverted, "invert", 1.0),
        (centre_exchanged, "exchange_centre", 1.0),
        (lambda c: resized(c, 2.0), "resize", 0.5),
        (far, "scale_translation", 0.001),
        (bent, "undistort", 1.0),
    ],
)
def test_cameras_are_as_they_were(sound, fault, kind, amount):
    names = ("N_left", "S_right")
    wrong = {n: fault(c) if n in names else c for n, c in sound.cameras.items()}
    again = corrected(dataclasses.replace(sound, cameras=wrong), kind, names, amount)
    assert same_cameras(again, sound)
    assert undistorted(again.cameras["N_left"]).matrix[0, 2] == pytest.approx(22.0)


def test_a_base_line_is_stretched_from_the_right_camera(sound):
    again = corrected(sound, "scale_base_line", ("N",), 1.2)
    left, right = (again.cameras[f"N_{side}"].position_world for side in ("left", "right"))
    assert np.linalg.norm(left - right) == pytest.approx(0.12)
    assert np.allclose(right, sound.cameras["N_right"].position_world)


def test_units_comments_of_tools_and_unknown_keys_stay(sound):
    write_recording_description(sound)
    path = sound.folder / "calibration.toml"
    text = path.read_text().replace('units = "m"', 'units = "mm"\ntool = "X"')
    path.write_text(text.replace('name = "N_left"', 'name = "N_left"\nerror = 0.25'))
    given = open_recording(sound.folder)
    change = Correction("transpose", ("N_left",))
    path.write_text(corrected_text(given, path, change))
    for kept in ('tool = "X"', "error = 0.25", 'units = "mm"'):
        assert kept in path.read_text()
    path.write_text(corrected_text(open_recording(sound.folder), path, change))
    assert same_cameras(open_recording(sound.folder), given)


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
    wrong = dataclasses.replace(
        sound, views=(dataclasses.replace(n, left=n.image, image=n.left), *rest, w)
    )
    assert corrected(wrong, "exchange_sides", ("N",)).views == sound.views


def test_streams_begin_later_or_all_others_do(sound):
    alone = dataclasses.replace(sound, reference=None)
    later = corrected(alone, "shift_frames", ("O",), 3.0)
    assert [v.image.first_frame for v in later.views] == [0, 3, 0, 0]
    assert later.view("O").left.first_frame == 3
    later = corrected(later, "shift_left", ("O",), -4.0)
    assert [v.left.first_frame for v in later.views] == [1, 0, 1, 1]
    assert [v.image.first_frame for v in later.views] == [1, 4, 1, 1]
    with pytest.raises(InputError, match="count frames from their beginning"):
        corrected(sound, "shift_frames", ("O",), -3.0)
    assert corrected(sound, "set_fps", (), 12.5).fps == 12.5


@pytest.mark.parametrize(
    ("change", "what", "amount"),
    [
        (lambda p: p[..., [0, 2, 1]] * [1, 1, -1], ("turn_axes", ("x", "-z", "y")), 1.0),
        (lambda p: 1000 * p, ("scale_points",), 0.001),
        (lambda p: p[:, [LANDMARKS.index(n) for n in MIRROR]], ("exchange_names",), 1.0),
    ],
)
def test_a_reference_is_as_it_was(sound, change, what, amount):
    points = change(sound.reference.points)
    wrong = LandmarkTrajectory(sound.reference.frame, points)
    again = corrected(dataclasses.replace(sound, reference=wrong), *what, amount=amount)
    assert np.allclose(again.reference.points, sound.reference.points, atol=2e-6)


MIRROR = [
    f"{ {'left': 'right', 'right': 'left'}[n[: -len(r) - 1]] }_{r}" if r else n
    for n in LANDMARKS
    for r in [n.partition("_")[2]]
]


def test_a_reference_that_is_late_loses_what_is_before_the_first_frame(sound):
    again = corrected(sound, "shift_reference", amount=-2.0)
    assert again.reference.frame.tolist() == list(range(6))
    text = (sound.folder / "reference.csv").read_text()
    (sound.folder / "reference.csv").write_text(f"{text}7,tail,1,2,3\n")
    again = open_recording(sound.folder)
    change = Correction("shift_reference", amount=1.0)
    path = file_of(sound.folder, change)
    assert corrected_text(again, path, change).endswith("8,tail,1,2,3\n")


def test_lengths_of_a_subject(sound):
    again = corrected(sound, "scale_lengths", amount=1.25)
    assert (again.subject.shoulder_width, again.subject.torso_length) == (0.5, 0.625)
    assert again.subject.name == "P"
