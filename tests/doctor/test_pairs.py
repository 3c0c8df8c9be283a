"""Details that both images of a pair show tell what is wrong about its calibration."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.doctor.pairs import Details, check_pair, details_of, row_fit
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.camera_checks import transposed
from tests.depth.scenes import camera, pair_with_disparity

SIZE = {"size": (640, 480), "principal": (315.0, 243.0), "focal": (500.0, 500.0)}


@pytest.fixture(scope="module")
def pair():
    """Two cameras 12 cm apart that look along y, a little turned, through bent lenses."""
    bent = {"distortions": (-0.1, 0.02, 0.0, 0.0), **SIZE}
    left = camera("left", (-0.06, 0.2, 1.0), (0.05, 0.02, 0.01), **bent)
    return left, camera("right", (0.06, 0.2, 1.0), (0.05, -0.02, 0.0), **bent)


@pytest.fixture(scope="module")
def details(pair):
    return seen_by(pair, 1)


def seen_by(pair, seed):
    """Details of things in the room, with noise of 0.2 px."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([-1.2, 2.0, 0.2], [1.2, 4.5, 2.0], (400, 3))
    left, image = (one.project(points) + rng.normal(0, 0.2, (400, 2)) for one in pair)
    inside = np.isfinite(left + image).all(axis=1)
    return Details(left[inside], image[inside], 400)


def found(cameras, details):
    return list(check_pair("N", cameras, details))


def turned(one, degrees):
    old, turn = one.camera_from_world, rotation_from_vector(np.radians([degrees, 0.0, 0.0]))
    moved = RigidTransform(turn @ old.rotation, turn @ old.translation)
    return dataclasses.replace(one, camera_from_world=moved)


def test_a_sound_pair_has_no_findings(pair, details):
    assert not found(pair, details)
    assert row_fit(pair, details).row_px < 0.4
    assert row_fit(pair, details).wrong_side == 0.0


def test_rows_that_differ_a_little_are_a_note(pair, details):
    [note] = found(pair, dataclasses.replace(details, left=details.left + [0.0, 0.7]))
    assert note.severity == "note"
    assert "align_rows" in note.remedy


def test_exchanged_images_are_named(pair, details):
    [finding] = found(pair, details.exchanged)
    assert finding.severity == "error"
    assert finding.where == "view N"
    assert "wrong side" in finding.what
    assert "are exchanged" in finding.remedy


@pytest.mark.parametrize(
    ("slip", "remedy"),
    [
        (transposed, "Transpose the rotation of right"),
        (lambda one: turned(one, 3.0), "One camera is turned by 3.0 degrees"),
    ],
)
def test_a_slip_in_one_camera_is_named_with_a_tested_correction(pair, details, slip, remedy):
    [finding] = found((pair[0], slip(pair[1])), details)
    assert finding.severity == "error"
    assert remedy in finding.remedy
    assert "tested" in finding.remedy


def test_a_small_error_is_not_taken_for_a_slip_that_helps_by_chance(pair, details):
    [finding] = found((pair[0], turned(pair[1], 0.2)), details)
    assert "One camera is turned by 0.2 degrees" in finding.remedy


def test_details_of_a_rendered_pair_have_its_disparity():
    left, image = pair_with_disparity(np.full((240, 320), 12.0))
    details = details_of([(left, image)])
    assert len(details.left) > 100
    apart = np.median(details.left - details.image, axis=0)
    assert apart == pytest.approx([12.0, 0.0], abs=0.1)
    mirrored = details_of([(np.ascontiguousarray(left[:, ::-1]), image)])
    assert len(mirrored.left) < 0.04 * mirrored.seen
