"""Detections as measurements."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of, displaced
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import HEAD, LEFT_FOREARM, RIGHT_FOREARM
from stereotrack_core.recording.detections import Detections
from stereotrack_core.tracking.residuals.detections import DetectionObservation
from tests.tracking.keypoints.cases import BENT_CAMERA, BODY, PLAIN_CAMERA, seen
from tests.tracking.scenes import POSES, disturbed

STEP = 1e-6


def _stacked(pose):
    frames = BODY.frames(pose)
    return PartFrames(frames.rotations[None], frames.origins[None])


@given(st.integers(0, 10_000), st.sampled_from([None, PLAIN_CAMERA, BENT_CAMERA]))
def test_derivatives_agree_with_differences(seed, camera):
    rng = np.random.default_rng(seed)
    pose = disturbed(POSES["pointing"], ALL_JOINTS, rng)
    columns = columns_of(ALL_JOINTS)
    for name in ("head", "left_hand", "right_hand"):
        detection = seen(name, POSES["pointing"], camera=camera, sigma=0.1 if camera is None else 9)
        (row,) = DetectionObservation((detection,), 2.0).residuals(BODY, pose)
        steps = STEP * np.concatenate([np.eye(columns.n), -np.eye(columns.n)])
        moved = row.predicted(BODY.frames(displaced(pose, steps, ALL_JOINTS)))
        numerical = (moved[: columns.n] - moved[columns.n :]).T / (2 * STEP)
        np.testing.assert_allclose(
            row.jacobian(BODY.frames(pose), columns), numerical, rtol=1e-5, atol=1e-5
        )


@pytest.mark.parametrize("camera", [None, PLAIN_CAMERA, BENT_CAMERA])
def test_a_true_detection_agrees_with_the_pose(camera):
    for name, part in (("head", HEAD), ("left_hand", LEFT_FOREARM), ("right_hand", RIGHT_FOREARM)):
        detection = seen(name, POSES["t"], camera=camera, sigma=2.0)
        (row,) = DetectionObservation((detection,), 0.3).residuals(BODY, POSES["t"])
        assert row.part == part
        np.testing.assert_allclose(row.predicted(_stacked(POSES["t"]))[0], row.measured, atol=1e-6)


def test_hands_without_a_side_go_where_they_fit_and_are_two_hands():
    pose = POSES["t"]
    left = seen("left_hand", pose, kind="hand", off=0.05)
    right = seen("right_hand", pose, kind="hand", off=-0.05)
    rows = DetectionObservation((right, left), 0.3).residuals(BODY, pose)
    assert [row.part for row in rows] == [RIGHT_FOREARM, LEFT_FOREARM]
    again = seen("left_hand", pose, kind="hand", off=0.02)
    rows = DetectionObservation((left, again), 0.3).residuals(BODY, pose)
    assert [row.part for row in rows] == [LEFT_FOREARM]
    np.testing.assert_array_equal(rows[0].measured, again.position)


def test_cameras_speak_independently():
    pose = POSES["t"]
    both = (
        seen("left_hand", pose, kind="hand", camera=PLAIN_CAMERA, sigma=2.0),
        seen("left_hand", pose, kind="hand", camera=BENT_CAMERA, sigma=2.0),
    )
    assert [r.part for r in DetectionObservation(both, 0.3).residuals(BODY, pose)] == [
        LEFT_FOREARM
    ] * 2


def test_what_is_beyond_the_gate_belongs_to_none():
    pose = POSES["t"]
    far = seen("left_hand", pose, kind="hand", off=np.array([0.0, 0.0, 0.31]))
    assert DetectionObservation((far,), 0.3).residuals(BODY, pose) == ()
    assert len(DetectionObservation((far,), 0.32).residuals(BODY, pose)) == 1
    in_picture = seen("left_hand", pose, kind="hand", camera=PLAIN_CAMERA, sigma=2.0, off=25.0)
    assert DetectionObservation((in_picture,), 0.3).residuals(BODY, pose) == ()


def test_far_and_doubtful_detections_weigh_less():
    pose = POSES["t"]
    variances = [
        DetectionObservation((seen("head", pose, **how),), 1.0).residuals(BODY, pose)[0].variance[0]
        for how in ({}, {"confidence": 0.5}, {"off": 0.03}, {"off": 0.15})
    ]
    assert variances[0] == pytest.approx(0.03**2)
    assert variances[1] == pytest.approx(2 * 0.03**2)
    assert 1.0 < variances[2] / variances[0] < 4.0 < variances[3] / variances[0]


def test_detections_come_in_the_order_of_their_times():
    pose = POSES["t"]
    all_of_them = Detections(seen("head", pose, time=t) for t in (3.0, 0.5, 1.0, 1.5, 2.0))
    assert len(all_of_them) == 5
    assert [d.time for d in all_of_them.until(1)] == [0.5, 1.0]
    assert [d.time for d in all_of_them.until(2)] == [1.5, 2.0]
    assert Detections().until(0) == ()
