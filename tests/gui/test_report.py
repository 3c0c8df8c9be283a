"""The report on the active run, made from the window."""

import pytest

from app.session.runs import entry_of_run
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

pytestmark = pytest.mark.window


@pytest.fixture
def with_run(opened, tmp_path):
    recording = opened.context.session.document.recording
    run = track(
        recording, RunSpec(preset("thesis"), frames=range(6), init="tpose", preset="thesis")
    )
    opened.context.session.runs.add(entry_of_run(run, tmp_path / "short one.npz"))
    return opened


def test_the_report_is_made_in_the_background(with_run, qtbot, tmp_path):
    path = tmp_path / "page.html"
    with_run.features.files.reports.make(path)
    assert with_run.features.files.reports.job.busy
    qtbot.waitUntil(lambda: not with_run.features.files.reports.job.busy)
    assert path.is_file()
    message = with_run.messages.message
    assert message is not None
    assert str(path) in message.sentence()
    assert message.button == "Open"
    text = path.read_text("utf-8")
    assert "Report on short one" in text
    assert "Mean errors" in text
