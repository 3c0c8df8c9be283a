"""Cameras from clicks of a person and one length."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import landmarks
from stereotrack_core.calibrate.person import FEWEST, KnownLength, calibrate_from_person
from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import read_calibration, write_calibration
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.tracking.keypoints.cases import BODY
from tests.tracking.keypoints.cases import VIEWS as SMALL
from tests.tracking.scenes import POSES

_LARGER = 5


def larger(camera):
    size = _LARGER * camera.width, _LARGER * camera.height
    matrix = camera.matrix * _LARGER
    matrix[:2, 2], matrix[2, 2] = ((size[0] - 1) / 2, (size[1] - 1) / 2), 1.0
    return replace(camera, width=size[0], height=size[1], matrix=matrix)


VIEWS = {name: larger(camera) for name, camera in SMALL.items()}
SIZES = {name: (one.width, one.height) for name, one in VIEWS.items()}
SHARE = VIEWS["N"].focal / max(SIZES["N"])


def walk(frames, seed=3):
    """Landmarks (F, 9, 3) of a person who steps about and reaches differently each time."""
    rng = np.random.default_rng(seed)
    turn = np.zeros((frames, 14))
    turn[:, :2] = rng.uniform(-0.4, 0.4, (frames, 2))
    turn[:, 5] = rng.uniform(-1.5, 1.5, frames)
    turn[:, 6:] = rng.uniform(-0.6, 0.6, (frames, 8))
    return np.array([landmarks(BODY, displaced(POSES["pointing"], one, (2, 3, 4, 5)))
                     for one in turn])  # fmt: skip


def clicked(points, noise=1.0, seed=1):
    rng = np.random.default_rng(seed)
    found = {}
    for frame, here in enumerate(points):
        for name, place in zip(LANDMARKS, here, strict=True):
            seen = {view: camera.project(place) for view, camera in VIEWS.items()}
            found[frame, name] = {
                view: tuple((pixel + noise * rng.normal(size=2)).tolist())
                for view, pixel in seen.items()
                if (pixel > 0).all() and (pixel < SIZES[view]).all()
            }
    return found


def shoulders(points):
    left, right = (points[:, LANDMARKS.index(f"{side}_shoulder")] for side in ("left", "right"))
    apart = float(np.median(np.linalg.norm(left - right, axis=1)))
    return KnownLength("left_shoulder", "right_shoulder", apart)


def errors(found, points):
    """Degrees of rotations and metres of places relative to the first camera."""
    first, own = VIEWS["N"].camera_from_world, found["N"].camera_from_world
    turns, shifts = [], []
    for name in [name for name in VIEWS if name != "N"]:
        true = VIEWS[name].camera_from_world @ first.inverse()
        said = found[name].camera_from_world @ own.inverse()
        cosine = (np.trace(true.rotation.T @ said.rotation) - 1.0) / 2.0
        turns.append(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
        shifts.append(np.linalg.norm(true.inverse().translation - said.inverse().translation))
    away = np.linalg.norm(VIEWS["N"].position_world - points.reshape(-1, 3).mean(axis=0))
    return max(turns), max(shifts) / away


@pytest.mark.parametrize(("share", "frames"), [(None, 30), (SHARE, 12)])
def test_clicks_of_one_pixel_tell_the_cameras(share, frames):
    points = walk(frames)
    found = calibrate_from_person(clicked(points), SIZES, shoulders(points), share)
    turn, shift = errors(found.cameras, points)
    assert turn < 1.0
    assert shift < 0.03
    assert found.rms_px < 1.5
    assert 0.25 < shift / found.shift < 4.0, "what is stated is about what is true"
    assert f"{found.clicks} clicks are met within" in found.words()
    up = found.cameras["N"].camera_from_world.rotation[:, 2]
    assert up @ VIEWS["N"].camera_from_world.rotation[:, 2] > np.cos(np.radians(15.0))


def test_the_file_states_how_far_the_places_may_be_off(tmp_path):
    points = walk(12)
    found = calibrate_from_person(clicked(points), SIZES, shoulders(points), SHARE)
    away = np.linalg.norm(VIEWS["N"].position_world - points.reshape(-1, 3).mean(axis=0))
    assert found.cameras["N"].place_sigma == pytest.approx(found.shift * away, rel=0.3)
    write_calibration(tmp_path / "cameras.toml", found.cameras)
    read = read_calibration(tmp_path / "cameras.toml")
    assert read["S"].place_sigma == pytest.approx(found.cameras["S"].place_sigma)


def test_too_few_clicks_are_refused_with_what_is_missing():
    points = walk(12)
    some = {key: own for key, own in clicked(points).items() if key[0] < 2}
    with pytest.raises(InputError, match=rf"{FEWEST - 18} more in N, .* 2 more frames"):
        calibrate_from_person(some, SIZES, shoulders(points), SHARE)
    alone = {
        key: {v: p for v, p in own.items() if v != "S"} for key, own in clicked(points).items()
    }
    with pytest.raises(InputError, match=f"too few clicks: {FEWEST} more in S"):
        calibrate_from_person(alone, SIZES, shoulders(points), SHARE)
    unseen = KnownLength("left_knee", "right_knee", 0.3)
    with pytest.raises(InputError, match="no frame has the left knee"):
        calibrate_from_person(clicked(points), SIZES, unseen, SHARE)


def test_what_does_not_tell_the_cameras_is_no_calibration():
    points = walk(5)
    with pytest.raises(InputError, match=r"only. .* more clicks are needed for 1°"):
        calibrate_from_person(clicked(points, noise=3.0), SIZES, shoulders(points))
    exchanged = {
        (frame, name): {
            view: clicked_one[frame, other(name) if view == "S" else name][view]
            for view in clicked_one[frame, name]
        }
        for clicked_one in [clicked(walk(12))]
        for frame, name in clicked_one
        if "S" in clicked_one[frame, other(name)]
    }
    with pytest.raises(InputError, match="left and right are the same"):
        calibrate_from_person(exchanged, SIZES, shoulders(points), SHARE)


def other(name):
    sides = {"left": "right", "right": "left"}
    side, _, part = name.partition("_")
    return f"{sides[side]}_{part}" if side in sides else name
