"""A run that was under way when the window was killed is there when it is opened again."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.interop.run_file import read_run
from stereotrack_core.project.runs import kept_runs, load_run, place_for_run, unfinished_runs
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from tests.gui.conftest import FRAMES
from tests.gui.kept_window import open_recording

pytestmark = [
    pytest.mark.window,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no SIGKILL here"),
]

PROGRAM = Path(__file__).parents[1] / "tracking_process.py"
HELD = 2
NAME = f"fast, interrupted at frame {HELD - 1}"


@pytest.fixture
def killed(small_recording, tmp_path) -> Path:
    """The project of a window that was killed while it tracked."""
    folder = tmp_path / "projects"
    folder.mkdir()
    root = PROGRAM.parents[2]
    process = subprocess.Popen(
        [sys.executable, str(PROGRAM), str(small_recording), str(folder), str(HELD)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
    )
    assert process.stdout.readline() == "held\n"
    workers = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    workers = workers.read_text().split() if workers.exists() else []
    process.kill()
    process.communicate()
    while any(Path(f"/proc/{worker}").exists() for worker in workers):
        time.sleep(0.01)  # whoever tracks notices that the window is gone
    assert process.returncode == -signal.SIGKILL
    [project] = folder.glob("*.stereotrack")
    [part] = unfinished_runs(project)
    assert read_run(part).frame.tolist() == list(range(HELD))
    return project


def opened(window, qtbot, recording):
    said = []
    window.messages.show_message = said.append
    open_recording(window, qtbot, recording)
    return said


def test_it_is_found_kept_and_said_once(killed, window, qtbot, small_recording):
    said = opened(window, qtbot, small_recording)
    [message] = [one for one in said if one.where == NAME]
    assert (message.severity, message.where) == ("note", NAME)
    assert window.context.session.project.path == killed
    [kept] = kept_runs(window.context.session.project.project.runs)
    assert (kept.name, kept.facts.frames) == (NAME, HELD)
    assert [entry.name for entry in window.context.session.runs.entries] == [NAME]
    done = iter(range(1, FRAMES))
    settings = preset("fast").replaced(fit_shape=False)
    recording = window.context.session.document.recording
    spec = RunSpec(settings, preset="fast", init="tpose")
    alone = track(recording, spec, hooks=Hooks(cancelled=lambda: next(done) == HELD))
    run = load_run(window.context.session.project.project.runs, NAME)
    np.testing.assert_array_equal(run.x, alone.x)
    assert unfinished_runs(killed) == ()
    window.context.session.document.close()
    again = opened(window, qtbot, small_recording)
    assert NAME not in [one.where for one in again]
    assert len(kept_runs(window.context.session.project.project.runs)) == 1


def test_a_run_that_ends_leaves_no_file(window, qtbot, small_recording):
    opened(window, qtbot, small_recording)
    window.context.session.track.choose("fast", preset("fast").replaced(fit_shape=False))
    window.context.session.track.first_pose = "tpose"
    place = place_for_run(window.context.session.project.path)
    window.context.view_state.select(range(2))
    window.context.session.track.run_selection()
    qtbot.waitUntil(lambda: window.context.session.track.entry is None)
    qtbot.waitUntil(window.context.tasks.settled)
    [kept] = kept_runs(window.context.session.project.project.runs)
    assert kept.facts.frames == 2
    assert not place.exists()


def test_a_file_that_is_damaged_stays_and_is_said(window, qtbot, small_recording):
    opened(window, qtbot, small_recording)
    project = window.context.session.project.path
    window.context.session.document.close()
    part = place_for_run(project)
    part.write_bytes(b"something else")
    assert unfinished_runs(project) == (part,)
    said = opened(window, qtbot, small_recording)
    assert [one.severity for one in said if one.where == str(part)] == ["error"]
    assert part.read_bytes() == b"something else"
    assert kept_runs(window.context.session.project.project.runs) == ()
