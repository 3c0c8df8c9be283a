"""The backward pass on a moving body whose pose is known."""

import dataclasses
import itertools

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.model import landmarks
from stereotrack_core.filtering.smoothing import backward_step
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.frame import TrackedFrame, cloudless
from stereotrack_core.tracking.smoothing import smoothed
from stereotrack_core.tracking.state import prior_inflation
from tests.tracking.scenes import POSES, angle_errors, cloud_of, pose_with_arms, surface_points

BOTH = pytest.mark.parametrize("name", ["thesis", "manifold"])
FRAMES = 14


def _pose(k):
    bend = 0.5 * np.sin(0.25 * k)
    return pose_with_arms(
        [1, 0.6 * bend, -0.3 * bend],
        [1, 1.2 * bend, 0.1],
        [-1, 0.5 * bend, 0.4 * bend],
        [-1, bend, 0.1],
        place=(0.05 + 0.01 * k, -0.1, 0.95),
    )


def _followed(tracker, rng, missing=(), frames=FRAMES, points=350, noise=0.03):
    """Frames of a body that moves, seen by few and noisy points."""
    tracker.start(_pose(0))
    found = []
    for k in range(frames):
        seen = surface_points(tracker.setup.body, _pose(k), points, rng, noise)
        cloud = cloud_of(seen[:0] if k in missing else seen, k)
        estimate = tracker.step(cloud)
        places = landmarks(tracker.setup.body, estimate.pose)
        if not estimate.tracked:
            places = np.full_like(places, np.nan)
        frame = TrackedFrame(k, estimate, places, cloud, {"track": 0.01})
        found.append(frame.without_cloud())
    return found


def _back(tracker, frames, **changes):
    p = dataclasses.replace(tracker.setup.parameters, **changes)
    return smoothed(frames, dataclasses.replace(tracker.setup, parameters=p))


def _errors(tracker, frames):
    """Mean angle of the limbs in degrees and distance of the torso in metres."""
    poses = [(frame.pose, _pose(frame.frame)) for frame in frames if frame.tracked]
    angles = [angle_errors(tracker.setup.body, found, true) for found, true in poses]
    return np.mean(angles), np.mean([np.linalg.norm(a.position - b.position) for a, b in poses])


@pytest.mark.parametrize(
    ("name", "share"),  # the thesis's filter is far too certain to take much back
    [("thesis", (0.97, 1.0)), ("manifold", (0.9, 0.9))],
)
def test_smoothing_comes_closer_to_the_truth(make_tracker, name, share):
    before, after = [], []
    for seed in range(3):
        tracker = make_tracker(
            name, seed=seed, sigma_joint=10.0, effective_sample_size=60.0, sigma_measurement=0.02
        )
        frames = _followed(tracker, np.random.default_rng(seed))
        before.append(_errors(tracker, frames))
        after.append(_errors(tracker, _back(tracker, frames)))
    assert (np.mean(after, axis=0) < share * np.mean(before, axis=0)).all()


@BOTH
def test_smoothing_makes_nothing_less_certain(make_tracker, rng, name):
    tracker = make_tracker(name)
    frames = _followed(tracker, rng)
    back = _back(tracker, frames)
    for a, b in zip(frames, back, strict=True):
        np.testing.assert_array_equal(b.P, b.P.T)
        assert np.linalg.eigvalsh(b.P).min() > 0
        assert np.linalg.eigvalsh(a.P - b.P).min() > -1e-9
        assert (b.estimate.limb_sigma_deg <= a.estimate.limb_sigma_deg + 0.2).all()
    np.testing.assert_array_equal(back[-1].x, frames[-1].x)
    np.testing.assert_array_equal(back[-1].P, frames[-1].P)
    last, filtered = (one[-1].estimate.limb_sigma_deg for one in (back, frames))
    np.testing.assert_allclose(last, filtered, rtol=1e-6)
    assert np.trace(back[3].P) < np.trace(frames[3].P)


@BOTH
def test_a_short_gap_is_bridged_between_its_ends(make_tracker, rng, name):
    tracker, missing = make_tracker(name), {5, 6, 7}
    frames = _followed(tracker, rng, missing=missing, points=2500, noise=0.005)
    back = _back(tracker, frames, longest_bridge=0.3)
    assert all(frame.tracked and not frame.reason for frame in back)
    for k in missing:
        frame = back[k]
        unknown = ("unexplained_fraction", "residual", "innovation")
        assert np.isnan([getattr(frame.estimate, name) for name in unknown]).all()
        assert np.isfinite(frame.estimate.limb_sigma_deg).all()
        assert np.linalg.norm(frame.pose.position - _pose(k).position) < 0.04
        assert angle_errors(tracker.setup.body, frame.pose, _pose(k)).mean() < 6.0
    sigma = [np.trace(frame.P) for frame in back]
    assert sigma[6] > max(sigma[5], sigma[7]) > min(sigma[5], sigma[7]) > max(sigma[4], sigma[8])
    x = [frame.pose.position[0] for frame in back]
    assert x[4] < x[5] < x[6] < x[7] < x[8]


@BOTH
def test_over_a_long_gap_the_smoother_starts_anew(make_tracker, rng, name):
    tracker, missing = make_tracker(name), {5, 6, 7}
    frames = _followed(tracker, rng, missing=missing)
    back = _back(tracker, frames, longest_bridge=0.2)
    assert {frame.frame for frame in back if not frame.tracked} == missing
    for part in (slice(0, 5), slice(8, None)):
        alone = _back(tracker, frames[part])
        for a, b in zip(back[part], alone, strict=True):
            np.testing.assert_array_equal(a.x, b.x)
            np.testing.assert_array_equal(a.P, b.P)
    for k in missing:
        assert np.isnan(back[k].landmarks).all()


def test_the_search_says_that_an_arm_has_jumped(make_tracker, rng):
    lost = pose_with_arms([0.1, 0.1, -1], [0.1, 0.2, -1], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1])
    tracker = make_tracker("manifold", search_arms=True, sigma_measurement=0.02)
    tracker.start(lost)
    first = tracker.step(cloud_of(surface_points(tracker.setup.body, lost, 2500, rng, 0.005), 0))
    points = surface_points(tracker.setup.body, POSES["pointing"], 2500, rng, 0.005)
    found = tracker.step(cloud_of(points, 1))
    assert first.prior is None
    assert not found.prior.carried[6:14].any()
    assert found.prior.carried[:6].all()
    frames = [
        TrackedFrame(k, estimate, np.zeros((9, 3)), cloud_of(points, k), {})
        for k, estimate in enumerate((first, found))
    ]
    back = _back(tracker, frames)
    assert angle_errors(tracker.setup.body, back[0].pose, first.pose)[[3, 5]].max() < 1.0


def test_arms_that_were_looked_for_anew_pull_no_other_frame_away(make_tracker, rng):
    tracker = make_tracker("manifold")
    frames = _followed(tracker, rng)
    usual = smoothed(frames, tracker.setup, fit_movement=True)
    estimate, arms = frames[7].estimate, np.arange(len(frames[7].P)) >= 6
    narrow = np.where(arms, 0.1, 1.0)  # what was predicted is far off the arms that were found
    prior = Prior(estimate.prior.P * np.outer(narrow, narrow), ~arms)
    P = estimate.P + np.diag(np.where(arms, 0.3**2, 0.0))
    frames[7] = dataclasses.replace(
        frames[7], estimate=dataclasses.replace(estimate, P=P, prior=prior)
    )
    searched = smoothed(frames, tracker.setup, fit_movement=True)
    for a, b in zip(usual, searched, strict=True):
        assert np.linalg.norm(a.pose.position - b.pose.position) < 0.01
        assert angle_errors(tracker.setup.body, a.pose, b.pose).max() < 10.0


@pytest.mark.parametrize("fit_movement", [False, True])
def test_frames_of_which_none_is_tracked_stay_as_they_are(make_tracker, rng, fit_movement):
    tracker = make_tracker("manifold")
    frames = _followed(tracker, rng, missing={0, 1}, frames=2)
    back = smoothed(frames, tracker.setup, fit_movement=fit_movement)
    assert [frame.estimate for frame in back] == [frame.estimate for frame in frames]


def _plain_frames(rng, count=26):
    """Frames of Euler angles with gaps, arms that jump, and arms that were looked for anew."""
    x, frames, P, lost = 0.3 * rng.normal(size=14), [], None, 0
    for k in range(count):
        step = 0.03 * rng.normal(size=14)
        step[6:10] += 2.0 * (rng.random() < 0.1)
        x, before = x + step, P
        root = 0.02 * rng.normal(size=(14, 14))
        P = root @ root.T + 1e-4 * np.eye(14)
        lost = lost - 1 if lost else (int(rng.integers(1, 5)) if k and rng.random() < 0.15 else 0)
        prior = None
        if (before is not None and frames[-1].tracked and rng.random() < 0.9) or rng.random() < 0.5:
            carried = np.ones(14, dtype=bool)
            carried[10:14] = rng.random() < 0.7
            prior = Prior((P if before is None else before) + 0.03**2 * np.eye(14), carried)
        pose = pose_of_state(x, THESIS_JOINTS)
        known = Estimate(not lost or k == count - 1, "gone" * bool(lost), pose, x, P, prior=prior)
        frames.append(TrackedFrame(k, known, np.zeros((9, 3)), cloudless(k), {}))
    return frames


def _off(to, origin):
    delta = to - origin
    delta[3:] = (delta[3:] + np.pi) % (2.0 * np.pi) - np.pi
    return delta


def _jumped(delta):
    return [arm for arm in (range(6, 10), range(10, 14)) if np.abs(delta[arm]).max() >= np.pi / 2]


def _plainly_smoothed(frames, Q, longest, above):
    """States and covariances by frame, by the equations of Rauch, Tung and Striebel."""
    known = [frame.estimate for frame in frames]
    x, P = [e.x.copy() for e in known], [e.P.copy() for e in known]
    tracked = [k for k, e in enumerate(known) if e.tracked]
    done = set(tracked)
    inverse = np.linalg.inv

    def back(k, waiting, predicted, carried, after):
        ahead = _off(x[after], x[k] if k in tracked else waiting[0])
        carried = carried.copy()
        for arm in _jumped(ahead):
            carried[arm] = False
        gain, smaller = backward_step(waiting[1], predicted, carried, P[after])
        return waiting[0] + gain @ ahead, smaller

    for first, k in list(itertools.pairwise(tracked))[::-1]:
        prior, start, steps = known[k].prior, (known[first].x, known[first].P), k - first
        if steps == 1 and prior is not None:
            behind, carried = _off(start[0], x[k]), prior.carried.copy()
            surprise = behind[10:] ** 2 / np.diagonal(prior.P)[10:]
            if not carried.all() and surprise.mean() < above**2:
                expected = inverse(prior.P)
                expected[:10, :10] -= inverse(prior.P[:10, :10])
                total = expected + inverse(P[k])
                x[k], P[k] = x[k] + np.linalg.solve(total, expected @ behind), inverse(total)
                carried[:] = True
            x[first], P[first] = back(first, start, prior.P, carried, k)
        elif 1 < steps <= longest + 1 and not _jumped(moved := _off(x[k], start[0])):
            factor = prior_inflation(moved, start[1] + steps * Q, above)
            noise = factor[:, None] * Q * factor
            if prior is None:
                predicted = inverse(start[1] + steps * noise)
                total = predicted + inverse(P[k])
                x[k] = x[k] + np.linalg.solve(total, predicted @ _off(start[0], x[k]))
                P[k] = inverse(total)
            for i in range(steps - 1, -1, -1):
                waiting, predicted = start[1] + i * noise, start[1] + (i + 1) * noise
                place = back(
                    first, (start[0], waiting), predicted, np.ones(14, dtype=bool), first + i + 1
                )
                x[first + i], P[first + i] = place
                done.add(first + i)
    return x, P, done


@pytest.mark.parametrize("seed", range(6))
def test_every_frame_is_smoothed_by_the_one_after_it(make_tracker, seed):
    tracker, frames = make_tracker("thesis"), _plain_frames(np.random.default_rng(seed))
    p = dataclasses.replace(tracker.setup.parameters, longest_bridge=0.3, prior_inflation_above=2.0)
    setup = dataclasses.replace(tracker.setup, parameters=p)
    x, P, done = _plainly_smoothed(frames, setup.Q, 3, 2.0)
    for k, frame in enumerate(smoothed(frames, setup)):
        assert frame.tracked == (k in done)
        if not frame.tracked:
            continue
        np.testing.assert_allclose(_off(frame.x, x[k]), 0.0, atol=1e-8)
        np.testing.assert_allclose(frame.P, P[k], atol=1e-9)
