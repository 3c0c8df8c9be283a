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


def _column(low, high, count=500):
    return np.column_stack([np.zeros((count, 2)), np.linspace(low, high, count)])


@pytest.mark.parametrize(
    ("seen", "told"), [(1.17, False), (1.18, True), (2.25, True), (2.26, False)]
)
def test_heights_that_nobody_has_tell_nothing(seen, told):
    """A crown is seen at 98 of 100 parts of the height, which is 1.2 to 2.3 m."""
    points = _column(0.0, seen / 0.995)
    found = lengths_by_height([cloud_of(points)])
    assert (found != AVERAGE) == told
    assert not told or found.height == pytest.approx(seen / 0.98, rel=1e-3)


@pytest.mark.parametrize(
    ("low", "high", "stands"),
    [
        *[(low, 1.7, stands) for low, stands in ((-0.11, 0), (-0.09, 1), (0.29, 1), (0.31, 0))],
        *[(0.0, high, stands) for high, stands in ((1.39, 0), (1.41, 1), (2.24, 1), (2.32, 0))],
    ],
)
def test_who_stands_has_feet_on_the_floor_and_a_crown_of_a_person(low, high, stands):
    span = (high - low) / 0.985  # from the 1st to the 99.5th percentile
    points = _column(low - 0.01 * span, low + 0.99 * span)
    found = lengths_of_standing([cloud_of(points)])
    assert bool(found) == bool(stands)


@pytest.mark.parametrize("aside", [0.29, 0.31])
def test_the_head_is_in_the_middle_or_where_most_points_are(aside):
    points = np.concatenate([_column(0.0, 1.6), _column(1.6, 2.0, 100) + [aside, 0.0, 0.0]])
    found = lengths_by_height([cloud_of(points)])
    high = np.percentile(points[: 600 if aside < 0.3 else 500, 2], 99.5)
    assert found.height == pytest.approx(high / 0.98, rel=1e-6)
    people = ((-5.0, 1.5), (5.0, 1.7), (9.0, 1.9), (-9.0, 2.1), (5.01, 1.7), (-15.0, 1.9))
    apart = [_column(0.0, height, 200) + [x, 0.0, 0.0] for x, height in people]
    few = lengths_by_height([cloud_of(np.concatenate(apart))])
    assert few.height == pytest.approx(1.7 * 0.995 / 0.98, rel=2e-3)


def test_well_seen_frames_are_the_best_explained_and_those_with_bent_elbows():
    down, bends = [0.0, 0.0, -1.0], np.radians([49.0, 51.0])
    straight, bent = (pose_with_arms(down, [np.sin(a), 0, -np.cos(a)], down, down) for a in bends)
    frames = WellSeenFrames()
    said = []
    for k in range(60):
        lost, share = (0.19 if k % 5 else 0.21), k / 60.0
        pairs = SimpleNamespace(data=np.full((1, 3), float(k)))
        told = {"limb_lost": np.full(6, lost), "unexplained_fraction": share}
        pose = bent if k % 3 == 0 else straight
        estimate = SimpleNamespace(correspondences=pairs, **told)
        frames.add(SimpleNamespace(pose=pose, estimate=estimate))
        said.append((k, lost, share))
    most = np.quantile([share for *_, share in said], 0.7)
    good = [k for k, lost, share in said if lost < 0.2 and share <= most]
    elbows = [k for k in good if k % 3 == 0]
    others = [k for k in good if k % 3]
    spread = [others[round(i)] for i in np.linspace(0, len(others) - 1, 4)]
    assert [int(one.data[0, 0]) for one in frames.picked()] == [*elbows, *spread]
