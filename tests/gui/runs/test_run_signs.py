"""What a run's own signs say when it ends in the window."""

from __future__ import annotations

import pytest

from stereotrack_core.project.runs import kept_runs, load_run
from stereotrack_core.tracking import run_checks
from stereotrack_core.tracking.presets import preset

pytestmark = pytest.mark.window


def tracked(window, qtbot, **changes):
    """Messages of a run over two frames."""
    said = []
    window.context.session.track.message.connect(said.append)
    window.context.session.track.choose("fast", preset("fast").replaced(**changes))
    window.context.view_state.select(range(2))
    window.context.session.tracker.run_selection()
    qtbot.waitUntil(lambda: window.context.session.track.entry is None)
    qtbot.waitUntil(window.context.tasks.settled)
    return said


def test_where_nobody_is_tracked_the_step_is_named(opened, qtbot):
    [message] = tracked(opened, qtbot, volume_centre_x=40.0)
    assert message.severity == "warning"
    assert "no frame of the run has a tracked person" in message.what
    assert "volume_centre_x" in message.remedy


def test_a_run_in_which_nothing_fits_is_said_and_kept_with_it(opened, qtbot, monkeypatch):
    assert tracked(opened, qtbot) == []
    monkeypatch.setattr(run_checks, "MOST_UNEXPLAINED", 0.0)
    [message] = tracked(opened, qtbot)
    assert message.severity == "warning"
    assert "is not explained by the body" in message.what
    assert "info --deep" in message.remedy
    runs = opened.context.session.project.project.runs
    first, second = (load_run(runs, kept.name).meta["warnings"] for kept in kept_runs(runs))
    assert first == []
    assert second == [message.what]
