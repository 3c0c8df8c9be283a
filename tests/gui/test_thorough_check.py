"""A recording that is plainly wrong is not tracked unasked; its images are checked on request."""

from __future__ import annotations

import shutil

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

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
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    return window


def errors(window):
    found = window.context.session.document.findings
    return [one.where for one in found if one.severity == "error"]


def test_what_is_plainly_wrong_is_tracked_only_if_it_is_wanted(wrong, qtbot):
    assert errors(wrong) == ["view N"]  # by a glance at the images
    session = wrong.context.session
    wrong.context.actions.action("run").trigger()
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


@pytest.mark.slow
def test_the_button_beside_the_verdict_measures_the_images(opened, qtbot):
    opened.context.docks.show_named("calibrate")
    findings = opened.features.calibrate.findings
    [button] = findings.findChildren(QToolButton)
    assert button.text() == "Check thoroughly"
    assert button.isEnabled(), button.toolTip()
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert opened.features.calibrate.thorough.running
    assert not opened.context.actions.action("check_thoroughly").isEnabled()
    qtbot.waitUntil(opened.context.tasks.settled, timeout=120_000)
    assert opened.context.session.document._measured is not None
    assert not errors(opened)
    assert "sable" in findings.verdict.text()
