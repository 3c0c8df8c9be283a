"""A recording that is plainly wrong is not tracked unasked; its images are checked on request."""

import shutil
from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

from stereotrack_core.doctor import correcting
from stereotrack_core.doctor.diagnose import glance
from stereotrack_core.recording.folder import open_recording as open_folder
from tests.gui.hands import trigger
from tests.gui.kept_window import open_recording

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def exchanged(small_recording, tmp_path_factory):
    """The small recording with the images of view N exchanged."""
    folder = tmp_path_factory.mktemp("exchanged") / "small"
    shutil.copytree(small_recording, folder)
    for end in (".mp4", "_background.png"):
        left, right = folder / f"N_left{end}", folder / f"N_right{end}"
        aside = left.rename(folder / f"aside{end}")
        right.rename(left)
        aside.rename(right)
    return folder


@pytest.fixture
def wrong(window, qtbot, exchanged):
    """A window of its own with the recording that is plainly wrong."""
    open_recording(window, qtbot, exchanged)
    qtbot.waitUntil(window.context.tasks.settled)
    return window


def errors(window):
    found = window.context.session.document.findings
    return [one.where for one in found if one.severity == "error"]


def test_what_is_plainly_wrong_is_tracked_only_if_it_is_wanted(wrong, qtbot):
    assert errors(wrong) == ["view N"]  # by a glance at the images
    session = wrong.context.session
    trigger(wrong, "run")
    assert session.track.entry is None
    message = wrong.messages._messages[0]
    assert message.where == "view N"
    assert "would not be tracked correctly" in message.what
    assert "swap the files of left and right" in message.remedy
    assert wrong.messages.do_button.text() == "Track nevertheless"
    button = wrong.messages.do_button
    qtbot.waitUntil(lambda: not button.visibleRegion().isEmpty())
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert session.track.entry is not None


def pressed(qtbot, button):
    qtbot.waitUntil(lambda: not button.visibleRegion().isEmpty())
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def test_the_button_of_a_finding_corrects_its_file(window, qtbot, exchanged, tmp_path, monkeypatch):
    folder = shutil.copytree(exchanged, tmp_path / "small")
    open_recording(window, qtbot, folder)
    qtbot.waitUntil(window.context.tasks.settled)
    window.context.docks.show_named("calibrate")
    window.context.docks.bring_up("findings")
    calibrate = window.features.calibrate
    # by this process, and by a glance: how long either takes is not what is asked here
    monkeypatch.setattr(correcting, "diagnose", lambda recording, _: glance(recording))
    monkeypatch.setattr(
        calibrate.checks, "_process", lambda work, hear, *_, **__: work(SimpleNamespace(tell=hear))
    )
    [button] = [one for one in calibrate.findings.tree.findChildren(QToolButton) if one.text()]
    assert button.text() == "Correct …"
    pressed(qtbot, button)
    message = window.messages.message
    assert "recording.toml: Exchange the files of left and right in view N" in message.sentence()
    assert not (folder / "recording-before-1.toml").exists()
    pressed(qtbot, window.messages.do_button)
    assert calibrate.checks.job.busy
    qtbot.waitUntil(lambda: not calibrate.checks.job.busy)
    qtbot.waitUntil(window.context.tasks.settled)
    assert (folder / "recording-before-1.toml").exists()
    assert open_folder(folder).view("N").left.frames == "N_right.mp4"
    assert not errors(window)
    told = [one.sentence() for one in window.messages._messages]
    assert any("recording.toml was corrected" in one for one in told)


@pytest.mark.slow
def test_the_button_beside_the_verdict_measures_the_images(opened, qtbot):
    opened.context.docks.show_named("calibrate")
    findings = opened.features.calibrate.findings
    [button] = findings.findChildren(QToolButton)
    assert button.text() == "Check thoroughly"
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert opened.features.calibrate.checks.job.busy
    assert not opened.context.actions.action("check_thoroughly").isEnabled()
    qtbot.waitUntil(opened.context.tasks.settled)
    assert opened.context.session.document._measured is not None
    assert not errors(opened)
    assert "sable" in findings.verdict.text()
