"""Mono views with keypoints are tried, inspected and tracked together as stereo views are."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from stereotrack_core.tracking.lockstep import track_together
from stereotrack_core.tracking.model import cameras_of, model_for
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.tuning.process import KeptRecording, RecordStep, forget
from stereotrack_core.tracking.tuning.trial import Trial, TrialStart
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import FRAMES, mono_recording, truth
from tests.tracking.running import go_on, tracked_frames

WHOLE = range(FRAMES)


class Alone:
    """In place of the process that keeps what trials need."""

    cancelled = staticmethod(lambda: False)

    def __init__(self):
        self.kept = {}


@pytest.fixture(scope="module")
def mono(tmp_path_factory):
    recording = mono_recording(tmp_path_factory.mktemp("mono"), seen=True)
    keypoints = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=1.0), seed=3)
    spec = RunSpec(preset("accurate"), "accurate", WHOLE, keypoints=keypoints)
    frames, done = tracked_frames(recording, spec)
    return recording, spec, frames, done.body.shape, done.body


@pytest.fixture
def asker():
    alone = Alone()
    yield alone
    forget(alone)


def landmarks(frames):
    return np.array([frame.landmarks for frame in frames])


def test_a_trial_gives_the_run_again_and_fits_the_same_shape(mono, asker):
    recording, spec, frames, shape, _ = mono
    store = KeptRecording(recording, tuple("NOSW")).store(asker)
    before = TrialStart(frames[4].pose, frames[4].estimate.P, shape)
    stretch = replace(spec, frames=range(5, 8))
    trial = Trial(stretch, before, WHOLE)
    with trial.begun(store) as (run, _):
        found, _ = go_on(run, trial.stretch)
        np.testing.assert_array_equal(landmarks(found), landmarks(frames[5:]))
    with Trial(stretch, replace(before, shape=None), WHOLE).begun(store) as (run, _):
        assert run.body.shape == shape
    with Trial(spec).begun(store) as (run, _):
        np.testing.assert_array_equal(landmarks(go_on(run, WHOLE)[0]), landmarks(frames))


def test_a_step_is_done_again_with_the_frame_s_keypoints(mono, asker):
    recording, spec, frames, _, body = mono
    views = tuple("NOSW")
    make = partial(
        model_for, body, spec.settings, cameras_of(recording, views), recording.fps, 0,
        clouds=False,
    )  # fmt: skip
    kept = KeptRecording(recording, views)
    known = frames[3].estimate, frames[4].estimate
    done = RecordStep(kept, 4, spec.settings, make, *known, spec.keypoints)(asker)
    np.testing.assert_allclose(done.trace.after.pose.position, frames[4].pose.position, atol=1e-6)
    rows = done.trace.corrections[0].rows
    assert any(row.kind == "detection" and len(row.residual) > 40 for row in rows)


def test_runs_go_forward_together(mono):
    recording, spec, frames, _, _ = mono
    other = replace(spec, settings=spec.settings.replaced(keypoint_sigma=0.1))
    runs = [one.run() for one in track_together(recording, (spec, other))]
    np.testing.assert_array_equal(runs[0].landmarks, landmarks(frames))
    assert np.abs(runs[1].landmarks - runs[0].landmarks).max() > 1e-4
