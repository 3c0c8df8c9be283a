"""What a run of the list holds."""

from __future__ import annotations

from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from app.session.judgement import judged
from app.session.runs import entry_of_run
from app.session.truth import recorded_truth
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from tests.gui.made_runs import made_run


@pytest.mark.parametrize("known", [range(8), range(2, 6), range(5, 8), range(0)])
def test_a_run_that_grows_is_judged_as_one_that_is_complete(small_recording, known):
    recording = open_recording(small_recording)
    whole = entry_of_run(made_run(recording, off=0.1, wild=(3, 5)), Path("run.npz"))
    grows, judgement = replace(whole, frames={}), None
    reference = recording.reference
    truth = recorded_truth(
        LandmarkTrajectory(reference.frame[list(known)], reference.points[list(known)])
    )
    for frames in (range(1), range(1, 4), range(4, 8)):
        grows.frames.update({k: whole.frames[k] for k in frames})
        judgement = judged(grows.now(), truth, judgement)
    expected = judged(whole.now(), truth)
    assert judgement.measure == expected.measure == ("error" if len(known) else "sigma")
    np.testing.assert_array_equal(judgement.frame, expected.frame)
    for limb, values in expected.limbs.items():
        np.testing.assert_array_equal(judgement.limbs[limb], values)
        np.testing.assert_array_equal(judgement.lost[limb], expected.lost[limb])
    if expected.errors is not None:
        for found, value in zip(astuple(judgement.errors), astuple(expected.errors), strict=True):
            np.testing.assert_array_equal(found, value)


def test_a_run_that_begins_again_forgets_what_came_after(small_recording):
    whole = entry_of_run(made_run(open_recording(small_recording)), Path("run.npz"))
    entry = replace(whole, frames={})
    for k in (0, 1, 2, 3, 1, 2):
        entry.put(whole.frames[k])
    assert list(entry.frames) == [0, 1, 2]
    assert entry.begun == 1


def test_a_run_knows_the_stretches_that_a_second_look_changed(small_recording):
    run = made_run(open_recording(small_recording))
    stored = entry_of_run(run, Path("run.npz"))
    assert stored.looked_again == []
    stored.stored = replace(run, meta={**run.meta, "looked_again": [[2, 5], [7, 7]]})
    assert stored.looked_again == [(2, 5), (7, 7)]
    stored.stored = stored.origin = None
    assert stored.looked_again == ()
