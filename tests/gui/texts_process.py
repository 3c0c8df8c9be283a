"""A window whose workspaces, panels and dialogs are all looked at; says what is cut off in them.

It is given a theme and a recording; Qt is told by its environment how large a pixel is.
"""

import os
import sys
import tempfile
from pathlib import Path

os.environ["QT_QPA_PLATFORM"] = "offscreen"

from PySide6.QtCore import QSettings
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.widgets.style.theme import ThemeName, apply_theme
from tests.gui.hands import window_with
from tests.gui.made_runs import add_run
from tests.gui.seen_texts import faults_of
from tests.gui.walking import Walk, Watch

WIDTH, HEIGHT = 1366, 768
LASTING = frozenset({"quit", "demo", "close", "run", "step", "run_here", "recent_1"})
"""Commands that end the window, or do work that opens no dialog."""


def look(theme: ThemeName, recording: Path, folder: Path) -> list[str]:
    """Look at all of it; what is wrong."""
    app = QApplication(["texts"])
    apply_theme(app, theme)
    settings = QSettings(str(folder / "settings.ini"), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(folder))
    window = window_with(settings)
    window.resize(WIDTH, HEIGHT)
    window.show()
    with Watch() as watch:
        walk = Walk(window, watch, lambda: None)

        def see(name: str) -> None:
            walk.settle()
            QTest.qWait(50)
            watch.now = name
            for fault in faults_of(window):
                watch.note(fault)
            if (window.width(), window.height()) != (WIDTH, HEIGHT):
                watch.note(f"the window has grown to {window.width()} x {window.height()}")

        see("welcome")
        session, docks = window.context.session, window.context.docks
        session.open(recording)
        while session.document.frame_set is None:
            QTest.qWait(20)
        for runs in ("no runs", "runs"):
            if runs == "runs":
                add_run(window, "good", off=0.05)
                add_run(window, "bad, iterations 3", off=0.3)
            for space in docks.workspaces:
                docks.show_named(space.name)
                see(f"{space.name}, {runs}")
                for name, title in docks.titles().items():
                    if docks.dock(name).isVisible():
                        docks.dock(name).raise_()
                        see(f"{space.name}, {runs}, {title}")
        walk.commands(LASTING)
        window.close()
    return watch.wrong


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        wrong = look(sys.argv[1], Path(sys.argv[2]), Path(made))
    sys.stdout.write("".join(f"{one}\n" for one in dict.fromkeys(wrong)))
    sys.stdout.flush()
    os._exit(0)  # whatever still works in the background
