"""The application around the window: log, failures, garbage, theme, pictures."""

import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QEventLoop, QSettings, QTimer
from PySide6.QtWidgets import QApplication

from stereotrack_core.errors import InputError
from stereotrack_core.tracking.presets import preset
from stereotrack_core.window import DemoTracking

from .context import GarbageTimer
from .features import detector as detector_feature
from .features.annotate import feature as annotate_feature
from .features.calibrate import feature as calibrate_feature
from .features.inspect import controller as inspect_feature
from .features.project import files as project_feature
from .features.review import feature as review_feature
from .features.study import controller as study_feature
from .features.track import controller as track_feature
from .features.tune import controller as tune_feature
from .features.view import feature as view_feature
from .features.view.controller import ViewController
from .services.failures import FailureRelay
from .session.changes import Part
from .session.jobs import Processes
from .session.messages import open_log
from .session.runs import RunEntry
from .session.tracking import Chosen
from .session.work_threads import wait_for_threads
from .shell.dialogs import write_picture
from .shell.main_window import MainWindow
from .widgets.style.theme import THEME_NAMES, ThemeName, apply_theme, icon_named

_LOOK_MS = 50
_CALM_LOOKS = 4
_PATIENCE_S = 1800.0
_SWITCH_S = 0.001
"""Seconds after which a thread that computes gives way to the window's. Each query and each call of
Qt waits anew, so that Python's usual 5 ms add up to what a person notices."""
_LAST_THREADS_S = 15.0
"""The window is gone by then; work that takes longer to notice that is left behind."""


@dataclass(frozen=True)
class Features:
    """What can be done in the window, in the order of its menus; each knows the context alone."""

    files: project_feature.FileController
    view: ViewController
    calibrate: calibrate_feature.CalibrateController
    annotate: annotate_feature.Annotate
    track: track_feature.RunsController
    detector: detector_feature.DetectorController
    inspect: inspect_feature.InspectController
    tune: tune_feature.TuneController
    review: review_feature.Review
    study: study_feature.StudyController


def make_window(
    settings: QSettings, processes: Processes | None = None
) -> tuple[MainWindow, Features]:
    """Make the window with all its features; see :func:`make_context`."""
    window = MainWindow(settings, processes)
    context = window.context
    features = Features(
        files=project_feature.register(context),
        view=view_feature.register(context),
        calibrate=calibrate_feature.register(context),
        annotate=annotate_feature.register(context),
        track=track_feature.register(context),
        detector=detector_feature.register(context),
        inspect=inspect_feature.register(context),
        tune=tune_feature.register(context),
        review=review_feature.register(context),
        study=study_feature.register(context),
    )
    window.draw()
    return window, features


class WindowProgram:
    """One window and what keeps it alive."""

    def __init__(self) -> None:
        existing = QApplication.instance()
        self.app = existing if isinstance(existing, QApplication) else QApplication(["stereotrack"])
        self.app.setApplicationName("stereotrack")
        self.app.setApplicationDisplayName("stereotrack")
        open_log()
        sys.setswitchinterval(_SWITCH_S)
        self._garbage = GarbageTimer(self.app)
        settings = user_settings()
        apply_theme(self.app, stored_theme(settings))
        self.window, self.features = make_window(settings)
        self.context = self.window.context
        watch = self.context.session.changes.watch
        watch(Part.RECORDING_CLOSED, self._look_at_all)
        watch(Part.WINDOW_CLOSING, self._garbage.timer.stop)
        self._relay = FailureRelay(self.window.messages.show_message)
        self.app.setWindowIcon(icon_named("model"))
        self._demo: DemoTracking | None = None
        self._demo_frame: int | None = None

    def _look_at_all(self) -> None:
        self._garbage.looks_at_all = True

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
        """Open the demo recording, track it in the window, tell its errors when done."""
        track = self.context.session.track
        track.put(Chosen(demo.preset, preset(demo.preset), demo.settings))
        self.context.session.changes.hear(Part.RUN_ENDED, self._on_demo_tracked)
        self._demo, self._demo_frame = demo, shown_frame
        self.features.files.begin_demo(demo.folder)

    def picture(
        self, path: Path, say: Callable[[str], None], size: tuple[int, int] = (1600, 960)
    ) -> bool:
        """Save the window as a picture when everything that was asked for is painted."""
        window = self.window
        window.resize(*size)
        window.show()
        settled = self._wait_until_settled()
        if self._demo_frame is not None:
            self.context.session.document.go_to(self._demo_frame)
            settled = self._wait_until_settled() and settled
        window.statusBar().clearMessage()
        saved = True
        try:
            write_picture(path, window.grab())
        except InputError as error:
            saved = False
            say(f"stereotrack: {error}")
        if not settled:
            say("Not everything was ready in time. The screenshot may be incomplete.")
        message = window.messages.message
        failed = message is not None and message.severity == "error"
        if message is not None and failed:
            say(message.sentence())
        window.asks_before_quitting = False
        window.close()
        wait_for_threads(_LAST_THREADS_S)
        self._relay.remove()
        return saved and settled and not failed

    def _wait_until_settled(self) -> bool:
        """Let events happen until nothing is under way for a few looks."""
        loop = QEventLoop()
        calm, waited = 0, 0.0
        while calm < _CALM_LOOKS and waited < _PATIENCE_S:
            QTimer.singleShot(_LOOK_MS, loop.quit)
            loop.exec()
            waited += _LOOK_MS / 1000.0
            done = self.context.tasks.settled() and self.context.docks.scene.at_rest()
            calm = calm + 1 if done else 0
        return calm >= _CALM_LOOKS

    def _on_demo_tracked(self, entry: RunEntry) -> None:
        """Keep the run beside the recording, and tell what came out."""
        session, files = self.context.session, self.features.files
        recording = session.document.recording
        place = files.demo.run if files.demo is not None else None
        demo, self._demo = self._demo, None
        if demo is None or recording is None or not entry.frames:
            return
        complete = len(entry.frames) == len(entry.wanted)
        saved = place if complete or (place is not None and not place.exists()) else None
        if saved is not None:
            files.save_run(entry, saved)
        demo.on_tracked(recording, entry.trajectory(), entry.frames_per_second(), saved)


def user_settings() -> QSettings:
    """Where layouts, shortcuts and the list of recordings are kept, apart from all data."""
    return QSettings(
        QSettings.Format.IniFormat, QSettings.Scope.UserScope, "stereotrack", "stereotrack"
    )


def stored_theme(settings: QSettings) -> ThemeName:
    """The theme that was chosen last time."""
    stored = settings.value("theme")
    return next((name for name in THEME_NAMES if name == stored), "system")
