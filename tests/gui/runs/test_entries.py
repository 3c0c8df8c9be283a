"""What a run of the list holds."""

from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.session.runs import entry_of_run
from stereotrack_core.project.runs import kept_runs, load_run
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.tracking import run_checks
from stereotrack_core.tracking.presets import preset
from tests.gui.hands import heard, trigger
from tests.gui.made_runs import add_run, made_run


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Eight frames whose pictures nobody looks at."""
    folder = tmp_path_factory.mktemp("entries") / "tiny"
    options = SceneOptions().replaced(width=64, height=48, focal=50.0)
    simulate(folder, Simulation("P2", "t-pose", frames=8, views="N", options=options))
    return open_recording(folder)


def test_a_run_that_begins_again_forgets_what_came_after(recording):
    whole = entry_of_run(made_run(recording), Path("run.npz"))
    entry = replace(whole, frames={})
    for k in (0, 1, 2, 3, 1, 2):
        entry.put(whole.frames[k])
    assert list(entry.frames) == [0, 1, 2]
    assert entry.begun == 1


def test_a_run_knows_the_stretches_that_a_second_look_changed(recording):
    run = made_run(recording)
    stored = entry_of_run(run, Path("run.npz"))
    assert not stored.looked_again
    stored.stored = replace(run, meta={**run.meta, "looked_again": [[2, 5], [7, 7]]})
    assert stored.looked_again == [(2, 5), (7, 7)]
    stored.stored = stored.origin = None
    assert not stored.looked_again


def messages_of_run(window, qtbot, **changes):
    """Messages of a run over two frames."""
    said = heard(window)
    window.context.session.track.choose("fast", preset("fast").replaced(**changes))
    window.context.view_state.select(range(2))
    window.context.session.track.run_selection()
    qtbot.waitUntil(lambda: window.context.session.track.entry is None)
    qtbot.waitUntil(window.context.tasks.settled)
    return said


@pytest.mark.window
def test_where_nobody_is_tracked_the_step_is_named(opened, qtbot):
    [message] = messages_of_run(opened, qtbot, volume_centre_x=40.0)
    assert message.severity == "warning"
    assert "no frame of the run has a tracked person" in message.what
    assert "volume_centre_x" in message.remedy


@pytest.mark.window
def test_a_run_in_which_nothing_fits_is_said_and_kept_with_it(opened, qtbot, monkeypatch):
    assert messages_of_run(opened, qtbot) == []
    monkeypatch.setattr(run_checks, "MOST_UNEXPLAINED", 0.0)
    [message] = messages_of_run(opened, qtbot)
    assert message.severity == "warning"
    assert "is not explained by the body" in message.what
    assert "info --deep" in message.remedy
    runs = opened.context.session.project.project.runs
    first, second = (load_run(runs, kept.name).meta["warnings"] for kept in kept_runs(runs))
    assert first == []
    assert second == [message.what]


@pytest.mark.window
def test_a_run_on_selection_can_go_on_as_the_run_did_that_gives_its_pose(
    opened, qtbot, monkeypatch
):
    window, session, begun, as_it_did = opened, opened.context.session, [], []
    monkeypatch.setattr(session.track, "begin", lambda *_, **how: begun.append(how["start"]))
    monkeypatch.setattr(session.trials, "run_as", lambda *how: as_it_did.append(how))
    entry = add_run(window, "before", off=0.05)
    window.context.docks.show_named("track")
    session.view_state.select(range(3, 6))
    qtbot.waitUntil(window.context.tasks.settled)
    trigger(window, "run_selection")
    assert begun[0].words == "from run before, frame 2"
    assert "the initial pose is from run before, frame 2" in window.messages.text()
    button = window.messages.do_button
    assert button.text() == "As that run did"
    qtbot.waitUntil(lambda: not button.visibleRegion().isEmpty())
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert as_it_did == [(entry, range(3, 6))]
    assert not window.messages.isVisible()
