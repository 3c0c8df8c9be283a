"""A window in a process of its own, which is killed; what a test has it do goes on until then."""

import os
import time
from collections.abc import Callable
from pathlib import Path

os.environ["QT_QPA_PLATFORM"] = "offscreen"

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QApplication

from app.shell.main_window import MainWindow
from app.widgets.style.theme import apply_theme
from tests.gui.hands import window_with


def until(app: QApplication, condition: Callable[[], bool]) -> None:
    """Wait, however long it takes: whoever has started this ends it."""
    while not condition():
        app.processEvents()
        time.sleep(0.001)


def window_on(
    recording: Path, folder: Path, workspace: str = ""
) -> tuple[QApplication, MainWindow]:
    """A window that shows a recording, with its project in a folder."""
    app = QApplication(["window"])
    apply_theme(app, "dark")
    settings = QSettings(str(folder / "settings.ini"), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(folder))
    settings.setValue("workspace", workspace)
    window = window_with(settings)
    window.show()
    session = window.context.session
    session.open(recording)
    until(app, lambda: session.document.frame_set is not None and not session.project.why_no_edit())
    return app, window
