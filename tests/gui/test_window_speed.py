"""The script that measures the window."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.window
SCRIPT = Path(__file__).parents[2] / "benchmarks" / "window.py"


def test_frame_steps_are_measured(small_recording):
    done = subprocess.run(
        [sys.executable, SCRIPT, small_recording, "--frames", "4"],
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frame_step_ms"] > 0
