"""The state of a tracker is saved and restored whole, also after alternatives that fail."""

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking import keypoint_tracker, second_look
from stereotrack_core.tracking.iekf import PoseFilter
from stereotrack_core.tracking.initialise.heading_watch import HeadingWatch
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.second_look import SecondLook
from stereotrack_core.tracking.state import Setup, State
from stereotrack_core.tracking.tracker import tracker_for
from stereotrack_core.tracking.ukf import ThesisTracker
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points, turned
from tests.tracking.test_second_look import frame_with

PRESETS = ("thesis", "accurate", "fast", "ekf", "annealed", "limb-icp", "scalar", "keypoints")
PER_FRAME = ("_chosen", "origin.")
"""Ends or middles of places whose values are written before they are read in every step."""


def tracker_of(name):
    settings = preset("accurate" if name == "keypoints" else name)
    if name != "thesis":
        settings = settings.replaced(data_points=300, search_arms=False)
    body = body_model(AVERAGE, settings.body)
    tracker = tracker_for(body, settings, CAMERAS, 10.0, 0, clouds=name != "keypoints")
    tracker.start(POSES["pointing"])
    return tracker


def clouds_of(tracker, count=5):
    """Coloured clouds of a body that turns slowly, with keypoints."""
    rng = np.random.default_rng(1)
    for k in range(count):
        pose = turned(POSES["pointing"], 2.0 * k)
        points = surface_points(tracker.setup.body, pose, 1200, rng, 0.005)
        colours = np.clip(points * 100.0 + 100.0, 0, 255)
        yield replace(cloud_of(points, k), colours=colours, keypoints=seen(pose))


def everything(value, place="", inside=frozenset()):
    """All numbers that an object holds, by their place; without what never changes."""
    if isinstance(value, np.random.Generator):
        value = value.bit_generator.state
    if isinstance(value, Setup) or callable(value) or id(value) in inside:
        return {}
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list | tuple):
        items = enumerate(value)
    elif is_dataclass(value):
        items = ((each.name, getattr(value, each.name)) for each in fields(value))
    elif hasattr(value, "__dict__"):
        items = vars(value).items()
    else:
        return {place: np.array(value)}
    found, inside = {}, inside | {id(value)}
    for name, each in items:
        found |= everything(each, f"{place}.{name}", inside)
    return found


def differences(found, wanted):
    """Places at which two objects do not hold the same numbers."""
    names = found.keys() | wanted.keys()
    return sorted(
        name
        for name in names
        if not any(part in name for part in PER_FRAME)
        and not (
            name in found
            and name in wanted
            and np.array_equal(found[name], wanted[name], equal_nan=found[name].dtype.kind == "f")
        )
    )


@pytest.mark.parametrize("name", PRESETS)
def test_a_saved_state_is_restored_whole_after_an_abandoned_try(name):
    tracker = tracker_of(name)
    *first, second, third = clouds_of(tracker)
    for cloud in first:
        assert tracker.step(cloud).tracked
    saved, before = tracker.memory(), everything(tracker)
    kept = {key: np.array(array) for key, array in saved.items()}
    expected = tracker.step(second)
    tracker.step(replace(cloud_of(np.empty((0, 3)), 5), keypoints=None))
    if name in ("thesis", "accurate", "keypoints"):  # the others look for a body as accurate does
        tracker.step(third)
    for key, array in saved.items():
        np.testing.assert_array_equal(array, kept[key], err_msg=f"a saved {key} has changed")
    tracker.recall(saved)
    assert differences(everything(tracker), before) == []
    again = tracker.step(second)
    np.testing.assert_array_equal(again.x, expected.x)
    np.testing.assert_array_equal(again.P, expected.P)
    np.testing.assert_array_equal(again.limb_lost, expected.limb_lost)


def lost_at(monkeypatch, place):
    """Let the filter's step be lost for the place-th time that it is asked."""
    step, asked = PoseFilter.step, []

    def lose(self, cloud, trace=None):
        asked.append(cloud.frame)
        before = self.state
        if len(asked) == place:
            step(self, cloud, trace)
            return self.lost(before, cloud, "the cloud does not match the body")
        return step(self, cloud, trace)

    monkeypatch.setattr(PoseFilter, "step", lose)
    return asked


@pytest.mark.parametrize("name", PRESETS[1:])
def test_an_alternative_that_fails_leaves_the_tracker_as_it_was(name, monkeypatch):
    tracker = tracker_of(name)
    *first, last = clouds_of(tracker, 3)
    for cloud in (*first, last):
        tracker.step(cloud)
    before = everything(tracker)
    lost_at(monkeypatch, 1)
    elsewhere = tracker.setup.first_state(turned(POSES["pointing"], 180.0), last.frame)
    assert tracker.try_from(elsewhere, last, None) is None
    assert differences(everything(tracker), before) == []


def test_a_proposal_by_keypoints_that_fails_leaves_the_tracker_as_it_was(monkeypatch):
    *first, last = clouds_of(tracker_of("keypoints"), 3)
    states = []
    for proposed in (None, turned(POSES["pointing"], 90.0)):
        tracker = tracker_of("keypoints")
        with monkeypatch.context() as patch:
            patch.setattr(keypoint_tracker, "pose_of_keypoints", lambda *_: None)
            for cloud in first:
                tracker.step(cloud)
            patch.setattr(keypoint_tracker, "pose_of_keypoints", lambda *_, p=proposed: p)
            cost = lambda _self, _cloud, pose, p=proposed: 0.1 if pose is p else 0.5  # noqa: E731
            patch.setattr(type(tracker), "_cost", cost)
            asked = lost_at(patch, 2)
            assert tracker.step(last).tracked
        assert len(asked) == (1 if proposed is None else 2)
        states.append(everything(tracker))
    assert differences(*states) == []


def test_a_body_that_cannot_be_turned_round_stays_tracked(monkeypatch):
    tracker = tracker_of("accurate")
    *first, last = clouds_of(tracker, 3)
    for cloud in first:
        tracker.step(cloud)
    monkeypatch.setattr(tracker.finder, "gain_of_turning", lambda *_: 1000.0)
    lost_at(monkeypatch, 2)
    assert tracker.step(last).tracked
    assert not tracker.leader.state.is_first


def test_a_rival_that_cannot_be_followed_is_not_taken(monkeypatch):
    tracker = tracker_of("accurate")
    *first, last = clouds_of(tracker, 3)
    for cloud in first:
        tracker.step(cloud)
    (rival,) = tracker.finder.poses_of(first[-1], tracker.pose)[:1]
    tracker._unchanged, tracker._cost, rival.cost = 0, 1000.0, 0.0
    tracker._rivals = [rival]
    lost_at(monkeypatch, 3)
    assert tracker.step(last).tracked
    assert not tracker.leader.state.is_first
    assert tracker._unchanged == 1


def test_the_thesis_gives_up_a_frame_from_its_prediction(monkeypatch):
    tracker = tracker_of("thesis")
    *first, last = clouds_of(tracker, 3)
    for cloud in first:
        tracker.step(cloud)
    x, P, sample, asked = tracker.x, tracker.P + tracker.Q, ThesisTracker.sample, []

    def none_at_last(self, trace=None):
        asked.append(1)
        found = sample(self, trace)
        return found[:0] if len(asked) == 2 else found

    monkeypatch.setattr(ThesisTracker, "sample", none_at_last)
    assert not tracker.step(last).tracked
    np.testing.assert_array_equal(tracker.x, x)
    np.testing.assert_array_equal(tracker.P, P)


def test_a_second_look_that_is_given_up_changes_nothing(monkeypatch):
    monkeypatch.setattr(second_look, "_DOUBTFUL", -1.0)
    tracker, look = tracker_of("accurate"), SecondLook(2)
    clouds = list(clouds_of(tracker, 4))
    for cloud in clouds:
        tracker.step(cloud)
        look.take(frame_with(tracker, cloud.frame, 0.9), tracker)
    before = everything(tracker), everything(look)

    def give_up(done, _count):
        if done == 2:
            raise Cancelled

    class Made(list):
        __enter__, __exit__ = lambda self: self, lambda *_: None

    with pytest.raises(Cancelled):
        look.look(tracker, lambda frames: Made((clouds[k], 0.0) for k in frames), give_up)
    assert differences(everything(tracker), before[0]) == []
    assert differences(everything(look), before[1]) == []


def test_a_saved_heading_does_not_change_with_later_frames():
    tracker = tracker_of("accurate")
    watch = HeadingWatch(10.0, first=(0, tracker.pose))
    first, second, *_ = clouds_of(tracker, 3)
    watch.take(tracker.finder, tracker.pose, first)
    saved = watch.memory()
    kept = {key: np.array(array) for key, array in saved.items()}
    watch.active = True
    watch.take(tracker.finder, tracker.pose, second)
    for key, array in saved.items():
        np.testing.assert_array_equal(array, kept[key], err_msg=key)


def test_a_state_says_whether_an_earlier_frame_predicts_the_next():
    tracker = tracker_of("accurate")
    assert tracker.leader.state.is_first
    (cloud,) = clouds_of(tracker, 1)
    assert tracker.step(cloud).prior is None
    assert not tracker.leader.state.is_first
    tracker.resume(State(tracker.pose, tracker.P, 0.0))
    assert tracker.step(replace(cloud, frame=1)).prior is not None
