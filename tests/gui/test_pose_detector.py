"""Installing the pose detector from the window."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox

from tests.gui.hands import trigger
from tests.gui.seen_texts import faults_of
from tests.pose_model.small_files import CONTENTS, use_small_files, wheel

pytestmark = pytest.mark.window


@pytest.fixture
def folder(tmp_path, monkeypatch):
    return use_small_files(monkeypatch, tmp_path / "kept")


@pytest.fixture
def install(window, folder, qtbot, monkeypatch):
    """Function that installs a file from the menu of a window without a recording."""

    def made(path):
        monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_, **__: (str(path), ""))
        trigger(window, "install_detector")
        qtbot.waitUntil(lambda: bool(QApplication.activeModalWidget()))
        box = QApplication.activeModalWidget()
        assert isinstance(box, QMessageBox)
        assert faults_of(box) == []
        words = box.informativeText()
        button = next(one for one in box.buttons() if one.text() == "From file …")
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(lambda: not window.features.detector.job.busy)
        return words

    return made


def test_it_is_installed_from_a_wheel_in_the_background(window, install, folder, tmp_path):
    words = install(wheel(tmp_path / "mediapipe.whl"))
    assert words.endswith("The pose detector is not installed.")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == CONTENTS
    assert f"installed in {folder}" in window.messages.message.sentence()
    assert f"installed in {folder}" in install(tmp_path / "mediapipe.whl")


def test_another_file_is_refused_in_words(window, install, folder, tmp_path):
    wrong = {name: content[::-1] for name, content in CONTENTS.items()}
    install(wheel(tmp_path / "mediapipe.whl", wrong))
    assert "is not the known file" in window.messages.text()
    assert "Nothing was installed" in window.messages.text()
    assert not folder.exists()
