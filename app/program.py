"""The application around the window: log, failures, garbage, theme, pictures."""

from __future__ import annotations

import signal
from argparse import Namespace
from pathlib import Path

from PySide6.QtCore import QEventLoop, QSettings, QTimer
from PySide6.QtWidgets import QApplication

from stereotrack_core.cli.arguments import settings_of
from stereotrack_core.cli.error_tables import error_table, segment_table
from stereotrack_core.cli.output import put_table, say
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.evaluation.summary import summarise, summarise_segments

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

    DEMO_FRAME = 60

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
        self._demo_frame: int | None = None
        self._in_picture = False

    def run(self) -> int:
        """Show the window until it is closed."""
        # Python sees Ctrl-C only when it runs, so let it run now and then
        signal.signal(signal.SIGINT, lambda *_: self.window.close())
        awake = QTimer(self.app, interval=200)
        awake.timeout.connect(lambda: None)
        awake.start()
        self.window.show()
        try:
            return self.app.exec()
        finally:
            wait_for_threads(_LAST_THREADS_S)
            self._relay.remove()

    def track_demo(self, args: Namespace) -> None:
        """Make the demo recording, track it in the window, print its errors when done."""
        track = self.window.track
        track.preset, track.settings = args.preset, settings_of(args.preset, args.changes)
        self.window.follower.show_settings()
        track.finished.connect(self._on_demo_tracked)
        self._demo_frame = self.DEMO_FRAME
        self.window.follower.change_display(keep_person=True)
        self.window.files.begin_demo(args.folder)

    def picture(self, path: Path, size: tuple[int, int] = (1600, 960)) -> bool:
        """Save the window as a picture when everything that was asked for is painted."""
        window = self.window
        window.resize(*size)
        window.show()
        settled = self._wait_until_settled()
        if self._demo_frame is not None:
            window.document.go_to(self._demo_frame)
            settled = self._wait_until_settled() and settled
        window.statusBar().clearMessage()
        saved = self._write_picture(path)
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

    def _write_picture(self, path: Path) -> bool:
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
        """Print what ``demo --headless`` prints, and keep the run beside the recording."""
        self.window.track.finished.disconnect(self._on_demo_tracked)
        recording, place = self.window.document.recording, self.window.files.demo_run
        if recording is None or recording.reference is None or not entry.frames:
            return
        last = max(entry.frames) + 1
        errors = errors_against(entry.trajectory(), recording.reference).between(0, last)
        title = f"Demo recording, preset {entry.preset}, {len(entry.frames)} frames"
        put_table(error_table(summarise(errors), title, entry.frames_per_second()))
        put_table(segment_table(summarise_segments(errors, recording.segments)))
        complete = len(entry.frames) == len(entry.wanted)
        if place is not None and (complete or not place.exists()):
            self.window.files.save_run(entry, place)
            say(f"The run is in {place}.")


def stored_theme(settings: QSettings) -> ThemeName:
    """The theme that was chosen last time."""
    stored = settings.value("theme")
    return next((name for name in THEME_NAMES if name == stored), "system")
