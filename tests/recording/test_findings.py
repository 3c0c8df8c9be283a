"""The doctor finds what is wrong and says nothing of what is right."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.camera_checks import inverted, transposed
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.recording.writing import write_png, write_recording_description


def said(recording, deep=False):
    """What is found, as one text of `severity where: what. remedy` lines."""
    write_recording_description(recording)
    found = examine(recording.folder, deep=deep)
    return "\n".join(f"{f.severity} {f.where}: {f.what}. {f.remedy}" for f in found)


def with_cameras(recording, change):
    """The recording with cameras changed by a function (camera) -> camera."""
    return replace(recording, cameras={n: change(c) for n, c in recording.cameras.items()})


def moved(camera, transform):
    return replace(camera, camera_from_world=transform)


def with_points(recording, change):
    reference = recording.reference
    points = change(reference.points.copy())
    return replace(recording, reference=LandmarkTrajectory(reference.frame, points))


def exchanged(points, a, b):
    i, j = LANDMARKS.index(a), LANDMARKS.index(b)
    points[:, [i, j]] = points[:, [j, i]]
    return points


def test_nothing_is_said_of_a_sound_recording(small_recording):
    assert said(small_recording, deep=True) == ""


def test_a_transposed_matrix(small_recording):
    text = said(with_cameras(small_recording, lambda c: replace(c, matrix=c.matrix.T)))
    assert text.count("the matrix is transposed") == 8


@pytest.mark.parametrize("views", ["S", "NOSW"])
def test_cameras_in_millimetres_are_those_that_are_far_away(small_recording, views):
    far = with_cameras(small_recording, lambda c: c.scaled(1000) if c.name[0] in views else c)
    write_recording_description(far)
    [finding] = [one for one in examine(far.folder) if "km tall" in one.what]
    assert finding.correction.amount == 0.001
    assert set(finding.correction.names) == {f"{v}_{s}" for v in views for s in ("left", "right")}


def test_a_reference_in_other_units(small_recording):
    text = said(with_points(small_recording, lambda p: 1000 * p))
    assert "error reference.csv: its torso length" in text
    assert "km tall" in text


def test_one_transposed_rotation(small_recording):
    turned = with_cameras(small_recording, lambda c: transposed(c) if c.name[0] == "O" else c)
    text = said(turned)
    assert "warning calibration.toml, camera O_right, rotation: view O is not upright" in text
    assert "It would fit if it were transposed" in text
    assert text.count("rotation: view") == 1


def test_all_cameras_inverted(small_recording):
    flipped = with_cameras(small_recording, inverted)
    assert "upright, if they are inverted" in said(flipped)


def test_a_camera_on_its_side_needs_its_display_rotation(small_recording):
    on_its_side = rotation_from_vector(np.array([0, 0, np.pi / 2]))

    def turn(camera):
        old = camera.camera_from_world
        new = RigidTransform(on_its_side @ old.rotation, on_its_side @ old.translation)
        return moved(camera, new) if camera.name == "S_right" else camera

    mono = tuple(replace(v, kind="mono", left=None) for v in small_recording.views)
    recording = replace(with_cameras(small_recording, turn), views=mono)
    assert "view S is not upright" in said(recording)
    for degrees, fits in ((90, False), (180, False), (270, True)):
        views = tuple(replace(v, display_rotation=degrees if v.name == "S" else 0) for v in mono)
        assert ("is not upright" in said(replace(recording, views=views))) != fits


def test_a_camera_that_looks_away(small_recording):
    away = rotation_from_vector(np.array([0, 2.0, 0]))

    def turn(camera):
        old = camera.camera_from_world
        new = RigidTransform(away @ old.rotation, away @ old.translation)
        return moved(camera, new) if camera.name[0] == "W" else camera

    text = said(with_cameras(small_recording, turn))
    assert "view W does not look towards" in text
    assert text.count("does not look towards") == 1


def test_a_swapped_pair(small_recording):
    *others, last = small_recording.views
    views = (*others, replace(last, image=last.left, left=last.image))
    text = said(replace(small_recording, views=views))
    assert "error recording.toml, view W: left and right are swapped" in text


@pytest.mark.parametrize(
    ("pair", "says"),
    [
        (("left_hip", "right_hip"), "swapped at the hips or at the shoulders"),
        (("left_elbow", "right_elbow"), "closer to the shoulder of the other side"),
    ],
)
def test_swapped_sides_of_the_reference(small_recording, pair, says):
    assert says in said(with_points(small_recording, lambda p: exchanged(p, *pair)))


def test_a_reference_with_another_axis_up(small_recording):
    text = said(with_points(small_recording, lambda p: p[..., [0, 2, 1]] * [1, -1, 1]))
    assert "warning reference.csv: the person's trunk is" in text


def test_a_reference_out_of_sight(small_recording):
    text = said(with_points(small_recording, lambda p: p + [0, 0, 50.0]))
    assert text.count("of the reference is within this view's image") == 4


def test_names_and_frames_that_are_not_there(small_recording):
    write_recording_description(replace(small_recording, segments=(Segment("late", 5, 20),)))
    with (small_recording.folder / "reference.csv").open("a") as file:
        file.write("900,nose,1,2,3\n900,head,1,2,3\n")
    found = [(f.where, f.what) for f in examine(small_recording.folder)]
    assert any("nose" in what for _, what in found)
    assert any("1 of its 9 frames are not in the recording" in what for _, what in found)
    assert any("segments.csv, late" in where for where, _ in found)


def test_lengths_and_gaps_of_streams(small_recording):
    folder = small_recording.folder
    (folder / "N_left/007.png").unlink()
    (folder / "O_right/003.png").unlink()
    text = said(small_recording)
    assert "N left 7" in text
    assert "the first 7 frames are used" in text
    assert "1 images are missing between the first and the last" in text


def test_images_that_are_damaged_dark_frozen_or_unequal(small_recording):
    folder = small_recording.folder
    (folder / "N_left/004.png").write_bytes(b"no image")
    for k in (3, 4, 5):
        write_png(folder / f"O_left/{k:03d}.png", np.full((36, 48), 2, np.uint8))
    still = (folder / "S_right/001.png").read_bytes()
    for k in range(2, 8):
        (folder / f"S_right/{k:03d}.png").write_bytes(still)
    for k in range(8):
        bright = cv2.imread(str(folder / f"W_left/{k:03d}.png"), cv2.IMREAD_GRAYSCALE)
        write_png(folder / f"W_left/{k:03d}.png", (bright * 0.6).astype(np.uint8))
    assert said(small_recording).startswith("")
    text = said(small_recording, deep=True)
    assert "error view N: 1 frames cannot be decoded; the first: View N, frame 4" in text
    assert "view O, left: the view is dark from frame 3 to 5" in text
    assert "view S, right: the image is frozen from frame 1 to 7" in text
    assert "view W: the left image is darker by a factor of 1." in text
    assert len(text.splitlines()) == 4


def board_track(camera: Camera, times):
    """Pixels (F, 12, 2) of a board that swings."""
    x, y = np.meshgrid(np.arange(4) * 0.08, np.arange(3) * 0.08)
    corners = np.stack([x.ravel(), np.zeros(12), y.ravel() + 1.2], axis=-1)
    swing = 0.5 * np.sin(1.2 * np.asarray(times))[:, None, None] * np.array([1, 0.4, 0.6])
    return camera.project(corners + swing)


def write_corners(folder, tracks):
    rows = ["frame,view,corner,x,y"]
    for view, track in tracks.items():
        rows += [
            f"{k},{view},{c},{x:.3f},{y:.3f}"
            for k, points in enumerate(track)
            for c, (x, y) in enumerate(points)
        ]
    (folder / "board_corners_2d.csv").write_text("\n".join(rows) + "\n")


def test_a_view_out_of_step_is_found(small_recording):
    lag, words = 0.4, "later"
    cameras = {n: small_recording.cameras[f"{n}_right"] for n in "NOSW"}
    zoomed = {n: replace(c, matrix=c.matrix * [[20], [20], [1]]) for n, c in cameras.items()}
    right = {f"{n}_right": replace(c, matrix=cameras[n].matrix) for n, c in zoomed.items()}
    recording = replace(small_recording, cameras={**small_recording.cameras, **right})
    frames = np.arange(40.0)
    noise = np.random.default_rng(1)
    lags = {**dict.fromkeys(cameras, 0.0), "W": lag}
    tracks = {n: board_track(c, frames - lags[n]) for n, c in cameras.items()}
    tracks = {n: track + noise.normal(0, 0.05, track.shape) for n, track in tracks.items()}
    write_corners(recording.folder, tracks)
    text = said(recording, deep=True)
    assert "view W, time_offset: it is not synchronised" in text
    assert words in text
    assert f"time_offset = {lag / 10:.3f}"[:-1] in text


def test_a_view_that_disagrees_is_found(small_recording):
    cameras = {n: small_recording.cameras[f"{n}_right"] for n in "NOSW"}
    frames = np.arange(40.0)
    tracks = {n: board_track(c, frames) + (8 if n == "O" else 0) for n, c in cameras.items()}
    write_corners(small_recording.folder, tracks)
    text = said(small_recording, deep=True)
    assert "calibration.toml, view O: it disagrees with the other cameras" in text


def test_known_flaws_of_real_recordings(shared_recording):
    found = examine(shared_recording("seated-4cam"), deep=True)
    assert ["cam_1" in f.where and "not synchronised" in f.what for f in found] == [True]
    found = examine(shared_recording("beam-4cam"), deep=True)
    assert ["cam03" in f.where and "disagrees" in f.what for f in found] == [True]
