"""A window that is given frame after frame, plays and is edited: its memory stays as it was."""

import gc
import mmap
import os
import pickle
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QObject, QSettings
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.session.jobs import Processes
from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.run_process import Prepared, RunTask, Tracked
from stereotrack_core.memory import bytes_of
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.worker_processes import TaskProcess
from tests.gui.hands import CTRL, LEFT, trigger, view
from tests.gui.kept_window import close_window, show_window
from tests.gui.long_recordings import repeated
from tests.tracking.running import tracked_frames

pytestmark = [
    pytest.mark.window,
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/statm").is_file(), reason="memory is read from /proc"),
]

FRAMES = int(os.environ.get("STEREOTRACK_ENDURANCE", "20000"))
FIRST = 2000
"""Frames until all caches are full and everything was drawn once; there have to be more."""
AT_ONCE = 40
SHORT = 8
CACHE = 8 << 20
MOST_PER_FRAME = 10_000
"""Bytes besides the arrays of a frame, which are kept on purpose: for the ten objects that hold
them, and the frame's measures."""
MOST_OBJECTS_PER_FRAME = 25
"""Containers of a frame that are kept: its estimate, pose, counts, and the clicks of the test."""


class Repeating(TaskProcess):
    """Tells of the same few frames again and again, with other numbers, as a tracker would.

    A real one would take hours for as many. It waits for the window every now and then.
    """

    def __init__(self, recording: Path) -> None:
        super().__init__()
        self.leave = threading.Semaphore(0)
        spec = RunSpec(preset("fast").replaced(fit_shape=False), preset="fast", init="tpose")
        made, done = tracked_frames(open_recording(recording), spec, range(SHORT))
        self._frames = [pickle.dumps(_sent(frame)) for frame in made]
        self._prepared = Prepared(done.body, done.origin())

    def __call__(self, task, hear=None, cancelled=lambda: False, *, listens=True):
        if not isinstance(task, RunTask):
            return
        hear(self._prepared)
        for number in task.spec.frames:
            if number % AT_ONCE == 0:
                while not self.leave.acquire(timeout=0.05):
                    if cancelled():
                        raise Cancelled
            frame = pickle.loads(self._frames[number % SHORT])
            hear(Tracked(replace(frame, frame=number), 0.02 * number))
        return


def _sent(frame):
    return replace(frame, cloud=replace(frame.cloud, depths={}))


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("recordings") / "small"
    size = SceneOptions().replaced(width=320, height=240, focal=200)
    simulate(
        folder,
        Simulation(person="P2", motion="t-pose", frames=SHORT, views="NS", seed=3, options=size),
    )
    return folder


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE


def living() -> tuple[int, int]:
    """Containers that the collector knows, and objects of Qt's that belong to windows."""
    gc.collect()
    widgets = QApplication.instance().topLevelWidgets()
    return len(gc.get_objects()), sum(len(one.findChildren(QObject)) for one in widgets)


def edit(window, turn: int) -> None:
    """Click a landmark, and now and then take it back."""
    if turn % 3 == 2:
        trigger(window, "undo")
        return
    camera = view(window)
    place = camera.rect().center()
    place.setX(place.x() + turn % 20 - 10)
    QTest.mouseClick(camera, LEFT, CTRL, place)


def test_memory_stays_as_it_was(
    qtbot, failures, kept, small, tmp_path, monkeypatch, record_testsuite_property
):
    kept.close()
    monkeypatch.setitem(FrameReader.__init__.__kwdefaults__, "cache_bytes", CACHE)
    tracker = Repeating(small)
    processes = Processes(run=tracker)
    settings = QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)
    settings.setValue("projects_folder", str(tmp_path / "projects"))
    settings.setValue("workspace", "annotate")
    window = show_window(qtbot, settings, processes)
    qtbot.addWidget(window)
    session = window.context.session
    session.open(repeated(small, tmp_path / "long", FRAMES // SHORT + AT_ONCE))
    qtbot.waitUntil(lambda: session.document.frame_set is not None)
    qtbot.waitUntil(lambda: not session.project.why_no_edit())
    asked = range(FRAMES + AT_ONCE)  # it does not end
    entry = session.track.begin(session.document.recording, asked, "tpose")
    seen = {}
    for turn in range(FRAMES // AT_ONCE):
        tracker.leave.release()
        qtbot.waitUntil(lambda turn=turn: len(entry.frames) >= (turn + 1) * AT_ONCE)
        if not session.document.playing:
            session.document.play()
        edit(window, turn)
        if (turn + 1) * AT_ONCE % 1000 == 0:
            seen[(turn + 1) * AT_ONCE] = (resident_bytes(), *living())
    numbers = bytes_of(entry.frames[0])
    session.document.pause()
    session.track.stop()
    close_window(window)
    processes.close()
    assert not failures
    said = {frames: (f"{now[0] / 1e6:.0f} MB", *now[1:]) for frames, now in seen.items()}
    record_testsuite_property(
        "frames, memory, containers, Qt objects", said
    )  # in the file of --junit-xml
    first, last, count = seen[FIRST], seen[max(seen)], max(seen) - FIRST
    grown = [(later - earlier) / count for earlier, later in zip(first, last, strict=True)]
    assert grown[0] - numbers < MOST_PER_FRAME, (numbers, said)
    assert grown[1] < MOST_OBJECTS_PER_FRAME, said
    assert grown[2] < 0.01, said
