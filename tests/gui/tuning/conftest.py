"""A window with a short stored run, so that trials have something to begin with."""

from dataclasses import replace

import pytest

from app.session.runs import entry_of_run
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

QUICK = {
    "fit_shape": False,
    "search_arms": False,
    "data_points": 300,
    "iterations": 3,
    "colour_weight": 0.0,
    "silhouettes": False,
    "subpixel": "matcher",
    "halo_trim": "none",
    "measure_silhouettes": False,
}


@pytest.fixture(scope="session")
def quick_run_file(small_recording, tmp_path_factory):
    """File of a run over the small recording with settings that cost little."""
    settings = preset("fast").replaced(**QUICK)
    run = track(
        open_recording(small_recording), RunSpec(settings, init="tpose", preset="fast", seed=2)
    )
    path = tmp_path_factory.mktemp("run") / "quick.npz"
    write_run(path, run)
    return path


@pytest.fixture
def tuning(opened, qtbot, quick_run_file):
    """The window in the workspace Tune, with that run and its settings."""
    opened.context.session.runs.add(entry_of_run(read_run(quick_run_file), quick_run_file))
    tracker, quick = opened.context.session.track, preset("fast").replaced(**QUICK)
    tracker.put(replace(tracker.chosen, settings=quick))
    opened.context.docks.show_named("tune")
    trials = opened.context.session.trials
    trials.loops = False  # views that play are never settled for long on a busy machine
    qtbot.waitUntil(opened.context.tasks.settled, timeout=60_000)
    yield opened
    trials.loops = True
