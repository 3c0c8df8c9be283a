"""Stretches with doubtful arms, tracked again: what is looked at, and which way is taken."""

import itertools
from contextlib import closing
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stereotrack_core.body.angles import state_of_pose
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.errors import Cancelled
from stereotrack_core.interop import run_journal
from stereotrack_core.interop.run_journal import RunJournal, read_unfinished
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking import second_look
from stereotrack_core.tracking.frame import FirstFrame
from stereotrack_core.tracking.lockstep import track_together
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.second_look import LOOKING_AGAIN, best_way, last_settled
from stereotrack_core.tracking.state import State
from stereotrack_core.tracking.step import PersonModel
from stereotrack_core.tracking.stored import check_meta, pose_of_run
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.trial import Trial, start_before
from tests.same_run import assert_same_estimate, same_run
from tests.tracking.recordings import write_depth_recording
from tests.tracking.running import tracked_frames
from tests.tracking.scenes import angle_errors, pose_with_arms, turned

SETTINGS = preset("accurate").replaced(
    pixel_step=1,
    speckle_size=0,
    search_arms=False,
    data_points=400,
    iterations=3,
    fit_shape=False,
    second_look=2,
)
BODY = body_model(AVERAGE, SETTINGS.body)
APART = pose_with_arms([0.6, 0.3, -0.7], [0.2, 0.9, 0.2], [-0.6, 0.3, -0.7], [-0.2, 0.9, 0.2])
ELSEWHERE = pose_with_arms([0.1, 0.1, -1], [0, 0.2, -1], [-0.1, 0.1, -1], [0, 0.2, -1])
ARMS = [*UPPER_ARMS, *FOREARMS]
COUNT, WRONG, AFTER = 12, (5, 6), 3
"""Frames, those in which the arms are put elsewhere, and how many without doubt end a stretch."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    poses = [turned(APART, 0.5 * k) for k in range(COUNT)]
    return write_depth_recording(tmp_path_factory.mktemp("look"), BODY, poses), poses


@pytest.fixture(scope="module", autouse=True)
def misled():
    """Trackers whose arms are put elsewhere in two frames, which they doubt."""
    step = PersonModel.step

    def mislead(model, before, cloud, recorder=None):
        state, found = step(model, before, cloud, recorder)
        if cloud.frame not in WRONG:
            return state, replace(found, limb_lost=np.full(6, 0.05))
        rotations = found.pose.rotations.copy()
        rotations[ARMS] = ELSEWHERE.rotations[ARMS]
        pose = replace(found.pose, rotations=rotations)
        x = state_of_pose(pose, model.setup.joints)
        leader = State(pose, found.P, cloud.frame, colours=state.leader.colours)
        state = replace(state, leader=leader)
        return state, replace(found, pose=pose, x=x, limb_lost=np.full(6, 0.9))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PersonModel, "step", mislead)
        patch.setattr(second_look, "_AFTER", AFTER)
        yield


@pytest.fixture(scope="module")
def whole(recording):
    """The run that looks again, and the numbers of its frames as they come."""
    seen = []
    recording, poses = recording
    run = track(recording, spec_of(poses), on_advance=lambda one: seen.extend(numbers(one)))
    return run, seen


def spec_of(poses, **changes):
    return RunSpec(SETTINGS.replaced(**changes), init=poses[0], frames=range(COUNT))


def numbers(advance):
    return [frame.frame for frame in advance.gained.frames]


def worst(run, poses):
    """Largest error of an arm in any frame, degrees."""
    found = [pose_of_run(run, i) for i in range(len(poses))]
    return max(angle_errors(BODY, *both)[2:].max() for both in zip(found, poses, strict=True))


def test_a_stretch_that_was_tracked_wrongly_is_tracked_again(recording, whole):
    (recording, poses), (looked, seen) = recording, whole
    without = track(recording, spec_of(poses, second_look=0))
    assert worst(without, poses) > 40.0
    assert worst(looked, poses) < 20.0
    ((first, over),) = looked.meta["looked_again"]
    assert 1 <= first <= WRONG[0]
    assert over == WRONG[-1] + AFTER
    assert seen == [*range(over + 1), *range(1, COUNT)]
    assert looked.frame.tolist() == list(range(COUNT))
    assert without.meta["looked_again"] == []
    check_meta(looked.meta, "run", "")


@pytest.mark.parametrize("tries", [1, 4])
def test_as_many_tries_are_made_as_are_asked_for_where_they_disagree(recording, monkeypatch, tries):
    made, from_state = [], second_look._Way.from_state

    def counted(start, model, number):
        made.append(number)
        return from_state(start, model, number)

    monkeypatch.setattr(second_look._Way, "from_state", counted)
    monkeypatch.setattr(second_look, "perf_counter", iter([100.0, 107.0]).__next__)
    (recording, poses), gained = recording, []
    track(recording, spec_of(poses, second_look=tries), on_advance=gained.append)
    assert made == list(range(tries + 1))
    spent = [second_look.spent_on(frame) for one in gained for frame in one.gained.frames]
    assert sum(spent) == pytest.approx(7.0), "the seconds are shared by the frames of the stretch"


def test_runs_side_by_side_look_again_as_one_alone_does(recording, whole):
    (recording, poses), (alone, _) = recording, whole
    given = replace(recording, reference=None)
    specs = [spec_of(poses), spec_of(poses, second_look=0)]
    first, second = track_together(given, specs)
    assert same_run(alone, first.run())
    assert first.run().meta["looked_again"] == alone.meta["looked_again"]
    assert second.run().meta["looked_again"] == []


@pytest.mark.parametrize("stop", [WRONG[0], WRONG[-1] + AFTER])
def test_a_run_that_was_stopped_looks_again_as_if_it_never_had_been(
    recording, whole, monkeypatch, tmp_path, stop
):
    monkeypatch.setattr(run_journal, "_FRAMES_PER_CHECKPOINT", 1)
    (recording, poses), (whole, _), seen = recording, whole, []
    spec, part = spec_of(poses), tmp_path / "run.part"
    journal = RunJournal(part, lambda: 0.0)

    def keep(advance):
        journal.keep(advance)
        seen.extend(numbers(advance))

    with closing(journal):
        hooks = Hooks(cancelled=lambda: seen[-1] >= stop)
        track(recording, spec, on_advance=keep, hooks=hooks)
    begun, _wish = read_unfinished(part)
    assert begun.checkpoint.frame == stop
    assert same_run(whole, track(recording, spec, begun=begun))


def test_a_program_that_is_killed_while_frames_come_again_loses_none(
    recording, whole, monkeypatch, tmp_path
):
    (recording, poses), (whole, _) = recording, whole
    spec, part = spec_of(poses), tmp_path / "run.part"
    journal, written, record_of = RunJournal(part, lambda: 0.0), [], run_journal._record_of

    def killed(frame, seconds):
        written.append(frame.frame)
        if len(written) > 2 and written[-1] == written[-2] + 1 < max(written):
            raise KeyboardInterrupt  # after the first frame that is written again
        return record_of(frame, seconds)

    with monkeypatch.context() as patch, closing(journal):
        patch.setattr(run_journal, "_record_of", killed)
        with pytest.raises(KeyboardInterrupt):
            track(recording, spec, on_advance=journal.keep)
    begun, _wish = read_unfinished(part)
    assert begun.checkpoint.frame < WRONG[0]
    assert same_run(whole, track(recording, spec, begun=begun))


def test_a_run_says_how_to_look_again(recording, whole):
    (recording, _), (run, _) = recording, whole
    again = stored_spec(run)
    assert again.spec.settings.tracking.second_look == 2
    assert same_run(run, track(recording, again.spec))


def test_stopping_ends_a_look_and_keeps_the_frames(recording):
    def stop(stage, _done, _count):
        if stage == LOOKING_AGAIN:
            raise Cancelled

    recording, poses = recording
    run = track(recording, spec_of(poses), hooks=Hooks(on_preparing=stop))
    assert run.frame.tolist() == list(range(WRONG[-1] + AFTER + 1))
    assert run.meta["looked_again"] == []


def costs_and_agreement():
    sizes = st.tuples(st.integers(1, 5), st.integers(1, 3))
    costs = sizes.flatmap(lambda size: arrays(float, size, elements=st.integers(0, 100).map(float)))
    return costs.flatmap(
        lambda found: st.tuples(st.just(found), arrays(bool, (*found.shape, found.shape[1])))
    )


@given(costs_and_agreement())
def test_the_best_way_is_the_best_of_all(case):
    costs, agree = case
    agree |= agree.transpose(0, 2, 1)
    count, ways = costs.shape

    def allowed(way):
        return all(a == b or agree[i, b, a] for i, (a, b) in enumerate(itertools.pairwise(way)))

    every = [way for way in itertools.product(range(ways), repeat=count) if allowed(way)]
    sums = [costs[np.arange(count), way].sum() for way in map(list, every)]
    found = best_way(costs, agree)
    if costs[:, 0].sum() - min(sums) > 20.0:
        assert allowed(found.tolist())
        assert costs[np.arange(count), found].sum() == min(sums)
    else:
        assert not found.any()


@pytest.mark.parametrize("stretch", [range(4, 6), range(3, COUNT)])
def test_a_trial_without_a_change_is_the_run_also_where_it_looked_again(recording, stretch):
    recording, poses = recording
    spec = spec_of(poses, second_look=2)
    frames, run = tracked_frames(recording, spec)
    assert run.look.changed
    before = {one.frame: one.without_cloud() for one in frames}
    start = start_before(before, stretch.start, FirstFrame(0, poses[0]))
    trial = Trial(replace(spec, frames=stretch), start, range(COUNT))
    with (
        FrameReader(recording, colour=False) as reader,
        closing(CloudStore(recording, reader)) as store,
        trial.begun(store) as (run, hooks),
    ):
        found = {}
        for advance in trial.advances(run, hooks):
            found |= {one.frame: one for one in advance.gained.frames}
    assert start.unlike == ()
    assert list(found) == list(stretch)
    for k, one in found.items():
        assert_same_estimate(one.estimate, before[k].estimate)


@pytest.mark.parametrize(
    ("tracked", "settled"),
    [
        pytest.param("-xx", 2, id="the first pose is settled at once"),
        pytest.param("xx-xx", 1, id="one after a loss is on trial"),
        pytest.param("xx-" + 12 * "x", 14, id="which is over after twelve frames"),
        pytest.param("--", None, id="nobody came"),
    ],
)
def test_a_pose_after_a_loss_decides_nothing_until_it_is_settled(tracked, settled):
    frames = {k: SimpleNamespace(tracked=one == "x", seconds={}) for k, one in enumerate(tracked)}
    assert last_settled(frames, len(frames) - 1) == settled
