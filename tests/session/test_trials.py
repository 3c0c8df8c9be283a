"""Trials are tracked one after the other in a process; only those that are wanted are told of."""

import os
import signal

import numpy as np
import pytest

from app.features.tune.trials import TrialRunner
from app.session.runs import RunEntry
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.process import KeptRecording
from stereotrack_core.tracking.tuning.trial import Trial
from stereotrack_core.worker_processes import Lost
from tests.tracking.running import go_on


class Session:
    """As much of a session as trials need."""

    def __init__(self, recording, processes, loop):
        self.kept, self.processes, self.document = KeptRecording(recording), processes, self
        self.recording, self.later = recording, loop.later


@pytest.fixture
def runner(tasks, small_recording, processes, plain):
    """A runner on two stereo views."""
    session = Session(open_recording(small_recording), processes, plain.loop)
    return TrialRunner(session, tasks, lambda: None)


@pytest.fixture
def begin(runner):
    """Function from a trial to its entry, what is told of it, and its work."""

    def made(one):
        told = []
        entry = RunEntry("trial", "", one.settings, body_model(AVERAGE), one.stretch)
        grown, ended = (lambda _, frames: told.append(frames)), (lambda _: told.append("ended"))
        return entry, told, runner.track("tracking", entry, one, grown, ended)

    return made


def trial(frames=range(2), **changes):
    settings = preset("thesis").replaced(fit_shape=False, **changes)
    return Trial(RunSpec(settings, frames=frames, init="tpose"))


def test_they_are_bit_identical_to_those_that_are_tracked_here(plain, runner, begin):
    trials = trial(), trial(range(1, 3), sigma_joint=25.0)
    entries = []
    for one in trials:
        entry, told, _ = begin(one)
        plain.until(lambda told=told: "ended" in told)
        assert sum(map(len, told[:-1])) == 2
        entries.append(entry)
    reader = FrameReader(runner._session.recording, colour=False)
    store = CloudStore(runner._session.recording, reader)
    for each, entry in zip(trials, entries, strict=True):
        with each.begun(store) as (run, _):
            frames, run = go_on(run, each.stretch)
            for expected in frames:
                found = entry.frames[expected.frame]
                np.testing.assert_array_equal(found.landmarks, expected.landmarks)
                for name in ("x", "P", "unexplained_fraction", "limb_sigma_deg"):
                    one, other = getattr(found.estimate, name), getattr(expected.estimate, name)
                    np.testing.assert_array_equal(one, other)
            assert entry.origin.shape == run.body.shape
    store.close()
    reader.close()


def test_what_is_cancelled_is_not_told_of(plain, tasks, begin):
    """A change of a parameter cancels."""
    early, unheard, work = begin(trial(range(8)))
    work.give_up()
    late, told, _ = begin(trial())
    plain.until(lambda: told[-1:] == ["ended"])
    plain.until(tasks.settled)
    assert (unheard, early.frames) == ([], {})
    assert list(late.frames) == [0, 1]


def test_a_failure_is_told_once_and_the_next_trials_are_done(plain, failed, begin):
    for right in (False, True):
        entry, told, _ = begin(trial() if right else Trial(RunSpec(preset("thesis"), views=())))
        plain.until(lambda told=told: told[-1:] == ["ended"])
        assert bool(entry.frames) == right
    assert [type(error) for error in failed] == [InputError]


def test_a_process_that_is_killed_is_told_and_the_next_trials_are_done(
    plain, failed, begin, processes
):
    entry, told, _ = begin(trial(range(8)))
    plain.until(lambda: bool(entry.frames))
    os.kill(processes.trials.pid, signal.SIGKILL)
    plain.until(lambda: told[-1:] == ["ended"])
    (error,) = failed
    assert isinstance(error, Lost)
    assert 0 < len(entry.frames) < 8
    entry, told, _ = begin(trial())
    plain.until(lambda: told[-1:] == ["ended"])
    assert list(entry.frames) == [0, 1]
