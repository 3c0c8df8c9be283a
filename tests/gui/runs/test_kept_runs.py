"""Runs of the window go into the project by themselves and come back with it."""

import threading
from dataclasses import replace

import pytest
from PySide6.QtCore import Qt

from app.features.track import keeping as keeper
from app.session.changes import Part
from app.session.runs import RunEntry, entry_of_run
from stereotrack_core.project.runs import keep_run, kept_runs, load_run
from stereotrack_core.tracking.presets import preset
from tests.gui.hands import settle, show_workspace, trigger
from tests.gui.kept_window import open_recording
from tests.gui.made_runs import add_run, made_run
from tests.same_run import same_run

pytestmark = pytest.mark.window

MADE = {
    "preset": "fast",
    "seed": 5,
    "views": ["N", "S"],
    "init": "auto",
    "wall_seconds": 75.0,
    "made": "2026-01-02T03:04:05.000+00:00",
}


def finished(window, name, off=0.05, **changes) -> RunEntry:
    """A run as the tracker leaves it when it has come to its end."""
    run = made_run(window.context.session.document.recording, off=off)
    parameters = preset("fast").replaced(**changes).values()
    run = replace(run, meta={**run.meta, **MADE, "parameters": parameters})
    entry = entry_of_run(run, window.context.session.document.recording.folder)
    entry.name, entry.path = name, None
    window.context.session.runs.add(entry)
    return entry


def track_quickly(window):
    settings = preset("fast").replaced(iterations=2, fit_shape=False)
    window.context.session.track.choose("fast", settings)
    window.context.session.track.first_pose = "tpose"


def names(window):
    return [entry.name for entry in window.context.session.runs.entries]


def kept(window):
    return [one.name for one in kept_runs(window.context.session.project.project.runs)]


def reopen(window, qtbot):
    folder = window.context.session.document.recording.folder
    window.context.session.document.close()
    open_recording(window, qtbot, folder)


@pytest.fixture
def tracking(opened, qtbot):
    """The Track workspace with an empty project."""
    show_workspace(opened, qtbot, "track")
    return opened


def test_a_finished_run_is_kept_by_itself_and_comes_back_with_the_project(tracking, qtbot):
    first, second = finished(tracking, "run"), finished(tracking, "run", off=0.1, iterations=2)
    settle(tracking, qtbot)
    assert kept(tracking) == ["run", "run (2)"]
    assert (first.kept, second.kept, names(tracking)) == ("run", "run (2)", kept(tracking))
    assert same_run(load_run(tracking.context.session.project.project.runs, "run"), first.run())
    tracking.context.session.runs.show(first, visible=False)
    before = second.run()
    settle(tracking, qtbot)
    reopen(tracking, qtbot)
    hidden, shown = tracking.context.session.runs.entries
    assert (hidden.name, hidden.visible, hidden.waiting) == ("run", False, True)
    assert shown is tracking.context.session.runs.active
    assert same_run(before, shown.run())
    now = tracking.context.session.snapshot
    row = tracking.features.track.row(now, hidden)
    frames, _score, time, seed, _when = (one.text for one in row.facts)
    assert (frames, seed, time) == ("0 – 7", "5", "75 s")
    made = tracking.features.track.row(now, shown).made
    assert "iterations 2 instead of 3" in made
    assert made.endswith("Track, Install pose detector …"), "it would have helped"
    item = tracking.features.track.panel.tree.topLevelItem(0)
    item.setCheckState(0, Qt.CheckState.Checked)
    settle(tracking, qtbot)
    assert len(hidden.frames) == 8


def test_a_mean_over_a_part_of_a_run_says_over_how_many_frames(tracking, qtbot):
    whole, _ = finished(tracking, "whole"), add_run(tracking, "part", off=0.1, frames=slice(2, 5))
    settle(tracking, qtbot)
    row = tracking.features.track.row(tracking.context.session.snapshot, whole)
    assert row.facts[1].text.endswith(") in 3 frames")


def test_a_run_is_named_removed_and_restored(tracking, qtbot):
    entry = finished(tracking, "run")
    settle(tracking, qtbot)
    panel = tracking.features.track.panel
    panel.tree.topLevelItem(0).setText(0, "with the coat")
    assert (names(tracking), kept(tracking)) == (["with the coat"], ["with the coat"])
    tracking.features.track.with_active(tracking.features.track.keeper.remove)
    assert (names(tracking), kept(tracking)) == ([], [])
    assert tracking.context.session.edits.to_undo() is None, "undo knows nothing of runs"
    reopen(tracking, qtbot)
    tracking.context.actions.refresh()
    trigger(tracking, "restore_run", qtbot)
    assert kept(tracking) == names(tracking) == ["with the coat"]
    assert not tracking.features.track.keeper.removed
    assert len(tracking.context.session.runs.entries[0].frames) == 8
    assert same_run(tracking.context.session.runs.entries[0].run(), entry.run())


def test_what_is_done_to_a_run_while_it_is_being_kept_holds(tracking, qtbot, monkeypatch):
    begun, go = threading.Event(), threading.Event()

    def slowly(name, run):
        begun.set()
        assert go.wait(300)
        return keep_run(name, run)

    monkeypatch.setattr(keeper.project_runs, "keep_run", slowly)
    entry = finished(tracking, "run")
    qtbot.waitUntil(begun.is_set)
    assert entry.kept == "", "the project does not have it yet"
    tracking.features.track.keeper.rename(entry, "with the coat")
    other = finished(tracking, "another")
    go.set()
    settle(tracking, qtbot)
    assert tracking.context.session.runs.entries == (entry, other)
    assert (names(tracking), kept(tracking)) == (["with the coat", "another"],) * 2


def test_a_name_that_another_run_has_is_refused(tracking, qtbot):
    finished(tracking, "one")
    finished(tracking, "two")
    settle(tracking, qtbot)
    tracking.features.track.panel.tree.topLevelItem(1).setText(0, "one")
    settle(tracking, qtbot)
    assert names(tracking) == ["one", "two"]
    assert tracking.features.track.panel.tree.topLevelItem(1).text(0) == "two"


def test_trials_and_files_are_kept_only_when_that_is_asked_for(tracking, qtbot):
    opened = add_run(tracking, "from a file")
    trial = finished(tracking, "trial")
    trial.kind = "trial"
    settle(tracking, qtbot)
    assert kept(tracking) == []
    tracking.context.session.runs.activate(opened)
    tracking.features.track.with_active(tracking.features.track.keeper.keep)
    settle(tracking, qtbot)
    assert kept(tracking) == ["from a file"]
    assert tracking.features.track.why_not_keep() == "The run is already stored in the project."
    trial.kind = "run"
    tracking.context.session.runs.tell(Part.RUNS)
    settle(tracking, qtbot)
    assert kept(tracking) == ["from a file", "trial"]


def test_a_run_that_ends_when_the_window_closes_is_kept(tracking, qtbot):
    finished(tracking, "last")
    path = tracking.context.session.project.path
    tracking.context.session.document.close()
    from stereotrack_core.project.project import Project

    with Project.open(path, read_only=True) as project:
        assert [one.name for one in kept_runs(project.runs)] == ["last"]


def test_a_run_in_progress_ends_with_its_recording_and_is_kept(tracking, qtbot):
    """Whatever opens another recording: its frames would be followed and its clouds be kept."""
    session = tracking.context.session
    track_quickly(tracking)
    session.track.step()
    qtbot.waitUntil(lambda: session.track.paused and len(session.track.entry.frames) == 1)
    session.project.open_file(session.project.path)
    qtbot.waitUntil(lambda: session.document.opening)
    settle(tracking, qtbot)
    assert session.track.entry is None
    (entry,) = session.runs.entries
    assert (entry.kept, sorted(entry.frames)) == (kept(tracking)[0], [0])


def test_runs_are_drawn_over_each_other_and_told_apart(tracking, qtbot):
    for name, off in (("a", 0.3), ("b", 0.6), ("c", 0.0)):
        finished(tracking, name, off=off)
    settle(tracking, qtbot)
    told = tracking.context.session.instant.told
    assert [ghost.style for ghost in told.ghosts] == ["dash", "dot"]
    view = tracking.context.docks.views.tiles["N"].camera
    overlay = view.picture.overlay
    assert [style for style, _ in overlay.ghosts] == ["dash", "dot"]
    with_others = view.grab().toImage()
    content = tracking.context.docks.scene.content
    assert [ghost.style for ghost in content.ghosts] == ["dash", "dot"]
    tracking.features.view.toggle_overlay("others")
    settle(tracking, qtbot)
    assert view.picture.overlay.ghosts == ()
    assert view.grab().toImage() != with_others
    tracking.features.view.toggle_overlay("others")
    styles = {(curve.name, curve.style) for curve in tracking.features.review.plot.plot._curves}
    assert styles == {("c", "solid"), ("a", "dash"), ("b", "dot")}
