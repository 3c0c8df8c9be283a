"""Installing the pose detector from the window."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog

from app.features.detector.feature import DetectorDialog
from tests.gui.seen_texts import faults_of
from tests.pose_model.small_files import CONTENTS, use_small_files, wheel

pytestmark = pytest.mark.window


@pytest.fixture
def folder(tmp_path, monkeypatch):
    return use_small_files(monkeypatch, tmp_path / "kept")


@pytest.fixture
def dialog(window, folder, qtbot):
    """The dialog, opened from the menu of a window without a recording."""
    window.context.actions.action("install_detector").trigger()
    qtbot.waitUntil(lambda: bool(QApplication.activeModalWidget()), timeout=5_000)
    shown = QApplication.activeModalWidget()
    assert isinstance(shown, DetectorDialog)
    yield shown
    qtbot.keyClick(shown, Qt.Key.Key_Escape)


def choose(monkeypatch, path):
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_, **__: (str(path), ""))


def test_it_is_installed_from_a_wheel_in_the_background(
    window, dialog, folder, qtbot, monkeypatch, tmp_path
):
    assert faults_of(dialog) == []
    assert dialog.words.text() == "It is not installed."
    choose(monkeypatch, wheel(tmp_path / "mediapipe.whl"))
    qtbot.mouseClick(dialog.from_file, Qt.MouseButton.LeftButton)
    assert not dialog.accept_button.isEnabled()
    qtbot.waitUntil(lambda: not window.features.detector.working, timeout=30_000)
    assert dialog.words.text() == f"It is installed in {folder}."
    assert dialog.accept_button.text() == "Install again"
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == CONTENTS
    assert "The pose detector is installed" in window.messages.message.sentence()


def test_another_file_is_refused_in_words(window, dialog, folder, qtbot, monkeypatch, tmp_path):
    wrong = {name: content[::-1] for name, content in CONTENTS.items()}
    choose(monkeypatch, wheel(tmp_path / "mediapipe.whl", wrong))
    qtbot.mouseClick(dialog.from_file, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: not window.features.detector.working, timeout=30_000)
    assert "is not the known file" in dialog.words.text()
    assert "Nothing was installed" in dialog.words.text()
    assert dialog.accept_button.isEnabled()
    assert not folder.exists()
