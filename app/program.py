"""The application around the window: log, failures, garbage, theme, pictures."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QEventLoop, QSettings, QTimer
from PySide6.QtWidgets import QApplication

from stereotrack_core.errors import InputError
from stereotrack_core.window import DemoTracking

from .services.failures import FailureRelay, leave_out_noise, open_log
from .services.tasks.garbage import GarbageTimer
from .services.tasks.threaded import wait_for_threads
from .session.runs import RunEntry
from .shell.main_window import MainWindow, user_settings
from .shell.picture_file import write_picture
from .widgets.style.icons import icon
from .widgets.style.theme import THEME_NAMES, ThemeName, apply_theme

_LOOK_MS = 50
_CALM_LOOKS = 4
_PATIENCE_S = 1800.0
_LAST_THREADS_S = 15.0
"""The window is gone by then; work that takes longer to notice that is left behind."""


class WindowProgram:
    """One window and what keeps it alive."""

    def __init__(self) -> None:
        existing = QApplication.instance()
        self.app = existing if isinstance(existing, QApplication) else QApplication(["stereotrack"])
        self.app.setApplicationName("stereotrack")
        self.app.setApplicationDisplayName("stereotrack")
        open_log()
        leave_out_noise()
        self._garbage = GarbageTimer(self.app)
        settings = user_settings()
        apply_theme(self.app, stored_theme(settings))
        self.window = MainWindow(settings)
        self._relay = FailureRelay()
        self._relay.install()
        self._relay.message.connect(self.window.messages.show_message)
        self.app.setWindowIcon(icon("model"))
        self._demo: tuple[DemoTracking, int] | None = None
        self._in_picture = False

    def run(self) -> bool:
        """Show the window until it is closed; whether that went well."""
        # Python sees Ctrl-C only when it runs, so let it run now and then
        signal.signal(signal.SIGINT, lambda *_: self.window.close())
        awake = QTimer(self.app, interval=200)
        awake.timeout.connect(lambda: None)
        awake.start()
        self.window.show()
        try:
            return self.app.exec() == 0
        finally:
            wait_for_threads(_LAST_THREADS_S)
            self._relay.remove()

    def track_demo(self, demo: DemoTracking, shown_frame: int) -> None:
        """Make the demo recording, track it in the window, tell its errors when done."""
        track = self.window.track
        track.preset, track.settings = demo.preset, demo.settings
        self.window.follower.show_settings()
        track.finished.connect(self._on_demo_tracked)
        self._demo = demo, shown_frame
        self.window.files.begin_demo(demo.folder)

    def picture(
        self, path: Path, say: Callable[[str], None], size: tuple[int, int] = (1600, 960)
    ) -> bool:
        """Save the window as a picture when everything that was asked for is painted."""
        window = self.window
        window.resize(*size)
        window.show()
        settled = self._wait_until_settled()
        if self._demo is not None:
            window.document.go_to(self._demo[1])
            settled = self._wait_until_settled() and settled
        window.statusBar().clearMessage()
        saved = self._write_picture(path, say)
        if not settled:
            say("Not everything was ready in time; the picture shows what was.")
        message = window.messages.message
        failed = message is not None and message.severity == "error"
        if message is not None and failed:
            say(message.sentence())
        window.close()
        wait_for_threads(_LAST_THREADS_S)
        self._relay.remove()
        return saved and settled and not failed

    def _write_picture(self, path: Path, say: Callable[[str], None]) -> bool:
        try:
            write_picture(path, self.window.grab())
        except InputError as error:
            say(f"stereotrack: {error}")
            return False
        return True

    def _wait_until_settled(self) -> bool:
        """Let events happen until nothing is under way for a few looks."""
        loop = QEventLoop()
        calm, waited = 0, 0.0
        while calm < _CALM_LOOKS and waited < _PATIENCE_S:
            QTimer.singleShot(_LOOK_MS, loop.quit)
            loop.exec()
            waited += _LOOK_MS / 1000.0
            done = self.window.settled() and self.window.scene.at_rest()
            calm = calm + 1 if done else 0
        return calm >= _CALM_LOOKS

    def _on_demo_tracked(self, entry: RunEntry) -> None:
        """Keep the run beside the recording, and tell what came out."""
        self.window.track.finished.disconnect(self._on_demo_tracked)
        recording, place = self.window.document.recording, self.window.files.demo_run
        if self._demo is None or recording is None or not entry.frames:
            return
        complete = len(entry.frames) == len(entry.wanted)
        saved = place if complete or (place is not None and not place.exists()) else None
        if saved is not None:
            self.window.files.save_run(entry, saved)
        demo, _ = self._demo
        demo.on_tracked(recording, entry.trajectory(), entry.frames_per_second(), saved)


def stored_theme(settings: QSettings) -> ThemeName:
    """The theme that was chosen last time."""
    stored = settings.value("theme")
    return next((name for name in THEME_NAMES if name == stored), "system")
