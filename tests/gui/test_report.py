"""The report on the active run, made from the window."""

import pytest

from app.pdf import page_picture
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


@pytest.mark.parametrize("name", ["page.html", "page.pdf"])
def test_the_report_is_made_in_the_background(with_run, qtbot, tmp_path, name):
    path = tmp_path / name
    with_run.features.reports.make(path)
    assert with_run.features.reports.working
    qtbot.waitUntil(lambda: not with_run.features.reports.working, timeout=120_000)
    assert path.is_file()
    message = with_run.messages.message
    assert message is not None
    assert str(path) in message.sentence()
    assert message.button == "Open"
    if name.endswith("html"):
        text = path.read_text("utf-8")
        assert "Report on short one" in text
        assert "Mean errors" in text


def test_a_page_of_a_report_can_be_had_as_a_picture(qapp):
    html = "<h1>Report</h1><p style='page-break-before: always'>second</p>"
    first, larger = page_picture(html, 0), page_picture(html, 1, "run", 2.0)
    assert larger.width() == 2 * first.width()
    assert first.pixelColor(2, 2).lightness() == 255  # the margin
    inked = {first.pixelColor(x, y).lightness() for x in range(60, 300, 2) for y in range(60, 110)}
    assert min(inked) < 100
    with pytest.raises(IndexError, match="page 2 of 2"):
        page_picture(html, 2)
