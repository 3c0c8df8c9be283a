"""The report on the active run, made from the window."""

import pytest

from app.presenters.runs import entry_of_run
from stereotrack_core.tracking.pipeline import track
from stereotrack_core.tracking.presets import preset

pytestmark = pytest.mark.window


@pytest.fixture
def with_run(opened, tmp_path):
    recording = opened.document.recording
    run = track(recording, preset("thesis"), frames=range(6), init="tpose", preset="thesis")
    opened.runs.add(entry_of_run(run, tmp_path / "short one.npz"))
    return opened


def test_there_is_nothing_to_report_without_a_run(opened):
    action = opened.actions_book.action("report")
    opened.refresh()
    assert not action.isEnabled()


@pytest.mark.parametrize("name", ["page.html", "page.pdf"])
def test_the_report_is_made_in_the_background(with_run, qtbot, tmp_path, name):
    path = tmp_path / name
    with_run.files.reports.make(path)
    assert with_run.files.reports.working
    qtbot.waitUntil(lambda: not with_run.files.reports.working, timeout=120_000)
    assert path.is_file()
    message = with_run.messages.message
    assert message is not None
    assert str(path) in message.sentence()
    assert message.button == "Show it"
    if name.endswith("html"):
        text = path.read_text("utf-8")
        assert "Report on short one" in text
        assert "Mean errors" in text
