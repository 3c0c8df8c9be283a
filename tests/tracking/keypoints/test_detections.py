"""Detections as measurements, one at a time."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.skeleton import LEFT_FOREARM, RIGHT_FOREARM
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.residuals.detections import DetectionObservation, corrected_by
from stereotrack_core.tracking.state import Belief, Setup
from tests.tracking.keypoints.cases import BENT_CAMERA, BODY, PLAIN_CAMERA, seen
from tests.tracking.running import Stepping
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, disturbed, surface_points

N = 6 + 2 * len(ALL_JOINTS)
P0 = np.diag(np.r_[np.full(3, 0.03), np.full(3, 0.1), np.full(N - 6, 0.25)] ** 2)


def setup_of(gate):
    return Setup(BODY, preset("accurate").replaced(detection_gate=gate).tracking, CAMERAS, 10.0, 0)


def _hand(pose, name):
    return landmarks(BODY, pose)[LANDMARKS.index(name)]


@pytest.mark.parametrize("camera", [None, PLAIN_CAMERA, BENT_CAMERA])
@pytest.mark.parametrize("kind", ["right_hand", "hand"])
def test_a_detection_pulls_its_hand_and_leaves_the_other(camera, kind, rng):
    truth = POSES["pointing"]
    sigma = 0.01 if camera is None else 1.0
    before = disturbed(truth, (3, 5), rng, position=1e-9, torso=1e-9, limbs=15.0)
    detection = seen("right_hand", truth, kind=kind, camera=camera, sigma=sigma)
    found = corrected_by(detection, setup_of(0.6), Belief(before, P0))
    after, P = found.pose, found.P

    def off(pose):
        place = _hand(pose, "right_hand")
        return np.linalg.norm(
            (place if camera is None else camera.project(place)) - detection.position
        )

    assert off(after) < 0.35 * off(before)
    moved = np.linalg.norm(_hand(after, "left_hand") - _hand(before, "left_hand"))
    assert moved < 0.25 * np.linalg.norm(_hand(after, "right_hand") - _hand(before, "right_hand"))
    assert np.trace(P) < np.trace(P0)
    assert np.linalg.eigvalsh(P).min() > 0


def test_the_order_makes_no_difference(rng):
    truth = POSES["reaching"]
    start = disturbed(truth, ALL_JOINTS, rng, position=0.02, torso=3.0, limbs=6.0)
    detections = [seen(name, truth, sigma=0.04) for name in ("head", "left_hand", "right_hand")]
    found = []
    for order in itertools.permutations(detections):
        belief = Belief(start, P0)
        for detection in order:
            belief = corrected_by(detection, setup_of(0.6), belief)
        found.append((landmarks(BODY, belief.pose), belief.P))
    gained = np.linalg.norm(found[0][0] - landmarks(BODY, start), axis=1).max()
    for points, P in found[1:]:
        apart = np.linalg.norm(points - found[0][0], axis=1).max()
        assert apart < 0.003 < 0.1 * gained
        np.testing.assert_allclose(P, found[0][1], atol=0.05 * np.abs(found[0][1]).max())


def test_detections_between_frames_bring_a_fast_arm_along(rng):
    """The arm turns by 80 degrees at once: too far for following, and the search is off."""
    turn = np.eye(N)[list(ALL_JOINTS).index(3) * 2 + 6]
    half, fast = (displaced(POSES["t"], angle * turn, ALL_JOINTS) for angle in (0.7, 1.4))
    cloud = cloud_of(surface_points(BODY, fast, 900, rng, 0.01), 1)
    seen_of = [
        seen("right_hand", pose, time=time, sigma=0.02) for pose, time in ((half, 0.5), (fast, 0.9))
    ]
    settings = preset("fast").replaced(search_arms=False, detection_gate=1.5).tracking
    setup, off = Setup(BODY, settings, CAMERAS, 10.0, 0), []
    for detections in ((), tuple(seen_of)):
        tracker = Stepping(Follower(setup, uses_async_detections=True))
        tracker.start(POSES["t"], P=setup.first_state(POSES["t"]).P * 0.2)
        estimate = tracker.step(replace(cloud, detections=detections))
        off.append(np.linalg.norm(_hand(estimate.pose, "right_hand") - _hand(fast, "right_hand")))
    assert off[1] < 0.06
    assert off[1] < off[0]


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


def test_detections_come_in_the_order_of_their_times():
    pose = POSES["t"]
    all_of_them = Detections(seen("head", pose, time=t) for t in (3.0, 0.5, 1.0, 1.5, 2.0))
    assert len(all_of_them) == 5
    assert [d.time for d in all_of_them.until(1)] == [0.5, 1.0]
    assert [d.time for d in all_of_them.until(2)] == [1.5, 2.0]
    assert Detections().until(0) == ()
