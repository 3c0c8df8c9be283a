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


def test_views_go_to_the_worst_frame_of_a_trial_and_play_around_it(shown, opened, begin):
    shown.state.show_workspace("tune")
    begin(trial())
    shown.until(opened.settled)
    entry = begin(trial(range(1, 6), sigma_joint=25.0))
    shown.until(lambda: opened.trials.settled() and opened.judging.settled())
    judgement, document = opened.judging.of(entry), opened.document
    worst = int(judgement.frame[np.nanargmax(np.nanmax(judgement.arms, axis=0))])
    assert worst in document.loop
    assert set(document.loop) <= set(range(1, 6))
    assert document.playing
    shown.state.show_workspace("review")
    assert (document.loop, document.playing) == (None, False)
    opened.trials.toggle_loops()
    shown.state.show_workspace("tune")
    begin(trial(range(1, 6), sigma_joint=30.0))
    shown.until(lambda: opened.trials.settled() and opened.judging.settled())
    assert document.loop is None
    assert document.frame in range(1, 6)


def test_a_run_on_selection_says_whose_pose_it_has_or_goes_on_as_that_run_did(shown, opened, begin):
    first = begin(trial(range(4), outlier_neighbours=0))  # few points are measured here
    shown.until(opened.settled)
    opened.track.choose("thesis", first.settings)
    shown.state.select(range(2, 4))
    start = opened.track.run_selection()
    shown.until(opened.settled)
    run = opened.runs.active
    assert start.run is first is not run
    assert run.origin.meta["init"] == start.words == f"from run {first.name}, frame 1"
    opened.trials.run_as(start.run, range(2, 4))
    shown.state.show_workspace("review")
    shown.until(opened.settled)
    again = opened.runs.active
    assert (again.kind, list(again.frames)) == ("run", [2, 3])
    np.testing.assert_array_equal(again.trial.start.P, first.frames[1].P)


def test_trials_are_named_before_they_are_lost_and_can_be_kept_as_far_as_they_are(
    shown, opened, begin
):
    begin(trial())
    shown.until(opened.settled)
    assert opened.would_be_lost() == ()
    begin(trial(sigma_joint=25.0))
    shown.until(opened.trials.settled)
    partial = begin(trial(range(8), sigma_joint=30.0))
    shown.until(lambda: bool(partial.frames))
    assert opened.would_be_lost() == ("2 trials",)
    opened.trials.keep()
    done = len(partial.frames)
    assert opened.would_be_lost() == ()
    assert [entry.kind for entry in opened.runs.entries] == ["run"] * 3
    assert len(partial.run().frame) == done >= 1
