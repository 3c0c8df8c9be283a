"""Measure the window: frame steps from key press to paint. Prints JSON.

``python benchmarks/window.py RECORDING``; without a screen, set QT_QPA_PLATFORM=offscreen.
"""

import json
import sys
import tempfile
import time
from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QCoreApplication, QEventLoop, QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.context import GarbageTimer
from app.program import make_window
from app.start import prepare
from app.widgets.style.theme import apply_theme
from benchmarks.common import ended


def frame_steps(recording: Path, frames: int, workspace: str) -> dict[str, float]:
    """Milliseconds of a step over frames that are in the cache, forth and back."""
    prepare(needs_screen=True)
    app = QApplication(["stereotrack"])
    with tempfile.TemporaryDirectory() as folder:
        settings = QSettings(str(Path(folder) / "window.ini"), QSettings.Format.IniFormat)
        settings.setValue("projects_folder", folder)
        apply_theme(app, "dark")
        garbage = GarbageTimer()
        window: Any = make_window(settings)[0]
        window.resize(1366, 768)
        document, tasks = window.context.session.document, window.context.tasks
        window.show()
        window.activateWindow()
        window.context.session.open(recording)
        _until(lambda: document.frame_set is not None and tasks.settled())
        window.context.docks.show_named(workspace)
        last = min(frames, document.frame_count - 1)
        for frame in range(last + 1):
            document.go_to(frame)
            _until(partial(_shows, window, frame))
        times, computing = [], time.thread_time()
        for key, step in ((Qt.Key.Key_Left, -1), (Qt.Key.Key_Right, 1)):
            for _ in range(last):
                begun, wanted = time.perf_counter(), document.frame + step
                QTest.keyClick(window, key)
                _until(partial(_shows, window, wanted))
                times.append(1000.0 * (time.perf_counter() - begun))
        computing = 1000.0 * (time.thread_time() - computing) / len(times)
        views = len(window.context.docks.views.tiles)
        window.close()
        garbage.deleteLater()
    figures = {"": np.median(times), "_p95": np.percentile(times, 95), "_max": np.max(times)}
    found = {f"frame_step_ms{end}": round(float(value), 2) for end, value in figures.items()}
    return {**found, "computing_ms": round(computing, 2), "views": views}


def _shows(window: Any, frame: int) -> bool:
    """Whether all visible views have painted a frame."""
    views = window.context.docks.views
    return all(views.tiles[name].camera.painted_frame == frame for name in views.visible_views())


def _until(condition: Callable[[], bool], seconds: float = 120.0) -> None:
    """Let events happen until a condition holds."""
    end = time.perf_counter() + seconds
    while not condition():
        QCoreApplication.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 2)
        if time.perf_counter() > end:
            raise TimeoutError("the window did not repaint in time")
        time.sleep(0.0002)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--frames", type=int, default=40, help="frames to step through")
    parser.add_argument("--workspace", default="annotate", help="to step in")
    args = parser.parse_args(arguments)
    print(json.dumps(frame_steps(args.recording, args.frames, args.workspace), indent=2))


if __name__ == "__main__":
    sys.exit(ended(main))
