"""The tracker is run, held, stepped and stopped from the window."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session import tracking
from app.session.runs import RunList
from app.session.tracking import TrackPresenter
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.run import Pipeline, track
from stereotrack_core.tracking.run_spec import RunSpec

pytestmark = pytest.mark.window


@pytest.fixture
def second_frame(monkeypatch):
    """Lets the tracker be at its second frame until this is set, or until it shall end."""
    goes_on = threading.Event()

    class Waiting(Pipeline):
        def frames(self, frames):
            for place, frame in enumerate(super().frames(frames)):
                if place == 1:
                    assert goes_on.wait(300)
                yield frame

    def stop(worker):
        goes_on.set()
        whole(worker)

    whole = tracking.TrackWorker.stop
    monkeypatch.setattr(tracking, "Pipeline", Waiting)
    monkeypatch.setattr(tracking.TrackWorker, "stop", stop)
    return goes_on


def trigger(window, name):
    action = window.context.actions.action(name)
    assert action.isEnabled(), action.statusTip()
    action.trigger()


def tracked(window) -> int:
    return (
        len(window.context.session.track.entry.frames)
        if window.context.session.track.entry is not None
        else 0
    )


def test_a_run_draws_while_it_works_and_ends_with_curves(opened, qtbot):
    seen = []
    opened.context.session.track.advanced.connect(lambda frame: seen.append(frame.frame))
    QTest.keyClick(opened, Qt.Key.Key_F8)
    qtbot.waitUntil(
        lambda: (
            opened.context.session.track.entry is None
            and len(opened.context.session.runs.entries) == 1
        ),
        timeout=90_000,
    )
    qtbot.waitUntil(opened.context.tasks.settled, timeout=30_000)
    run = opened.context.session.runs.active
    assert sorted(run.frames) == list(range(8))
    assert seen == sorted(seen)
    assert opened.context.session.document.frame == 7
    judgement = opened.context.session.judging.of(run)
    assert judgement.measure == "error"
    assert np.nanmedian(judgement.limbs["torso"]) < 15
    assert {lane.name for lane in opened.context.docks.timeline.lanes} >= {"torso", "left forearm"}
    assert opened.context.docks.timeline.verticalScrollBar().maximum() == 0, (
        "every lane is seen in a small window"
    )
    assert opened.context.docks.views.tiles["N"].camera.picture.overlay.paths


def test_the_window_s_run_is_the_command_line_s(opened, qtbot):
    trigger(opened, "run")
    qtbot.waitUntil(lambda: opened.context.session.track.entry is None, timeout=90_000)
    by_window = opened.context.session.runs.active.run()
    by_core = track(
        opened.context.session.document.recording,
        RunSpec(opened.context.session.track.settings, preset="accurate"),
    )
    np.testing.assert_array_equal(by_window.landmarks, by_core.landmarks)
    np.testing.assert_array_equal(by_window.P, by_core.P)
    seconds = by_window.meta.pop("wall_seconds")
    assert by_window.meta.pop("made") != by_core.meta.pop("made")
    assert seconds > 0
    assert by_window.meta == by_core.meta


def test_the_first_pose_is_found_without_help_or_taken_for_a_t_pose(opened, qtbot):
    assert opened.context.actions.action("first_pose_auto").isChecked()
    trigger(opened, "first_pose_tpose")
    opened.context.actions.refresh()
    assert not opened.context.actions.action("first_pose_auto").isChecked()
    trigger(opened, "step")
    qtbot.waitUntil(
        lambda: tracked(opened) == 1 and opened.context.session.track.paused, timeout=60_000
    )
    assert opened.context.session.runs.active.origin.spec.init == "tpose"
    assert opened.context.session.runs.active.frames[0].tracked


def test_step_tracks_one_frame_and_holds(opened, qtbot):
    trigger(opened, "step")
    qtbot.waitUntil(
        lambda: tracked(opened) == 1 and opened.context.session.track.paused, timeout=60_000
    )
    opened.context.actions.refresh()
    trigger(opened, "step")
    qtbot.waitUntil(
        lambda: tracked(opened) == 2 and opened.context.session.track.paused, timeout=60_000
    )
    assert opened.context.session.document.frame == 1
    opened.context.actions.refresh()
    assert "paused at 2 of 8" in opened.status.state.text()


def test_pause_holds_and_run_goes_on_with_the_same_run(opened, qtbot, second_frame):
    trigger(opened, "run")
    qtbot.waitUntil(lambda: tracked(opened) == 1, timeout=60_000)
    opened.context.session.track.pause()
    assert not opened.context.session.track.paused, "a frame is in work"
    second_frame.set()
    qtbot.waitUntil(lambda: opened.context.session.track.paused, timeout=30_000)
    run = opened.context.session.track.entry
    qtbot.wait(400)
    assert tracked(opened) == 2
    opened.context.actions.refresh()
    trigger(opened, "run")
    qtbot.waitUntil(lambda: opened.context.session.track.entry is None, timeout=90_000)
    assert opened.context.session.runs.entries == (run,)
    assert len(run.frames) == 8


def test_a_tracker_is_held_when_its_frames_are_there(qtbot, small_recording, monkeypatch):
    """Else it would be taken for one that is about to do the frame that it has just done."""

    class Quick(Pipeline):
        def prepare(self, frames):
            pass

        def frames(self, frames):
            kept = SimpleNamespace(tracked=True, unexplained_fraction=0.0, contradicted=np.nan)
            return (SimpleNamespace(frame=k, without_cloud=lambda: kept) for k in frames)

    monkeypatch.setattr(tracking, "Pipeline", Quick)
    track, recording = TrackPresenter(RunList()), open_recording(small_recording)
    entry = track.begin(recording, range(3), "tpose", None, allowed=1)
    worker = track._worker
    while not worker._results:
        worker._thread.join(0.001)  # no event is delivered meanwhile
    assert (track.next_frame(), track.running) == (0, True)
    assert track.held_before(0) is None
    qtbot.waitUntil(lambda: track.paused)
    assert (track.next_frame(), sorted(entry.frames)) == (1, [0])
    assert track.held_before(1) is worker.pipeline is not None
    track.stop()


def test_iterations_show_the_prediction_and_then_the_corrected_model(opened, qtbot):
    inside, shown = opened.features.inspect.inside, []
    for count in range(7):
        opened.context.actions.refresh()
        trigger(opened, "iterate")
        qtbot.waitUntil(
            lambda: inside.drawing is not None and opened.context.tasks.settled(), timeout=60_000
        )
        assert inside.index == count
        shown.append(inside.drawing)
    assert inside.live
    assert shown[0].words == "Predict"
    assert shown[5].words == "Iteration 1: Correct"
    assert shown[2].scene.lines, "pairs are drawn"
    assert not np.allclose(shown[0].pose.position, shown[5].pose.position)
    assert tracked(opened) == 0, "the tracker itself stays where it is"
    inside.go(len(inside.known.steps) - 1)
    trigger(opened, "iterate")
    qtbot.waitUntil(lambda: tracked(opened) == 1, timeout=60_000)
    found = opened.context.session.runs.active.frames[0].pose
    np.testing.assert_array_equal(
        shown[0].body.cones.r1, opened.context.session.runs.active.body.cones.r1
    )
    np.testing.assert_array_equal(found.rotations, inside.known.trace.after.pose.rotations)


def test_changed_settings_apply_to_the_next_step_as_a_new_run(opened, qtbot):
    trigger(opened, "step")
    qtbot.waitUntil(
        lambda: tracked(opened) == 1 and opened.context.session.track.paused, timeout=60_000
    )
    first = opened.context.session.track.entry
    opened.features.tune.parameters.settings_changed.emit(
        opened.context.session.track.settings.replaced(iterations=2)
    )
    opened.context.actions.refresh()
    trigger(opened, "step")
    qtbot.waitUntil(
        lambda: opened.context.session.track.entry is not first and tracked(opened) == 1,
        timeout=60_000,
    )
    second = opened.context.session.track.entry
    assert sorted(first.frames) == [0]
    assert sorted(second.frames) == [1]
    assert second.settings.tracking.iterations == 2


def test_a_selection_is_tracked_alone(opened, qtbot):
    opened.context.docks.timeline.set_selection(range(2, 5))
    opened.context.docks.timeline.selection_changed.emit(range(2, 5))
    opened.context.actions.refresh()
    trigger(opened, "run_selection")
    qtbot.waitUntil(lambda: opened.context.session.track.entry is None, timeout=90_000)
    assert sorted(opened.context.session.runs.active.frames) == [2, 3, 4]


def test_a_run_is_saved_and_opened_again(opened, qtbot, tmp_path):
    trigger(opened, "step")
    qtbot.waitUntil(
        lambda: tracked(opened) == 1 and opened.context.session.track.paused, timeout=60_000
    )
    opened.context.session.track.stop()
    made = opened.context.session.runs.active
    opened.features.files.save_run(made, tmp_path / "run.npz")
    opened.features.files.open_run(tmp_path / "run.npz")
    again = opened.context.session.runs.active
    assert again is not made
    np.testing.assert_array_equal(again.at(0).landmarks, made.at(0).landmarks)
    np.testing.assert_allclose(again.at(0).pose.position, made.at(0).pose.position)


@pytest.mark.usefixtures("second_frame")
def test_closing_while_tracking_ends_the_thread(opened, qtbot):
    trigger(opened, "run")
    qtbot.waitUntil(lambda: tracked(opened) == 1, timeout=60_000)
    opened.close()
    assert opened.context.session.track.entry is None
