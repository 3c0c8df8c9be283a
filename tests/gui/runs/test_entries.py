"""What a run of the list holds."""

from __future__ import annotations

from pathlib import Path

from app.session.runs import entry_of_run
from stereotrack_core.recording.folder import open_recording
from tests.gui.made_runs import made_run


def test_what_work_is_given_of_a_run_does_not_change_with_it(small_recording):
    run = made_run(open_recording(small_recording))
    entry = entry_of_run(run, Path("run.npz"))
    now, first = entry.now(), entry.frames[0]
    del entry.frames[0]
    entry.stored = None
    assert [frame.frame for frame in now.frames] == list(range(8))
    assert now.frames[0] is first
    assert now.run() is run
    assert len(entry.now().frames) == 7
    assert entry.run() is None
