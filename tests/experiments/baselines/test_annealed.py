"""Drawing, annealing and the measure of particles."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.experiments.baselines.particles import (
    PoseEnergy,
)
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.residuals.surface import Trust, surface_residual
from tests.experiments.baselines.test_baselines import make
from tests.tracking.scenes import POSES, cloud_of, pose_with_arms, surface_points


@pytest.fixture(scope="module")
def scene():
    settings = preset("annealed")
    body = body_model(AVERAGE, settings.body)
    return body, settings.tracking, PoseEnergy(body, settings.tracking, ALL_JOINTS)


def expected_energy(body, p, data, pose):
    """The same from the tracker's own residuals."""
    trust = Trust(
        p.max_correspondence_distance,
        2.0 * p.loss_scale,
        p.sigma_measurement,
        p.effective_sample_size,
    )
    surface = surface_residual(data, body, body.frames(pose), trust)
    e = np.append(
        surface.distance, np.full(len(data) - len(surface.distance), p.max_correspondence_distance)
    )
    squared, crowd = (2.0 * p.loss_scale) ** 2, max(1.0, len(data) / p.effective_sample_size)
    total = np.sum(0.5 * squared * e**2 / (squared + e**2)) / (p.sigma_measurement**2 * crowd)
    rows = limit_rows(body, pose, p, ALL_JOINTS)
    return total + 0.5 * np.sum(rows["innovation"] ** 2 / rows["variance"])


def test_the_energy_is_that_of_the_trackers_residuals(scene):
    body, p, energy = scene
    rng = np.random.default_rng(1)
    data = surface_points(body, POSES["reaching"], 250, rng, 0.02)
    folded = pose_with_arms([1, 0.2, 0], [-1, 0.4, 0.1], [-0.05, 0.02, -1], [0.3, 0.05, -1])
    for centre in (POSES["reaching"], folded):
        deltas = 0.1 * rng.normal(size=(12, 6 + 2 * len(ALL_JOINTS)))
        found = energy.of(data, centre, deltas)
        for k, delta in enumerate(deltas):
            pose = displaced(centre, delta, ALL_JOINTS)
            assert found[k] == pytest.approx(expected_energy(body, p, data, pose), rel=1e-9)


def test_particles_are_drawn_anew_where_the_body_was_found_elsewhere():
    rng = np.random.default_rng(7)
    tracker = make("annealed")
    tracker.start(POSES["t"])
    clouds = [
        cloud_of(surface_points(tracker.setup.body, POSES["t"], 1500, rng), k) for k in range(3)
    ]
    tracker.step(clouds[0])
    elsewhere = POSES["t"].position + np.array([0.9, 0.4, 0.0])
    leader = tracker.state.leader
    leader = replace(leader, pose=Pose(elsewhere, leader.pose.rotations))
    tracker.state = replace(tracker.state, leader=leader)
    tracker.step(cloud_of(clouds[1].points + elsewhere - POSES["t"].position, 1))
    assert np.linalg.norm(tracker.pose.position - elsewhere) < 0.1
