"""What a person does with a recording, its project and the tracker, without a window."""

import os
import shutil
import signal
import sys

import pytest

from app.session.changes import Part
from app.session.jobs import Job
from app.session.tracking import Chosen
from stereotrack_core.project.project import Project
from stereotrack_core.tracking.presets import preset
from tests.session.conftest import FRAMES
from tests.session.plain_loop import PATIENCE_S

LESS = {"fit_shape": False, "iterations": 1, "second_look": 0, "least_focal": 0.0}


@pytest.fixture
def opened(shown, small_recording):
    shown.session.open(small_recording)
    shown.until(shown.tasks.settled)
    assert shown.messages == []
    return shown


def test_a_recording_opens_with_its_project_and_is_closed_again(opened, small_recording, tmp_path):
    session = opened.session
    assert session.document.frame_count == FRAMES
    assert session.document.frame_set.index == 0
    assert session.project.path.parent == tmp_path / "projects"
    assert session.no_edit() == ""
    assert session.recents() == [small_recording]
    session.document.close()
    assert session.project.project is None
    assert session.no_edit() == "No recording is open. Open one first."


def test_a_recording_that_was_read_when_another_one_was_asked_for_is_not_opened(
    shown, small_recording, tmp_path
):
    opened, document = [], shown.session.document
    shown.session.changes.watch(
        Part.RECORDING_OPENED, lambda: opened.append(document.recording.folder)
    )
    shown.session.open(shutil.copytree(small_recording, tmp_path / "other"))
    (task,) = shown.tasks.tasks
    assert task.join(PATIENCE_S)
    shown.session.open(small_recording)
    shown.until(shown.tasks.settled)
    assert opened == [small_recording]


def test_of_a_folder_that_nobody_waits_for_nothing_is_said(shown, small_recording, tmp_path):
    shown.session.open(tmp_path / "nowhere")
    shown.session.open(small_recording)
    shown.until(shown.tasks.settled)
    assert shown.session.document.recording.folder == small_recording
    assert shown.messages == []


def test_what_is_open_stays_until_all_that_is_written_to_it_is_there(opened, small_recording):
    session, written = opened.session, []
    project = session.project.project
    opened.tasks.write(Job("editing", lambda _: written.append(project.path.exists())))
    session.open(small_recording, frame=3)
    opened.until(lambda: session.project.project not in (None, project))
    assert written == [True]
    assert session.document.frame == 3


def test_a_project_that_is_in_use_opens_for_reading(shown, small_recording, tmp_path):
    path = tmp_path / "mine.stereotrack"
    with Project.create(path, small_recording, who="A"):
        shown.session.open(path)
        shown.until(shown.tasks.settled)
        assert shown.session.project.in_use
        shown.until(lambda: bool(shown.messages))
    assert "read-only" in shown.messages[0].remedy


def test_playing_shows_each_frame_in_its_time_and_stops_at_the_end(opened):
    document, frames = opened.session.document, []
    opened.session.changes.watch(Part.FRAME, lambda: frames.append(document.frame))
    document.play()
    assert document.playing
    opened.until(lambda: not document.playing)
    assert frames == sorted(frames)
    assert frames[-1] == FRAMES - 1
    document.loop = range(2, 4)
    document.play()
    opened.until(lambda: frames.count(2) > 1)
    document.pause()


def test_settings_are_undone_and_a_run_is_tracked_shown_and_judged(opened):
    session = opened.session
    fast = preset("fast").replaced(**LESS)
    session.track.take(Chosen("fast", fast, fast), "use fast")
    session.edits.undo()
    assert session.track.preset == "accurate"
    session.edits.redo()
    assert session.track.settings == fast
    session.track.first_pose = "tpose"
    session.track.step()
    opened.until(lambda: session.track.paused and bool(session.runs.active.frames))
    entry = session.runs.active
    assert list(entry.frames) == [0]
    session.track.run()
    opened.until(lambda: session.track.live is None)
    opened.until(opened.tasks.settled)
    assert list(entry.frames) == list(range(FRAMES))
    assert session.document.frame == FRAMES - 1, "the views follow the tracker"
    assert session.judging.of(entry).measure == "error", "the recording has a reference"
    session.track.run_from_here()
    session.track.stop()
    assert session.runs.entries == (entry,), "a run without a frame is no run"


@pytest.fixture
def stepped(opened):
    """One frame is tracked, and the tracker waits."""
    track = opened.session.track
    track.choose("fast", preset("fast").replaced(**LESS))
    track.first_pose = "tpose"
    track.step()
    opened.until(lambda: track.paused and bool(track.entry.frames))
    return opened


def test_changed_settings_apply_to_the_next_step_as_a_new_run(stepped):
    track = stepped.session.track
    first = track.entry
    track.use(track.settings.replaced(iterations=2))
    track.step()
    stepped.until(lambda: track.entry is not first and bool(track.entry.frames))
    assert (list(first.frames), list(track.entry.frames)) == ([0], [1])
    assert track.entry.settings.tracking.iterations == 2


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such signal")
def test_a_process_that_is_killed_leaves_what_was_tracked_and_a_sentence(stepped):
    track, run = stepped.session.track, stepped.session.track.entry
    os.kill(stepped.session.processes.run.pid, signal.SIGKILL)
    stepped.until(lambda: track.entry is None)
    assert list(run.frames) == [0]
    (said,) = (one for one in stepped.messages if one.severity == "error")
    assert "ended unexpectedly" in said.what
    assert "frames tracked so far are kept" in said.remedy
    stepped.state.select(range(2, 5))
    track.run_selection()
    stepped.until(lambda: track.entry is None)
    assert list(stepped.session.runs.active.frames) == [2, 3, 4]
