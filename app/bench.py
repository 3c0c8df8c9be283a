"""How long the window takes from a key press until all views are painted; prints JSON."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .start import load_qt, prepare


def main(arguments: list[str] | None = None) -> int:
    """Open a recording, fill the cache, step through it by key, and say what a step takes."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("recording", type=Path)
    options.add_argument("--frames", type=int, default=40, help="number of frames to step through")
    options.add_argument("--workspace", default="annotate", help="workspace to measure")
    options.add_argument(
        "--clicks",
        type=int,
        default=0,
        help="number of clicks in the project during the measurement",
    )
    options.add_argument(
        "--tracking",
        action="store_true",
        help="track so many frames, and measure how long the event loop takes to come round",
    )
    args = options.parse_args(arguments)
    prepare(needs_screen=False)
    load_qt()
    from .services.failures import leave_out_noise

    leave_out_noise()
    if args.tracking:
        result = measure_tracking(args.recording, args.frames)
    else:
        result = measure(args.recording, args.frames, args.workspace, args.clicks)
    sys.stdout.write(json.dumps(result, indent=2) + "\n")
    return 0


def measure(recording: Path, frames: int, workspace: str, clicks: int = 0) -> dict[str, Any]:
    """Milliseconds of a step over frames that are in the cache, forth and back, and of a click.

    The project has so many clicks; for 0 there is none.
    """
    from PySide6.QtCore import QSettings
    from PySide6.QtWidgets import QApplication

    from .program import make_window
    from .services.tasks.garbage import GarbageTimer
    from .widgets.style.theme import apply_theme

    existing = QApplication.instance()
    app = existing if isinstance(existing, QApplication) else QApplication(["stereotrack"])
    with tempfile.TemporaryDirectory() as folder:
        settings = QSettings(str(Path(folder) / "bench.ini"), QSettings.Format.IniFormat)
        apply_theme(app, "dark")
        garbage = GarbageTimer()
        window, features = make_window(settings)
        window.context.session.project.makes = False
        path = _project(recording, Path(folder), clicks) if clicks else recording
        count = _open(window, path, frames, workspace)
        times, computing = _with_computing(partial(_steps, window), count)
        clicked: list[float] = []
        clicking = 0.0
        if clicks:
            click = partial(_clicks, window, features.annotate.clicking.annotating)
            clicked, clicking = _with_computing(click, count)
        opened = window.context.session.document.recording
        cameras = opened.cameras.values() if opened is not None else ()
        sizes = sorted({f"{camera.width}x{camera.height}" for camera in cameras})
        views = len(window.context.docks.views.tiles)
        window.close()
        garbage.deleteLater()
    return {
        "frame_step_ms": round(float(np.median(times)), 2),
        "frame_step_ms_p95": round(float(np.percentile(times, 95)), 2),
        "frame_step_ms_max": round(float(np.max(times)), 2),
        "frame_step_computing_ms": round(computing, 2),
        "steps": len(times),
        "views": views,
        "image_size": ", ".join(sizes),
        "workspace": workspace,
        "platform": app.platformName(),
        **(_click_times(clicked, clicking, clicks) if clicked else {}),
    }


def measure_tracking(recording: Path, frames: int) -> dict[str, Any]:
    """Milliseconds from one round of the event loop to the next while it tracks and draws.

    A timer of 5 ms notes when it comes; a round that takes longer makes it late. What the window's
    thread computes in a round does not depend on what else the machine does. The run begins in the
    T pose with `accurate`; rounds count from its first frame to its last one.
    """
    from PySide6.QtCore import QSettings
    from PySide6.QtWidgets import QApplication

    from .program import make_window
    from .services.tasks.garbage import GarbageTimer
    from .widgets.style.theme import apply_theme

    existing = QApplication.instance()
    app = existing if isinstance(existing, QApplication) else QApplication(["stereotrack"])
    with tempfile.TemporaryDirectory() as folder:
        settings = QSettings(str(Path(folder) / "bench.ini"), QSettings.Format.IniFormat)
        settings.setValue("projects_folder", folder)
        apply_theme(app, "dark")
        garbage = GarbageTimer()
        window: Any = make_window(settings)[0]
        window.resize(1366, 768)
        _open(window, recording, 0, "track")
        beats, drawn = _beats_while_tracking(window, frames)
        window.close()
        garbage.deleteLater()
    begun, end = drawn[0], drawn[-1]
    inside = np.array([beat for beat in beats if begun <= beat[0] <= end])
    rounds, computing = np.diff(inside[:, 0]) * 1e3, np.diff(inside[:, 1]) * 1e3
    return {
        "round_ms": round(float(np.median(rounds)), 2),
        "round_ms_p95": round(float(np.percentile(rounds, 95)), 2),
        "round_ms_max": round(float(np.max(rounds)), 2),
        "round_computing_ms_p95": round(float(np.percentile(computing, 95)), 2),
        "round_computing_ms_max": round(float(np.max(computing)), 2),
        "rounds": len(rounds),
        "frames_per_second": round((frames - 1) / (end - begun), 2),
        "platform": app.platformName(),
    }


def _beats_while_tracking(
    window: Any, frames: int
) -> tuple[list[tuple[float, float]], list[float]]:
    """When the beats of a timer came, with the thread's time, and when frames were drawn."""
    from PySide6.QtCore import QEventLoop, Qt, QTimer

    session = window.context.session
    beats: list[tuple[float, float]] = []
    drawn: list[float] = []
    beat, loop = QTimer(), QEventLoop()
    beat.setTimerType(Qt.TimerType.PreciseTimer)
    beat.timeout.connect(lambda: beats.append((time.perf_counter(), time.thread_time())))
    session.track.advanced.connect(lambda _: drawn.append(time.perf_counter()))
    session.track.finished.connect(loop.quit)
    beat.start(5)
    wanted = range(min(frames, session.document.frame_count))
    session.track.begin(session.document.recording, wanted, "tpose")
    loop.exec()
    beat.stop()
    return beats, drawn


def _open(window: Any, path: Path, frames: int, workspace: str) -> int:
    """Open a recording or project and show so many frames once; the number of the last one."""
    document, tasks = window.context.session.document, window.context.tasks
    window.show()
    window.activateWindow()
    window.context.session.opening.open(path)
    _until(lambda: document.frame_set is not None and tasks.settled())
    window.context.docks.show_named(workspace)
    count: int = min(frames, document.frame_count - 1)
    for frame in range(count + 1):
        document.go_to(frame)
        _until(lambda frame=frame: _painted(window) == {frame})
    return count


def _with_computing(steps: Callable[[int], list[float]], count: int) -> tuple[list[float], float]:
    """Times of all steps, and the mean time that the window's thread has computed, milliseconds."""
    begun = time.thread_time()
    times = steps(count)
    return times, 1000.0 * (time.thread_time() - begun) / max(len(times), 1)


def _project(recording: Path, folder: Path, clicks: int) -> Path:
    """Make a project of so many clicks, all landmarks in all reference images of every frame."""
    from stereotrack_core.annotation.click import Click
    from stereotrack_core.annotation.landmark_set import NINE
    from stereotrack_core.project.clicks import PlaceClicks
    from stereotrack_core.project.project import Project
    from stereotrack_core.recording.folder import open_recording

    opened = open_recording(recording)
    cameras = [view.image.camera for view in opened.views]
    random = np.random.default_rng(0)
    each = len(cameras) * len(NINE.names)
    path = folder / "bench.stereotrack"
    with Project.create(path, recording) as project:
        for first in range(0, clicks // each + 1, 100):
            project.apply(
                PlaceClicks(
                    tuple(
                        Click(frame, camera, name, (float(x), float(y)))
                        for frame in range(first, min(first + 100, clicks // each + 1))
                        for camera in cameras
                        for name, (x, y) in zip(
                            NINE.names, random.uniform(100, 300, (9, 2)), strict=True
                        )
                    )
                )
            )
    return path


def _clicks(window: Any, annotating: Any, count: int) -> list[float]:
    """Milliseconds from the press of the mouse until the click is in the file and painted."""
    from PySide6.QtCore import QPoint, Qt
    from PySide6.QtTest import QTest

    times = []
    camera = window.context.docks.views.tiles[window.context.docks.views.active].camera
    annotating.set_advance("none")
    for k in range(count):
        annotating.let_go()
        place = QPoint(100 + 3 * k % 150, 60 + 7 * k % 100)
        begun = time.perf_counter()
        QTest.mouseClick(
            camera, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier, place
        )
        camera.repaint()
        times.append(1000.0 * (time.perf_counter() - begun))
    return times


def _click_times(times: list[float], computing: float, clicks: int) -> dict[str, Any]:
    return {
        "click_computing_ms": round(computing, 2),
        "clicks": clicks,
        "click_to_paint_ms": round(float(np.median(times)), 2),
        "click_to_paint_ms_p95": round(float(np.percentile(times, 95)), 2),
    }


def _painted(window: Any) -> set[int]:
    """Frames that the visible views have painted."""
    return {
        window.context.docks.views.tiles[name].camera.painted_frame
        for name in window.context.docks.views.visible_views()
    }


def _steps(window: Any, count: int) -> list[float]:
    """Milliseconds from a key press to the last repaint, back and forth over cached frames."""
    from PySide6.QtCore import Qt
    from PySide6.QtTest import QTest

    times = []
    for key, step in ((Qt.Key.Key_Left, -1), (Qt.Key.Key_Right, 1)):
        for _ in range(count):
            wanted = window.context.session.document.frame + step
            begun = time.perf_counter()
            QTest.keyClick(window, key)
            _until(lambda wanted=wanted: _painted(window) == {wanted})
            times.append(1000.0 * (time.perf_counter() - begun))
    return times


def _until(condition: Any, seconds: float = 120.0) -> None:
    """Let events happen until a condition holds."""
    from PySide6.QtCore import QCoreApplication, QEventLoop

    end = time.perf_counter() + seconds
    while not condition():
        QCoreApplication.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 2)
        if time.perf_counter() > end:
            raise TimeoutError("the window did not repaint in time")
        time.sleep(0.0002)


if __name__ == "__main__":
    sys.exit(main())
