"""Lengths of the body out of the frames of a sequence."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.tracking.lengths_fit import (
    WellSeenFrames,
    lengths_by_height,
    lengths_of_standing,
)
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shape_fit import LENGTH_SIGMAS, FreeBody, SeenPose, adjusted
from tests.tracking.recordings import SMALL, write_depth_recording
from tests.tracking.scenes import cloud_of, disturbed, pose_with_arms, surface_points

TALL = Proportions(0.41, 0.24, 0.51, 0.315, 0.275, 0.205, 0.225)
ARMS = ("shoulder_width", "upper_arm_length", "forearm_length")


def poses(count):
    """Arms that bend more and more, so that elbows show themselves."""
    return [
        pose_with_arms(
            [1, 0.2 * k, 0.1 * k],
            [1 - 0.3 * k, 0.4 * k, 0.5],
            [-1, 0.2 * k, -0.1 * k],
            [-1 + 0.3 * k, 0.5 * k, 0.3],
            place=(0.0, 0.0, 1.0),
        )
        for k in range(count)
    ]


def off(found, true):
    return {name: getattr(found, name) - getattr(true, name) for name in ARMS}


def test_lengths_of_a_tall_person_come_out_of_their_surface(rng):
    body = body_model(TALL, BodyParameters())
    seen = [
        SeenPose(
            surface_points(body, pose, 700, rng, noise=0.005),
            disturbed(pose, ALL_JOINTS, rng, 0.02, 2.0, 4.0),
        )
        for pose in poses(8)
    ]
    free = FreeBody(AVERAGE, body.shape, lengths=tuple(LENGTH_SIGMAS))
    theta, _ = adjusted(free, seen, TrackingParameters(), ALL_JOINTS)
    before, after = off(AVERAGE, TALL), off(free.parts(theta)[0], TALL)
    for name in ARMS:
        assert abs(after[name]) < 0.4 * abs(before[name]), (name, before[name], after[name])


def test_lengths_of_people_differ_by_some_eight_percent_and_by_less_at_one_height():
    free = FreeBody(AVERAGE, BodyParameters(), lengths=tuple(LENGTH_SIGMAS), surface=())
    sigmas = np.diag(np.linalg.inv(free.information)) ** 0.5
    alike = np.diag(free.information) ** -0.5
    assert ((sigmas > 0.07) & (sigmas < 0.095)).all(), sigmas
    assert (alike < 0.9 * sigmas).all(), alike


@pytest.mark.parametrize("count", [30, 1000])
def test_lengths_are_told_by_frames_from_all_over_the_sequence(count):
    bent, frames = poses(4)[3], WellSeenFrames()
    for k in range(count):
        pairs = SimpleNamespace(data=np.full((1, 3), float(k)))
        said = {"limb_lost": np.zeros(6), "unexplained_fraction": 0.0, "correspondences": pairs}
        frames.add(SimpleNamespace(pose=bent, estimate=SimpleNamespace(**said)))
    picked = sorted(seen.data[0, 0] for seen in frames.picked())
    assert len(picked) == 20
    assert np.diff([-1.0, *picked, count]).max() <= 0.1 * count


@pytest.mark.parametrize(("crown", "ratio"), [(1.715, 1.0), (1.9, 1.9 / 1.715)])
def test_the_height_moves_all_lengths_alike(crown, ratio):
    column = np.column_stack([np.zeros((500, 2)), np.linspace(0.0, crown, 500)])
    lengths = dataclasses.asdict(lengths_by_height([cloud_of(column)]))
    for name, length in dataclasses.asdict(AVERAGE).items():
        assert lengths[name] == pytest.approx(ratio * length, rel=0.01)


@pytest.mark.parametrize(
    ("low", "high", "stands"),
    [
        pytest.param(0.1, 1.52, True, id="stands"),
        pytest.param(0.1, 1.2, False, id="sits, or is a child"),
        pytest.param(0.8, 1.7, False, id="no legs are seen"),
        pytest.param(-0.4, 1.5, False, id="the origin is over the floor"),
    ],
)
def test_only_who_is_seen_to_stand_tells_how_tall_he_is(low, high, stands):
    cloud = cloud_of(np.column_stack([np.zeros((500, 2)), np.linspace(low, high, 500)]))
    found = lengths_of_standing([cloud] * 3)
    assert found == (lengths_by_height([cloud]) if stands else None)
    if found is not None:
        assert found.height == pytest.approx(high / 0.98, abs=0.02)
    assert lengths_of_standing([]) is None


@pytest.mark.slow
def test_a_recording_without_a_subject_is_tracked_with_its_own_lengths(tmp_path):
    settings = SMALL
    body = body_model(TALL, settings.body)
    recording = write_depth_recording(tmp_path / "tall", body, poses(10))
    unknown = dataclasses.replace(recording, subject=None)
    start = poses(1)[0]
    errors = {}
    for choice in ("average", "individual", "sequence"):
        run = track(unknown, RunSpec(settings.replaced(proportions=choice), init=start, seed=1))
        distances = np.linalg.norm(run.landmarks - recording.reference.points, axis=-1)
        errors[choice] = float(np.nanmean(distances))
    assert errors["sequence"] < 0.7 * errors["average"], errors
    assert errors["individual"] < 0.8 * errors["average"], errors
    assert run.meta["subject"]["name"] == "estimated from the sequence"
    again = track(unknown, RunSpec(settings.replaced(proportions="sequence"), init=start, seed=1))
    np.testing.assert_array_equal(run.landmarks, again.landmarks)
