"""Compiled loops: numba is loaded at the first call, and the functions they call are compiled."""

from __future__ import annotations

import subprocess
import sys

import pytest

from stereotrack_core.compiled import compiled
from stereotrack_core.simulation.make import simulate
from stereotrack_core.simulation.rig import SceneOptions


@compiled(inline="always")
def _next(x):
    """One more."""
    return x + 1


@compiled()
def _count(x, upto):
    while x < upto:
        x = _next(x)
    return x


def test_a_loop_calls_another_and_both_are_compiled():
    assert _count(2, 7) == 7
    assert _count.machine().signatures, "numba has compiled it"
    assert _next(1) == 2
    assert _next.__doc__ == "One more."


def test_decorating_does_not_load_numba():
    script = "import sys, stereotrack_core.tracking.tracker; print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n"


_STARTS = """
import sys, threading
from pathlib import Path
start, loaded = threading.Thread.start, []
def told(thread):
    loaded.append("scipy.linalg" in sys.modules)
    start(thread)
threading.Thread.start = told
"""
_SIMULATED = """
from stereotrack_core.simulation.make import simulate
from stereotrack_core.simulation.rig import SceneOptions
size = SceneOptions().replaced(width=160, height=120, focal=100)
simulate(Path(sys.argv[1]) / "again", frames=1, views="N", options=size)
"""
_CLOUDS = """
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.tracking.presets import preset
recording = open_recording(Path(sys.argv[1]) / "made")
with FrameReader(recording) as reader:
    frame_set = reader.frame_set(0)
    loaded.clear()  # readers decode, and call no loop
    chain = DepthChain(recording, preset("fast").depth)
    chain.process(frame_set)
    chain.close()
"""
_WINDOW = """
from PySide6.QtCore import QCoreApplication
from app.services.tasks.task import Task
program = QCoreApplication([])
task = Task("work", lambda task: None)
task.finished.connect(program.quit)
task.start()
program.exec()
"""


@pytest.mark.parametrize("work", [_SIMULATED, _CLOUDS, _WINDOW], ids=["made", "clouds", "window"])
def test_scipy_linalg_is_loaded_before_threads_start(work, tmp_path):
    """Else numba and scipy.special load parts of it from opposite ends, and one of them fails."""
    if work is _CLOUDS:
        size = SceneOptions().replaced(width=160, height=120, focal=100)
        simulate(tmp_path / "made", frames=1, views="N", options=size)
    script = f"{_STARTS}{work}print(loaded and all(loaded))"
    command = [sys.executable, "-c", script, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stdout.endswith("True\n"), done.stderr
