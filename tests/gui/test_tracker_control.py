"""The tracker is run, held, stepped and stopped from the window."""

import multiprocessing
import os
import signal
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session.changes import Part
from stereotrack_core.project.exporting import formats_of
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.gui.hands import trigger

pytestmark = pytest.mark.window
LESS = {"fit_shape": False, "search_proposals": 60, "data_points": 300}
unix = pytest.mark.skipif(sys.platform == "win32", reason="there are no such signals")


@pytest.fixture
def opened(opened):
    """The window, with settings that take little time."""
    opened.context.session.track.choose("accurate", preset("accurate").replaced(**LESS))
    opened.context.session.track.first_pose = "tpose"
    return opened


def choose_usual(window):
    """Find the first pose, and track, as in a new window."""
    window.context.session.track.choose("accurate", preset("accurate"))
    window.context.session.track.first_pose = "auto"


@contextmanager
def standing_still(window):
    """The process that tracks does nothing meanwhile."""
    number = window.context.session.processes.run.pid
    os.kill(number, signal.SIGSTOP)
    yield
    os.kill(number, signal.SIGCONT)


def tracked(window) -> int:
    return (
        len(window.context.session.track.entry.frames)
        if window.context.session.track.entry is not None
        else 0
    )


def test_a_run_draws_while_it_works_and_ends_with_curves(opened, qtbot):
    docks = opened.context.docks
    session = opened.context.session
    choose_usual(opened)
    seen = []
    session.changes.hear(Part.TRACKED, lambda frame: seen.append(frame.frame))
    QTest.keyClick(opened, Qt.Key.Key_F8)
    qtbot.waitUntil(lambda: session.track.entry is None and len(session.runs.entries) == 1)
    qtbot.waitUntil(opened.context.tasks.settled)
    run = session.runs.active
    assert sorted(run.frames) == list(range(8))
    assert seen == sorted(seen)
    assert session.document.frame == 7
    judgement = session.judging.of(run)
    assert judgement.measure == "error"
    assert np.nanmedian(judgement.limbs["torso"]) < 15
    assert {lane.name for lane in docks.timeline.lanes} >= {"torso", "left forearm"}
    assert docks.timeline.verticalScrollBar().maximum() == 0, "every lane is seen in a small window"
    assert docks.views.tiles["N"].camera.picture.overlay.paths


def test_the_window_s_run_is_the_command_line_s(opened, qtbot):
    opened.context.docks.show_named("annotate")
    trigger(opened, "run")
    qtbot.waitUntil(lambda: opened.context.session.track.entry is None)
    assert opened.context.session.document.frame == 0, "who annotates stays in their frame"
    by_window = opened.context.session.runs.active.run()
    by_core = track(
        opened.context.session.document.recording,
        RunSpec(opened.context.session.track.settings, preset="accurate", init="tpose"),
    )
    np.testing.assert_array_equal(by_window.landmarks, by_core.landmarks)
    np.testing.assert_array_equal(by_window.P, by_core.P)
    seconds = by_window.meta.pop("wall_seconds")
    assert by_window.meta.pop("made") != by_core.meta.pop("made")
    assert seconds > 0
    assert by_window.meta == by_core.meta


@unix
def test_pause_holds_and_run_goes_on_with_the_same_run(opened, qtbot):
    track = opened.context.session.track
    trigger(opened, "step")
    qtbot.waitUntil(lambda: track.paused)
    with standing_still(opened):
        track.go_on()
        track.pause()
        assert not track.paused, "the tracker has not said that it is held"
    qtbot.waitUntil(lambda: track.paused)
    run, done = track.entry, tracked(opened)
    assert done < 8
    qtbot.wait(400)
    assert tracked(opened) == done
    opened.context.actions.refresh()
    trigger(opened, "run")
    qtbot.waitUntil(lambda: track.entry is None)
    assert opened.context.session.runs.entries == (run,)
    assert len(run.frames) == 8


@unix
def test_a_run_is_stopped_while_it_is_prepared_and_the_next_one_begins(opened, qtbot):
    choose_usual(opened)
    session = opened.context.session
    trigger(opened, "run")
    qtbot.waitUntil(lambda: "%" in session.track.live.preparing_words())
    assert 0.0 < session.track.live.preparing_share <= 1.0

    def said():
        opened.context.actions.refresh()
        return session.track.live.preparing_words() in opened.status.state.text()

    qtbot.waitUntil(said)
    hint = opened.context.docks.dock("plot").widget().currentWidget()
    assert hint.text().startswith("The tracker is running")
    trigger(opened, "stop")
    assert session.track.entry is None
    qtbot.waitUntil(lambda: hint.text().startswith("Run the tracker"))
    assert session.runs.entries == ()
    session.track.run_from_here()
    qtbot.waitUntil(lambda: session.track.entry is None)
    assert [len(run.frames) for run in session.runs.entries] == [8]


def test_a_run_is_saved_and_opened_again(opened, qtbot, tmp_path):
    trigger(opened, "step")
    qtbot.waitUntil(lambda: tracked(opened) == 1 and opened.context.session.track.paused)
    opened.context.session.track.stop()
    made = opened.context.session.runs.active
    opened.features.files.save_run(made, tmp_path / "run.npz")
    opened.features.files.open_run(tmp_path / "run.npz")
    again = opened.context.session.runs.active
    assert again is not made
    np.testing.assert_array_equal(again.at(0).landmarks, made.at(0).landmarks)
    np.testing.assert_allclose(again.at(0).pose.position, made.at(0).pose.position)
    for form in formats_of("run"):
        path = tmp_path / f"export{form.suffixes[0]}"
        opened.features.files.export(made, path, form)
        qtbot.waitUntil(opened.context.tasks.settled)
        assert path.exists() is not bool(form.missing), form.name
        if form.missing:
            assert "pip install" in opened.messages.text()
            opened.messages.dismiss()


def test_closing_while_tracking_ends_the_run_and_the_process(opened, qtbot):
    trigger(opened, "run")
    qtbot.waitUntil(lambda: tracked(opened) >= 1)
    number = opened.context.session.processes.run.pid
    opened.close()
    assert opened.context.session.track.entry is None
    for process in multiprocessing.active_children():
        if process.pid == number:
            process.join()
