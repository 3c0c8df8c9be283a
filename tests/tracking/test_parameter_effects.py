"""What the parameters of the tracker change about its estimates."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.model import landmarks
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.residuals.detections import DetectionResidual, corrected_by
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.step import PersonModel
from stereotrack_core.tracking.view_watch import ViewWatch
from tests.effects import check
from tests.tracking.keypoints.cases import BODY, seen
from tests.tracking.keypoints.test_reprojection import seen as keypoints
from tests.tracking.running import tracker_of
from tests.tracking.scenes import POSES, angle_errors, cloud_of, disturbed, pose_with_arms
from tests.tracking.scenes import surface_points as on_surface
from tests.tracking.views import cloud_of_body

TRUE, ARMS, N, RNG = POSES["t"], POSES["pointing"], 6 + 2 * len(ALL_JOINTS), np.random.default_rng
POINTS = on_surface(BODY, TRUE, 2400, RNG(12), 0.005)
CLOUD = cloud_of(POINTS, 1)
AROUND = np.concatenate([POINTS, TRUE.position + RNG(1).uniform(-1.0, 1.0, (20000, 3))])


def started(pose=TRUE, P=None, **changes):
    tracker = tracker_of("manifold", **changes)
    tracker.start(pose, 0.0, P=P)
    return tracker


def step(points=POINTS, pose=TRUE, P=None, **changes):
    return started(pose, P, **changes).step(cloud_of(points, 1))


def growth(index, **changes):
    """Standard deviation that a frame without data adds, at 40 Hz half of that at 10 Hz."""
    found = step(POINTS[:1], P=np.eye(N), fps=40.0, **changes)
    return 2.0 * np.sqrt(found.P[index, index] - 1.0)


def spread(**changes):
    """Standard deviation of the position after a frame, nearly all by its data."""
    return np.sqrt(np.trace(step(**changes).P[:3, :3]))


def pairs(**changes):
    tracker = started(**{"data_points": 20000} | changes)
    found = tracker.model.measured(tracker.state, cloud_of(AROUND, 1))
    return found.surface(TRUE, wide=False)


def distance_at_a_quarter(**changes):
    found = pairs(**changes)
    return np.abs(found.distance)[np.argmin(np.abs(found.weight - 0.25))]


RATIO = 5.0 / np.sqrt(3.0)  # root mean square over three axes of 5 cm along one, for 1 cm


def inflation(**changes):
    sure = {"sigma_position": 0.01, "sigma_measurement": 0.005, "effective_sample_size": 2000.0}
    found = step(POINTS + [0.05, 0.0, 0.0], P=1e-8 * np.eye(N), **sure, **changes)
    return np.sqrt(found.prior.P[0, 0]) / 0.01


def tracked_shares_of_stray_points(**changes):
    stray = [np.arange(400) < 4 * share for share in (25, 35, 45, 55, 65, 75)]
    clouds = [POINTS[:400] + 4.0 * one[:, None] * [0.0, 0.0, 1.0] for one in stray]
    return sum(step(points, **changes).tracked for points in clouds)


@functools.cache
def scene():
    return replace(cloud_of_body(BODY, ARMS), frame=1, keypoints=keypoints(ARMS))


def beside(parts, **changes):
    """Residuals of what a cloud with other parts holds beside its points."""
    tracker = started(**changes)
    return tracker.model.measured(tracker.state, replace(scene(), **parts)).beside(ARMS)


def spread_by(parts, **changes):
    columns = started(**changes).setup.columns
    frames = BODY.frames(ARMS)
    rows = [each.rows(frames) for each in beside(parts, **changes)]
    return gathered(rows, frames, columns).A[0, 0] ** -0.5


OFF = [seen("right_hand", ARMS, time=1, off=np.array([k / 10 - 0.05, 0, 0])) for k in range(1, 8)]


def used_at_once(**changes):
    found = [beside({"detections": (one,)}, **changes) for one in OFF]
    return sum(any(isinstance(each, DetectionResidual) for each in rows) for rows in found)


def used_between(**changes):
    belief, setup = Belief(ARMS, np.eye(N)), started(**changes).setup
    return sum(corrected_by(one, setup, belief) is not belief for one in OFF)


WRONG = pose_with_arms([0.1, 0.2, -1], [0.1, 0.4, -1], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1])


def searching(**changes):
    search = started(**changes).model.search
    evidence = search.evidence(scene(), ARMS, RNG(0))
    return search, evidence, search.best_pairs(evidence, WRONG, WRONG, RNG(0))


def excess(**changes):
    """Cost of a wrong right arm beyond that of the right one."""
    search, evidence, _ = searching(**changes)
    true, wrong = (search.cost(evidence, WRONG, pose) for pose in (ARMS, WRONG))
    return wrong - true


def refined(**changes):
    """Degrees by which a pair is off after refining, from 25 degrees off."""
    tracker = started(**changes)
    frame = tracker.model.measured(tracker.state, CLOUD)
    start = disturbed(TRUE, (2, 3, 4, 5), RNG(3), 1e-9, 1e-9, 25.0)
    found = tracker.model.refine(frame, start, tracker.P)
    return angle_errors(BODY, found.pose, TRUE)[2:].mean()


def hand_moved(**changes):
    """Metres that a hand on the trunk is moved by a correction without data."""
    near = pose_with_arms([0.3, 0.3, -1], [-0.6, 0.1, -0.3], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1])
    tracker, prior = started(near, **changes), Belief(near, np.eye(N))
    frame = tracker.model.measured(tracker.state, cloud_of(POINTS[:0], 1))
    after = frame.corrected(prior, prior, frame.surface(near, wide=False))
    return np.linalg.norm(landmarks(BODY, after.pose) - landmarks(BODY, near), axis=1).max()


def wrong_points(**changes):
    """How many points of a view that contradicts the others are compared with the body."""
    setup, names, view = started(**changes).setup, tuple("NESW"), np.arange(len(POINTS)) % 4
    model = PersonModel(Follower(setup))
    state = replace(model.first(TRUE, 90.0), watch=ViewWatch(names, np.ones((4, 2)), 9, "W"))
    _, found = model.step(state, replace(cloud_of(POINTS, 91), view=view, view_names=names))
    return np.isin(found.correspondences.data[:, 0], POINTS[3::4, 0]).sum()


EDGES, DOTS = {"keypoints": None}, {"depths": {}}
EFFECTS = [
    ("sigma_position", 0.03, 0.1, lambda **p: growth(0, **p), "slope", 1.0, 1e-6),
    ("sigma_rotation", 5.0, 20.0, lambda **p: growth(3, **p), "slope", np.radians(1.0), 1e-6),
    ("sigma_joint", 10.0, 40.0, lambda **p: growth(6, **p), "slope", np.radians(1.0), 1e-6),
    ("sigma_measurement", 0.02, 0.04, spread, "ratio", 2.0, 0.1),
    ("effective_sample_size", 100.0, 400.0, spread, "ratio", 0.5, 0.04),
    ("data_points", 200, 800, spread, "ratio", 1.0, 0.07),
    ("data_points", 200, 800, lambda **p: len(pairs(**p).data), "ratio", 4.0, 1.0),
    ("max_correspondence_distance", 0.1, 0.3,
     lambda **p: pairs(**p).distance.max(), "slope", 1.0, 0.02),
    ("loss_scale", 0.04, 0.12, distance_at_a_quarter, "slope", 1.0, 0.02),
    ("prior_inflation_above", 0.9 * RATIO, 1.1 * RATIO, inflation, "ratio", 1 / RATIO, 0.02),
    ("max_unexplained_fraction", 0.3, 0.7, tracked_shares_of_stray_points, "difference", 4, 0),
    ("clearance", 0.0, 0.05, hand_moved, "slope", 1.5, 0.5),
    ("measure_silhouettes", True, False, lambda **p: len(beside(EDGES, **p)), "ratio", 0, 0),
    ("silhouette_sigma", 0.02, 0.04, lambda **p: spread_by(EDGES, **p), "ratio", 2, 0.01),
    ("keypoint_sigma", 0.2, 0.4, lambda **p: spread_by(DOTS, **p), "ratio", 2.0, 0.1),
    ("detection_gate", 0.2, 0.5, used_at_once, "difference", 3, 0),
    ("detection_gate", 0.2, 0.5, used_between, "difference", 3, 0),
    ("leave_out_views", False, True, wrong_points, "ratio", 0, 0),
    ("search_proposals", 120, 240, lambda **p: len(  # seven twelfths, if data are explained
        started(search_arms=True, **p).explain(CLOUD).search.proposals[0].upper),
     "difference", 70, 0),
    ("search_refined", 2, 5, lambda **p: len(searching(**p)[2]), "difference", 3, 0),
    ("search_iterations", 1, 6, refined, "ratio", 0.25, 0.25),
    ("picture_cost", 0.0, 1000.0, excess, "slope", 0.25, 0.15),
    ("keypoint_cost", 0.0, 10.0, excess, "slope", 5.0, 2.2),
]  # fmt: skip


@pytest.mark.parametrize("row", EFFECTS, ids=lambda row: row[0])
def test_a_parameter_changes_the_estimate_as_it_says(row):
    check(*row)
