"""A run of mono views says nothing that failures are told by, and has no clouds to look at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereotrack_core.evaluation.failure_segments.find import failures
from stereotrack_core.evaluation.failure_segments.stretches import has_signs
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import mono_recording, truth


def test_only_a_reference_and_gaps_tell_failures_of_mono_views(tmp_path):
    recording = mono_recording(tmp_path)
    keypoints = simulated_keypoints(truth(), recording.cameras, KeypointErrors(noise=3.0), seed=3)
    run = track(recording, RunSpec(preset("fast"), keypoints=keypoints))
    assert not has_signs(run)
    assert failures(run, recording=recording) == ()
    wrong = replace(truth(), points=truth().points[:, ::-1])
    found = failures(run, recording=recording, reference=wrong)
    assert {one.found for one in found} == {"truth"}
    untracked = replace(run, tracked=np.zeros_like(run.tracked))
    assert {one.found for one in failures(untracked, recording=recording)} == {"signs"}
