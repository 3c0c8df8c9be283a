"""Trials are tracked one after the other in a process; only those that are wanted are told of."""

import os
import signal

import numpy as np
import pytest

from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.trial import Trial
from tests.tracking.running import go_on


@pytest.fixture
def opened(shown, small_recording):
    """A session with two stereo views."""
    shown.session.open(small_recording)
    shown.until(lambda: shown.session.project.project is not None and shown.session.settled())
    return shown.session


@pytest.fixture
def begin(opened):
    """Function from a trial to its entry."""

    def made(one):
        opened.trials.begin(one)
        return opened.trials.running

    return made


def trial(frames=range(2), **changes):
    settings = preset("thesis").replaced(fit_shape=False, **changes)
    return Trial(RunSpec(settings, frames=frames, init="tpose"))


def test_they_are_bit_identical_to_those_that_are_tracked_here(shown, opened, begin):
    trials = trial(), trial(range(1, 3), sigma_joint=25.0)
    entries = []
    for one in trials:
        entries.append(begin(one))
        shown.until(opened.trials.settled)
        assert len(entries[-1].frames) == 2
    assert [entry.kind for entry in entries] == ["run", "trial"], "the first one is the run"
    reader = FrameReader(opened.track.kept.recording, colour=False)
    store = CloudStore(opened.track.kept.recording, reader)
    for each, entry in zip(trials, entries, strict=True):
        with each.begun(store) as (run, _):
            frames, run = go_on(run, each.stretch)
            for expected in frames:
                found = entry.frames[expected.frame]
                np.testing.assert_array_equal(found.landmarks, expected.landmarks)
                for name in ("x", "P", "unexplained_fraction", "limb_sigma_deg"):
                    one, other = getattr(found.estimate, name), getattr(expected.estimate, name)
                    np.testing.assert_array_equal(one, other)
            assert entry.origin.meta["body"] == run.body.shape.values()
    store.close()
    reader.close()


def test_what_is_cancelled_is_not_told_of(shown, opened, begin):
    """A change of a parameter cancels."""
    early = begin(trial(range(8)))
    opened.trials.cancel()
    late = begin(trial())
    shown.until(lambda: opened.trials.settled() and shown.tasks.settled())
    assert (early.frames, early in opened.runs.entries) == ({}, False)
    assert list(late.frames) == [0, 1]


def test_a_failure_is_told_once_and_the_next_trials_are_done(shown, opened, begin):
    told = len(shown.messages)
    for right in (False, True):
        entry = begin(trial() if right else Trial(RunSpec(preset("thesis"), views=())))
        shown.until(opened.trials.settled)
        assert bool(entry.frames) == right == (entry in opened.runs.entries)
    assert [message.severity for message in shown.messages[told:]] == ["error"]


def test_a_process_that_is_killed_is_told_and_the_next_trials_are_done(
    shown, opened, begin, processes
):
    entry = begin(trial(range(8)))
    shown.until(lambda: bool(entry.frames))
    os.kill(processes.trials.pid, signal.SIGKILL)
    shown.until(opened.trials.settled)
    assert "memory" in shown.messages[-1].remedy
    assert 0 < len(entry.frames) < 8
    entry = begin(trial())
    shown.until(opened.trials.settled)
    assert list(entry.frames) == [0, 1]
