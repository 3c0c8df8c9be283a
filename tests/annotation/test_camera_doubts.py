"""A camera that contradicts the others is named; clicks that are wrong themselves stay clicks."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import ACCEPTED
from stereotrack_core.annotation.doubts import (
    doubtful_camera,
    own_outliers,
    residuals_by_camera,
    what_disagrees,
    what_to_do,
)
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.camera_agreement import disagreeing_camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.interop.labels import read_clicks
from stereotrack_core.recording.folder import open_recording
from tests.annotation.scenes import (
    LENSES,
    MATRIX,
    bodies,
    clicks_of,
    looking_in,
    moved_click,
    one_camera_off,
)

NOISE = 2.0
BODIES = bodies(160, 3)[::2]


def rig(rng: np.random.Generator, count: int) -> dict[str, Camera]:
    turn = rng.uniform(0.0, 360.0)
    azimuths = turn + np.arange(count) * 360.0 / count + rng.uniform(-25.0, 25.0, count)
    lens, _ = LENSES["barrel"]
    return {
        f"cam{i}": Camera(
            f"cam{i}", 640, 480, MATRIX, lens, False, looking_in(azimuth, rng.uniform(2.2, 3.5))
        )
        for i, azimuth in enumerate(azimuths)
    }


def seen(cameras: dict[str, Camera], points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Pixels (V, F, 9, 2) with noise."""
    exact = np.stack([camera.project(points) for camera in cameras.values()])
    return exact + rng.normal(0.0, NOISE, exact.shape)


def turned(camera: Camera, rng: np.random.Generator) -> Camera:
    """By 3 degrees about any axis."""
    axis = rng.normal(size=3)
    turn = rotation_from_vector(np.radians(3.0) * axis / np.linalg.norm(axis))
    old = camera.camera_from_world
    moved = RigidTransform(turn @ old.rotation, turn @ old.translation)
    return replace(camera, camera_from_world=moved)


def judged(fault: str, count: int, frames: int, seed: int) -> tuple[str, str, float]:
    """The faulty camera, the one that is named (``none``, ``pair``), and how late it is said."""
    rng = np.random.default_rng(seed)
    cameras = rig(rng, count)
    name = str(rng.choice(list(cameras)))
    bad = list(cameras).index(name)
    first = int(rng.integers(2, len(BODIES) - frames))
    points = BODIES[first : first + frames]
    pixels = seen(cameras, points, rng)
    if fault == "off":
        angle = rng.uniform(0.0, 2.0 * np.pi)
        pixels[bad] += 40.0 * np.array([np.cos(angle), np.sin(angle)])
    elif fault == "turned":
        pixels[bad] = seen({name: turned(cameras[name], rng)}, points, rng)[0]
    elif fault == "late":
        pixels[bad] = seen({name: cameras[name]}, BODIES[first - 2 : first - 2 + frames], rng)[0]
    elif fault == "wrong clicks":
        wrong = rng.random(pixels.shape[:3]) < 0.05
        pixels[wrong] += rng.normal(0.0, 60.0, (int(wrong.sum()), 2))
    elif fault == "wrong clicks in one":
        wrong = rng.random(pixels.shape[1:3]) < 0.2
        pixels[bad, wrong] += rng.normal(0.0, 60.0, (int(wrong.sum()), 2))
    found = disagreeing_camera(tuple(cameras.values()), first + np.arange(frames), pixels)
    if found is None:
        return name, "none", np.nan
    return name, found.camera or "pair", found.late_frames


@pytest.mark.parametrize(("frames", "seeds"), [(1, 50), (4, 50), (40, 15)])
def test_sound_rigs_are_never_accused(frames, seeds):
    for seed in range(seeds):
        count = 2 + seed % 5
        assert judged("none", count, frames, seed)[1] == "none", (seed, count)


@pytest.mark.parametrize("fault", ["wrong clicks", "wrong clicks in one"])
def test_single_wrong_clicks_are_no_bad_camera(fault):
    for seed in range(30):
        _, said, _ = judged(fault, 3 + seed % 3, 4 + seed % 20, seed)
        assert said == "none", seed


@pytest.mark.parametrize(
    ("fault", "frames", "least"), [("off", 3, 25), ("turned", 3, 22), ("late", 40, 18)]
)
def test_the_faulty_one_of_four_is_named_and_never_another(fault, frames, least):
    """Movement tells of a clock only where something moves; then another is not named instead."""
    right = 0
    for seed in range(25):
        name, said, late = judged(fault, 4, frames, 500 + seed)
        assert said in {name, "pair", "none"}, seed
        right += said == name
        if fault == "late" and said == name:
            assert late == pytest.approx(2.0, abs=0.5), seed
    assert right >= least


def test_the_camera_of_a_real_recording_is_named_with_its_residual(shared_recording):
    recording = open_recording(shared_recording("beam-4cam"))
    clicks = read_clicks(recording.folder / "clicks.csv", recording, frames=100).checked()
    found = doubtful_camera(clicks, recording.cameras, NINE)
    assert found is not None
    assert "cam03 disagrees with the other three by 4" in what_disagrees(found)
    residuals = residuals_by_camera(clicks, recording.cameras, NINE, found)
    px = {one.camera: one.median_px for one in residuals}
    assert px["cam03"] == pytest.approx(found.off_px)
    assert max(px[name] for name in found.others) < 0.3 * px["cam03"]


def clicked(seed=0, count=4, frames=3):
    cameras = rig(np.random.default_rng(seed), count)
    return clicks_of(BODIES[10 : 10 + frames], cameras, sigma=NOISE, seed=seed), cameras


def test_it_is_said_by_how_much_and_what_to_do():
    clicks, cameras = clicked()
    assert doubtful_camera(clicks, cameras, NINE) is None
    found = doubtful_camera(one_camera_off(clicks, "cam3", (32.0, 24.0)), cameras, NINE)
    assert found is not None
    assert found.off_px == pytest.approx(40.0, abs=4.0)
    assert found.agreement_px < 4.0
    assert (found.count, found.off) == (27, 27)
    assert what_disagrees(found) == f"cam3 disagrees with the other three by {found.off_px:.0f} px"
    assert what_disagrees(found, {"cam3": "west"}).startswith("west disagrees")
    assert "calibration" in what_to_do(found)
    assert "synchronisation" in what_to_do(found)


def test_clicks_are_to_blame_only_for_what_is_wrong_without_that_camera():
    clicks, cameras = clicked()
    wrong = one_camera_off(clicks, "cam3", (32.0, 24.0))
    wrong[4] = moved_click(wrong[4], (45.0, 0.0))
    assert wrong[4].camera != "cam3"
    found = doubtful_camera(wrong, cameras, NINE)
    same = (wrong[4].frame, wrong[4].landmark)
    keys = [one.key for one in wrong if one.camera == "cam3" or (one.frame, one.landmark) == same]
    assert own_outliers(keys, found, wrong, cameras) == (wrong[4].key,)
    assert own_outliers(keys, None, wrong, cameras) == tuple(keys)
    assert own_outliers([], found, wrong, cameras) == ()


def test_mixed_up_sides_are_no_bad_camera():
    clicks, cameras = clicked(seed=2, frames=5)
    mirror = {name: NINE[name].mirror or name for name in NINE.names}
    swapped = [
        replace(one, landmark=mirror[one.landmark]) if one.camera == "cam1" else one
        for one in clicks
    ]
    assert doubtful_camera(swapped, cameras, NINE) is None


def test_what_was_accepted_says_nothing():
    clicks, cameras = clicked(seed=5)
    wrong = one_camera_off(clicks, "cam0", (32.0, 24.0))
    accepted = [replace(one, frame=one.frame + 10, origin=ACCEPTED) for one in clicks] * 4
    found = doubtful_camera([*wrong, *accepted], cameras, NINE)
    assert found is not None
    assert (found.camera, found.count) == ("cam0", 27)
