"""Compiled loops: numba is loaded at the first call, and the functions they call are compiled."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import stereotrack_core
from stereotrack_core.simulation.make import Simulation, simulate
from stereotrack_core.simulation.rig import SceneOptions


def test_decorating_does_not_load_numba():
    script = "import sys, stereotrack_core.tracking.model; print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n"


def _run(script, *paths, **variables):
    environment = {**os.environ, **variables, "PYTHONPATH": os.pathsep.join(map(str, paths))}
    command = [sys.executable, "-P", "-c", script]  # -P: nothing of the working directory
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert not done.returncode, done.stderr
    return done.stdout.split()


def _edit(file, old, new):
    text = file.read_text("utf-8")
    assert old in text
    file.write_text(text.replace(old, new), "utf-8")


_VALUES = {
    "values.py": "LIMIT = 2\nTABLE = np.array([1.0, 2.0])\n",
    "deep.py": "@compiled()\ndef deep(x):\n    return x + 10\n",
    "callee.py": "from deep import deep\n@compiled()\ndef callee(x):\n    return deep(x) + 100\n",
    "caller.py": "from callee import callee\nfrom values import LIMIT, TABLE\n@compiled()\n"
    "def caller(x):\n    return callee(x) + LIMIT + TABLE[1]\n"
    "print(caller(0), sum(caller.machine().stats.cache_hits.values()))\n",
}


@pytest.fixture
def caller(tmp_path):
    """A program of four files with compiled functions and values; prints what it returns."""
    for name, text in _VALUES.items():
        imports = "import numpy as np\nfrom stereotrack_core.compiled import compiled\n"
        (tmp_path / name).write_text(imports + text, "utf-8")
    root = Path(stereotrack_core.__file__).parents[1]
    # Python's own cache takes a file of the same size and second for unchanged.
    variables = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    return lambda: _run("import caller", tmp_path, root, **variables)


def test_constants_and_functions_that_callees_call_count_as_well(caller, tmp_path):
    assert caller() == ["114.0", "0"]
    assert caller() == ["114.0", "1"], "read from the drive"
    _edit(tmp_path / "deep.py", "10", "20")
    assert caller() == ["124.0", "0"]
    _edit(tmp_path / "values.py", "LIMIT = 2", "LIMIT = 3")
    assert caller() == ["125.0", "0"]
    _edit(tmp_path / "values.py", "[1.0, 2.0]", "[1.0, 4.0]")
    assert caller() == ["127.0", "0"]


_STARTS = """
import sys, threading
from pathlib import Path
start, loaded = threading.Thread.start, []
def told(thread):
    loaded.append("scipy.linalg" in sys.modules)
    start(thread)
threading.Thread.start = told
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
import queue
from app.session.jobs import Job, TaskList
from app.session.messages import Loop
posted = queue.SimpleQueue()
TaskList(Loop(posted.put, None), print, lambda: None).run(Job("work", lambda task: None))
posted.get()()
"""


@pytest.mark.parametrize("work", [_CLOUDS, _WINDOW], ids=["clouds", "window"])
def test_scipy_linalg_is_loaded_before_threads_start(work, tmp_path):
    """Else numba and scipy.special load parts of it from opposite ends, and one of them fails."""
    if work is _CLOUDS:
        size = SceneOptions().replaced(width=160, height=120, focal=100)
        simulate(tmp_path / "made", Simulation(frames=1, views="N", options=size))
    script = f"{_STARTS}{work}print(loaded and all(loaded))"
    command = [sys.executable, "-c", script, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stdout.endswith("True\n"), done.stderr
