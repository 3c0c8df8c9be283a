"""Trials: equal to the pipeline's frames, one by one, stopped before the next step."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.tuning import trial as tuning_trial
from stereotrack_core.tracking.tuning.trial import Trial, TrialStart
from tests.tracking.running import go_on, tracked_frames
from tests.tracking.scenes import moving_pose
from tests.tracking.tuning.conftest import FRAMES

WHOLE = range(FRAMES)


def quick(name="accurate"):
    return preset(name).replaced(pixel_step=1, speckle_size=0, search_arms=False, data_points=400)


def trial(settings, stretch, start=None, seed=3, learned_from=WHOLE, init=None, name=""):
    """A trial that begins its fit of the shape with the first pose of the run."""
    first = moving_pose(0) if init is None else init
    return Trial(RunSpec(settings, name, stretch, seed=seed, init=first), start, learned_from)


def tracked(trial, store, cancelled=lambda: False):
    with trial.begun(store, cancelled) as (run, hooks):
        for advance in advances(run, trial.stretch, hooks):
            yield from advance.gained.frames


def equal(a, b):
    for one, other in zip(a, b, strict=True):
        assert one.frame == other.frame
        np.testing.assert_array_equal(one.landmarks, other.landmarks)
        for name in ("x", "P", "unexplained_fraction", "residual", "innovation"):
            found = getattr(one.estimate, name), getattr(other.estimate, name)
            np.testing.assert_array_equal(*found)


@pytest.fixture(scope="module")
def run(cones):
    settings = quick()
    frames, done = tracked_frames(cones, RunSpec(settings, seed=3, init=moving_pose(0)), WHOLE)
    return settings, frames, done.body.shape


def start_at(run, frame):
    _, frames, shape = run
    before = frames[frame - 1]
    return TrialStart(before.pose, before.P, shape)


def test_with_the_run_s_own_settings_a_trial_gives_the_run_again(cones, store_of, run):
    settings, frames, shape = run
    assert shape != settings.body, "the shape was fitted, so that keeping it matters"
    again = list(tracked(trial(settings, range(5, 8), start_at(run, 5)), store_of(cones)))
    equal(again, frames[5:])
    for one, other in zip(again[1:], frames[6:], strict=True):
        np.testing.assert_array_equal(one.estimate.limb_lost, other.estimate.limb_lost)


def test_a_trial_with_other_settings_is_a_pipeline_with_the_same_start(cones, store_of, run):
    settings = run[0].replaced(sigma_joint=25.0, iterations=3)
    start = start_at(run, 2)
    fixed = dataclasses.replace(settings.replaced(fit_shape=False), body=run[2])
    spec = RunSpec(fixed, seed=3, init=start.pose)
    expected, _ = tracked_frames(cones, spec, range(2, 5))
    without_P = dataclasses.replace(start, P=None)
    equal(tracked(trial(settings, range(2, 5), without_P), store_of(cones)), expected)


def test_clouds_and_shapes_serve_the_next_trial(cones, store_of, run, monkeypatch):
    store, unknown = store_of(cones), dataclasses.replace(start_at(run, 5), shape=None)
    list(tracked(trial(run[0], range(5, 8), unknown), store))
    monkeypatch.delattr(DepthChain, "measured")
    monkeypatch.delattr(tuning_trial, "with_fitted_shape")
    for settings in (run[0], run[0].replaced(sigma_joint=25.0)):
        assert len(list(tracked(trial(settings, range(5, 8), unknown), store))) == 3


@pytest.mark.parametrize(
    "name",
    [
        "accurate",
        "thesis",
        pytest.param("annealed", marks=pytest.mark.slow),
        pytest.param("ekf", marks=pytest.mark.slow),
    ],
)
def test_a_trial_ends_before_its_next_step_and_the_next_one_is_whole(cones, store_of, run, name):
    store, asked = store_of(cones), []
    settings = quick(name)
    start = dataclasses.replace(start_at(run, 2), shape=None if name == "thesis" else run[2])
    made = trial(settings, range(2, 5), start)
    frames = tracked(made, store, lambda: bool(asked.append(None)) or len(asked) > limit)
    limit = float("inf")
    whole = next(frames)
    limit = len(asked)
    with pytest.raises(Cancelled):
        next(frames)
    again = list(tracked(made, store))
    equal(again[:1], [whole])
    assert len(again) == 3


@pytest.mark.parametrize("kept", [True, False])
def test_lengths_that_a_run_has_estimated_are_kept_or_estimated_again(cones, store_of, run, kept):
    longer = dataclasses.replace(AVERAGE, upper_arm_length=0.30)
    settings = run[0].replaced(proportions="sequence", fit_shape=False)
    start = dataclasses.replace(start_at(run, 5), shape=None, lengths=longer if kept else None)
    made = trial(settings, range(5, 7), start)
    with made.begun(store_of(cones)) as (run, _):
        frames, done = go_on(run, made.stretch)
        assert all(frame.tracked for frame in frames)
    found = done.origin().meta["subject"]["upper_arm_length"]
    assert (found == longer.upper_arm_length) == kept
    assert found == pytest.approx(done.body.skeleton.proportions.upper_arm_length)
