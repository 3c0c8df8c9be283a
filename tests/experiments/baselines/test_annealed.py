"""Drawing, annealing and the measure of particles."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.experiments.baselines.particles import (
    PoseEnergy,
    exponent,
    limbs_exchanged,
    normalised,
    survival,
    systematic,
)
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.residuals.limits import limit_residuals
from stereotrack_core.tracking.residuals.surface import Trust, surface_residual
from tests.experiments.baselines.test_baselines import make
from tests.tracking.scenes import POSES, cloud_of, pose_with_arms, surface_points

ENERGIES = arrays(
    np.float64, st.integers(5, 60), elements=st.integers(0, 10_000).map(float), unique=True
)


@given(ENERGIES, st.floats(0.3, 0.9))
def test_the_wanted_share_survives(E, wanted):
    assert survival(E, exponent(E, wanted)) == pytest.approx(wanted, abs=1e-3)


def test_particles_that_agree_all_survive():
    assert exponent(np.full(10, 3.0), 0.5) == 0.0
    np.testing.assert_allclose(normalised(np.full(10, 3.0), 0.0), 0.1)


@given(ENERGIES, st.floats(0.0, 0.999999))
def test_particles_are_drawn_as_often_as_their_weights_say(E, offset):
    weights = normalised(E, 1.0 / np.ptp(E))
    drawn = np.bincount(systematic(weights, offset), minlength=len(E))
    assert drawn.sum() == len(E)
    assert np.abs(drawn - len(E) * weights).max() < 1.0 + 1e-9


def test_limbs_are_exchanged_whole():
    rng = np.random.default_rng(0)
    particles = np.repeat(np.arange(20.0)[:, None], 6, axis=1)
    mixed = limbs_exchanged(particles, [np.array([2, 3]), np.array([4, 5])], rng)
    np.testing.assert_array_equal(mixed[:, :2], particles[:, :2])
    for columns in ([2, 3], [4, 5]):
        np.testing.assert_array_equal(mixed[:, columns[0]], mixed[:, columns[1]])
        np.testing.assert_array_equal(np.sort(mixed[:, columns[0]]), np.arange(20.0))
    assert (mixed[:, 2] != mixed[:, 4]).any()


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
    frames = body.frames(pose[None])
    for row in limit_residuals(body, pose, p, ALL_JOINTS):
        total += 0.5 * np.sum((row.measured - row.predicted(frames)[0]) ** 2 / row.variance)
    return total


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


def test_the_energy_rises_where_limits_are_violated(scene):
    energy = scene[2]
    nowhere = np.full((1, 3), 50.0)
    free = energy.of(nowhere, POSES["t"], np.zeros((1, 6 + 2 * len(ALL_JOINTS))))[0]
    folded = pose_with_arms([1, 0.2, 0], [-1, 0.1, 0.02], [-1, 0, 0], [-1, 0.1, 0])
    costly = energy.of(nowhere, folded, np.zeros((1, 6 + 2 * len(ALL_JOINTS))))[0]
    assert costly > free + 5.0


def test_particles_are_drawn_anew_where_the_body_was_found_elsewhere():
    rng = np.random.default_rng(7)
    tracker = make("annealed")
    tracker.start(POSES["t"])
    clouds = [
        cloud_of(surface_points(tracker.setup.body, POSES["t"], 1500, rng), k) for k in range(3)
    ]
    tracker.step(clouds[0])
    elsewhere = POSES["t"].position + np.array([0.9, 0.4, 0.0])
    state = tracker.leader.state
    tracker.leader.state = replace(state, pose=Pose(elsewhere, state.pose.rotations))
    tracker.step(cloud_of(clouds[1].points + elsewhere - POSES["t"].position, 1))
    assert np.linalg.norm(tracker.pose.position - elsewhere) < 0.1
