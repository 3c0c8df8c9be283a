"""From a recording to a run."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import run_of
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.saved_state import restored, saved
from stereotrack_core.tracking.stored import body_of_run, pose_of_run
from tests.same_run import assert_same_estimate, same_run
from tests.tracking.recordings import write_depth_recording
from tests.tracking.running import go_on, tracked_frames
from tests.tracking.scenes import moving_pose

FRAMES, MISSING = 6, 4


def _settings(name):
    changes = {"search_arms": False, "data_points": 400} if name == "fast" else {}
    return preset(name).replaced(pixel_step=1, speckle_size=0, **changes)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Six frames of four depth views; the body is out of sight in one of them."""
    body = body_model(AVERAGE, _settings("fast").body)
    folder = tmp_path_factory.mktemp("recording") / "cones"
    return write_depth_recording(
        folder, body, [moving_pose(k) for k in range(FRAMES)], missing={MISSING}
    )


@pytest.fixture(scope="module")
def fast_run(recording):
    return track(recording, RunSpec(_settings("fast"), preset="fast", seed=3))


def test_the_run_follows_the_body(recording, fast_run):
    np.testing.assert_array_equal(fast_run.frame, np.arange(FRAMES))
    np.testing.assert_array_equal(fast_run.tracked, np.arange(FRAMES) != MISSING)
    errors = np.linalg.norm(fast_run.landmarks - recording.reference.points, axis=-1)
    assert np.nanmax(errors) < 0.06
    assert np.nanmean(errors) < 0.025
    assert np.isnan(fast_run.landmarks[MISSING]).all()
    assert np.isnan(fast_run.x[MISSING]).all()


@pytest.fixture(scope="module")
def smooth_run(recording):
    return track(recording, RunSpec(_settings("fast"), preset="fast", seed=3, smooth=True))


def test_smoothing_fills_a_frame_without_points_and_says_so(recording, fast_run, smooth_run):
    assert (fast_run.meta["smoothed"], fast_run.meta["bridged"]) == (False, [])
    assert (smooth_run.meta["smoothed"], smooth_run.meta["bridged"]) == (True, [MISSING])
    assert smooth_run.tracked.all()
    errors = np.linalg.norm(smooth_run.landmarks - recording.reference.points, axis=-1)
    assert errors[MISSING].mean() < 0.05
    seen = np.arange(FRAMES) != MISSING
    assert errors[seen].mean() < 0.025
    # both are about the axes of their own poses: eigenvalues do not depend on those
    larger = np.linalg.eigvalsh(fast_run.P[seen]) - np.linalg.eigvalsh(smooth_run.P[seen])
    assert larger.min() > -1e-9
    assert np.trace(smooth_run.P[0]) < np.trace(fast_run.P[0])
    np.testing.assert_array_equal(smooth_run.unexplained_fraction, fast_run.unexplained_fraction)
    assert np.isnan(smooth_run.unexplained_fraction[MISSING])


def test_a_smoothed_run_that_is_cancelled_keeps_what_it_has(recording):
    spec = RunSpec(_settings("fast"), init=moving_pose(0), smooth=True)
    run = track(recording, spec, hooks=Hooks(cancelled=lambda: True))
    assert list(run.frame) == [0]
    assert run.meta["smoothed"]


def test_the_thesis_follows_it_too(recording):
    run = track(recording, RunSpec(_settings("thesis"), preset="thesis", frames=range(4)))
    errors = np.linalg.norm(run.landmarks - recording.reference.points[:4], axis=-1)
    assert run.tracked.all()
    assert len(run.state_names) == run.x.shape[1] == 14
    assert np.mean(errors) < 0.06


def test_the_reference_is_never_seen(recording, fast_run):
    without = dataclasses.replace(recording, reference=None)
    assert same_run(track(without, RunSpec(_settings("fast"), preset="fast", seed=3)), fast_run)
    wrong = LandmarkTrajectory(np.arange(FRAMES), np.full((FRAMES, len(LANDMARKS), 3), 7.0))
    misled = dataclasses.replace(recording, reference=wrong)
    assert same_run(track(misled, RunSpec(_settings("fast"), preset="fast", seed=3)), fast_run)


def test_the_run_says_where_it_comes_from(recording, fast_run):
    meta = fast_run.meta
    assert (meta["preset"], meta["seed"], meta["views"]) == ("fast", 3, list("NOSW"))
    assert (meta["recording"], meta["fps"], meta["init"]) == ("cones", 10.0, "auto")
    assert meta["parameters"] == _settings("fast").values()
    assert meta["subject"]["torso_length"] == AVERAGE.torso_length
    assert {"read", "track"} <= set(fast_run.stage_names)
    assert fast_run.seconds.shape == (FRAMES, len(fast_run.stage_names))
    assert (fast_run.seconds >= 0).all()


@pytest.mark.parametrize("length", [1e308, -0.2, "wide"])
def test_impossible_lengths_of_a_stored_body_are_refused(fast_run, length):
    subject = {"name": "", "hip_width": length, "torso_length": None}
    run = dataclasses.replace(fast_run, meta={**fast_run.meta, "subject": subject})
    with pytest.raises(InputError, match=r"subject, hip_width"):
        body_of_run(run)


def test_a_run_with_a_body_of_another_version_is_refused(fast_run, tmp_path):
    body = {**fast_run.meta["body"], "waist": 0.3}
    path = tmp_path / "run.npz"
    write_run(path, dataclasses.replace(fast_run, meta={**fast_run.meta, "body": body}))
    with pytest.raises(InputError, match=r"unknown parameter 'waist'") as refused:
        read_run(path)
    assert str(path) in refused.value.where
    assert "--set" not in str(refused.value)


def test_poses_of_a_stored_run_reproduce_its_landmarks(recording, fast_run, tmp_path):
    write_run(tmp_path / "run.npz", fast_run)
    stored = read_run(tmp_path / "run.npz")
    body = body_of_run(stored)
    for i in range(FRAMES):
        pose = pose_of_run(stored, i)
        if i == MISSING:
            assert pose is None
        else:
            np.testing.assert_allclose(landmarks(body, pose), fast_run.landmarks[i], atol=1e-9)


def test_the_shape_that_was_fitted_and_tracked_with_comes_back(tmp_path):
    settings = _settings("fast").replaced(torso_radius_low=0.15, fit_shape=True)
    body, poses = (
        body_model(AVERAGE, _settings("fast").body),
        [moving_pose(0.3 * k) for k in range(12)],
    )
    recording = write_depth_recording(tmp_path, body, poses)
    frames, done = tracked_frames(recording, RunSpec(settings, init=moving_pose(0)), range(12))
    run, used = run_of(frames, done.origin()), done.body.cones
    assert used["r1"][0] == pytest.approx(body.cones["r1"][0], abs=0.006)
    write_run(tmp_path / "run.npz", run)
    stored = body_of_run(read_run(tmp_path / "run.npz")).cones
    np.testing.assert_array_equal(stored, used)


def test_a_cancelled_run_keeps_what_it_has(recording, fast_run):
    seen = []
    run = track(
        recording,
        RunSpec(_settings("fast"), seed=3, frames=range(FRAMES)),
        on_advance=lambda advance: seen.extend(advance.gained.frames),
        hooks=Hooks(cancelled=lambda: len(seen) == 2),
    )
    assert [frame.frame for frame in seen] == list(run.frame) == [0, 1]
    np.testing.assert_array_equal(run.x, fast_run.x[:2])


def test_every_frame_is_replayed_from_its_saved_state_to_the_last_bit(recording):
    spec = RunSpec(_settings("accurate"), seed=3, frames=range(FRAMES))
    rng = np.random.default_rng(11)
    with Clouds(recording, spec) as clouds:
        run = prepare(clouds)
        states, frames = [], []
        for frame in clouds.frames:
            states.append(run)
            [found], run = go_on(run, range(frame, frame + 1))
            frames.append(found)
        for k in rng.integers(0, FRAMES, 15).tolist():  # in any order, and some twice
            before = states[k]
            kept = {name: array.copy() for name, array in saved(before.state, "state").items()}
            state = restored(type(before.state), kept, "state")
            [again], _ = go_on(dataclasses.replace(before, state=state), range(k, k + 1))
            assert_same_estimate(again.estimate, frames[k].estimate)


def test_a_first_pose_can_be_given(recording):
    run = track(recording, RunSpec(_settings("fast"), frames=range(3, 4), init=moving_pose(3)))
    errors = np.linalg.norm(run.landmarks[0] - recording.reference.points[3], axis=-1)
    assert errors.max() < 0.06
    assert run.meta["init"] == "pose"


def test_two_views_are_enough_to_go_on(recording):
    run = track(recording, RunSpec(_settings("fast"), views=["S", "N"], frames=range(3)))
    assert run.meta["views"] == ["N", "S"]
    assert run.tracked.all()


@pytest.mark.parametrize("views", [["X"], ["N", "X"], []])
def test_unknown_views_are_refused_with_the_known_ones(recording, views):
    with pytest.raises(InputError, match="N, O, S, W") as refused:
        Clouds(recording, RunSpec(_settings("fast"), views=views))
    assert refused.value.where == "--views"


def test_views_without_depth_alone_are_refused(recording):
    plain = {"kind": "mono", "depth": None, "mask": None}
    views = tuple(dataclasses.replace(view, **plain) for view in recording.views)
    mono = dataclasses.replace(recording, views=views)
    with pytest.raises(InputError, match="no view provides depth"):
        track(mono, RunSpec(_settings("fast")))


def test_mono_views_are_left_out(recording):
    first = dataclasses.replace(recording.views[0], kind="mono", depth=None, mask=None)
    mixed = dataclasses.replace(recording, views=(first, *recording.views[1:]))
    assert usable_views(mixed, None) == ("O", "S", "W")
    assert usable_views(mixed, ["W", "O", "W"]) == ("O", "W")
    with pytest.raises(InputError, match="unknown view with depth: N"):
        usable_views(mixed, ["N"])
