"""A window that tracks so many frames of a recording, and says so; then it waits to be killed.

It is given a recording, a folder for its project, and the number of frames.
"""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

os.environ["QT_QPA_PLATFORM"] = "offscreen"

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QApplication

from app.widgets.style.theme import apply_theme
from stereotrack_core.tracking.presets import preset
from tests.gui.hands import window_with


def until(app: QApplication, condition: Callable[[], bool]) -> None:
    """Wait, however long it takes: whoever has started this ends it."""
    while not condition():
        app.processEvents()
        time.sleep(0.001)


def track(recording: Path, folder: Path, frames: int) -> None:
    app = QApplication(["tracking"])
    apply_theme(app, "dark")
    settings = QSettings(str(folder / "settings.ini"), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(folder))
    window = window_with(settings)
    window.show()
    window.context.session.open(recording)
    until(
        app,
        lambda: (
            window.context.session.document.frame_set is not None
            and not window.context.session.project.why_no_edit()
        ),
    )
    window.context.session.track.choose("fast", preset("fast").replaced(fit_shape=False))
    opened, count = (
        window.context.session.document.recording,
        window.context.session.document.frame_count,
    )
    entry = window.context.session.track.begin(opened, range(count), "tpose", allowed=frames)
    until(app, lambda: len(entry.frames) == frames)
    sys.stdout.write("held\n")
    sys.stdout.flush()
    app.exec()


if __name__ == "__main__":
    track(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
